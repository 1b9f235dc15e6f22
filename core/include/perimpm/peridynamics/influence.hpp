#pragma once

#include <cmath>
#include <numbers>

#include "perimpm/error.hpp"
#include "perimpm/model/params.hpp"

/*! The horizon of a bond law, the influence of its bonds, w^(r) with r = |X|/horizon, and what counts of a neighbour. */
namespace perimpm::peridynamics {

constexpr ParamSpec horizon_param() {
    return {
        .key = "horizon", .unit = "spacings", .range = above(1), .default_value = 2.2, .doc = "how far bonds reach"};
}
constexpr ParamSpec horizon_length_param() {
    return {.key = "horizon_length",
            .unit = "m",
            .range = above(0),
            .optional = true,
            .doc = "how far bonds reach, in metres instead of spacings"};
}
/// From the keys `horizon` and `horizon_length` [m].
inline double horizon_of(const Params& p) {
    if (!p.given("horizon_length")) return p["horizon"] * p.context().particle_spacing;
    if (p.given("horizon")) throw InvalidParameter("horizon_length", "contradicts 'horizon': give one of the two");
    if (p["horizon_length"] <= p.context().particle_spacing)
        throw InvalidParameter("horizon_length", "must be above the particles' spacing, or there are no bonds");
    return p["horizon_length"];
}

constexpr ParamSpec influence_param() {
    return {.key = "influence",
            .kind = ParamKind::choice,
            .default_text = "linear",
            .choices = "constant|linear|cubic|gaussian|inverse",
            .doc =
                "weight of a bond of length r horizons: the same for all, 1 - r (the paper's), 1 - 3 r^2 + 2 r^3, "
                "exp(-4 r^2), or 1/r"};
}

constexpr ParamSpec volume_correction_param() {
    return {
        .key = "volume_correction",
        .kind = ParamKind::choice,
        .default_text = "none",
        .choices = "none|linear|centred",
        .doc =
            "\"linear\" counts of neighbours at the rim of the horizon only the share that lies inside; \"centred\" "
            "the same of those whose centres lie inside, as LAMMPS does"};
}

/// Share of a neighbour's volume that counts: all of it, or clip((delta - |X|)/h + 1/2, 0, 1), the part of its cell of
/// width h inside the horizon delta (Parks et al. 2008), cells whose centres lie beyond included unless it is "centred".
class VolumeShare {
public:
    VolumeShare(const Params& p, double horizon)
        : horizon_{horizon},
          spacing_{p.context().particle_spacing},
          partial_{!p.is("volume_correction", "none")},
          beyond_{p.is("volume_correction", "linear")} {}
    bool is_whole() const { return !partial_; }
    BondVolumes volumes() const { return {.radius = horizon_, .rim = partial_ ? spacing_ : 0.0}; }
    double reach() const { return beyond_ ? horizon_ + 0.5 * spacing_ * (1 - 1e-9) : horizon_; }
    double operator()(double X) const { return volumes()(X); }

private:
    double horizon_, spacing_;
    bool partial_, beyond_;
};

/// The weight of a bond by its length: w^ times the share of the neighbour's volume.
class Influence {
public:
    Influence(const Params& p, double horizon) : horizon_{horizon}, share_{p, horizon} {
        constexpr const char* names[] = {"constant", "linear", "cubic", "gaussian", "inverse"};
        for (int k = 0; k < 5; ++k)
            if (p.is("influence", names[k])) kind_ = static_cast<Kind>(k);
    }
    bool is_constant() const { return kind_ == Kind::constant && share_.is_whole(); }
    /// Bonds that reach the rim weigh nothing: they are no bonds.
    double reach() const { return vanishes() ? horizon_ * (1 - 1e-9) : share_.reach(); }
    double operator()(double X) const { return share_(X) * at(X / horizon_); }
    BondVolumes volumes() const { return share_.volumes(); }

private:
    enum class Kind { constant, linear, cubic, gaussian, inverse };

    bool vanishes() const { return kind_ == Kind::linear || kind_ == Kind::cubic; }
    double at(double r) const {
        if (vanishes() && r >= 1) return 0;
        switch (kind_) {
            case Kind::linear:
                return 1 - r;
            case Kind::cubic:
                return 1 - r * r * (3 - 2 * r);
            case Kind::gaussian:
                return std::exp(-4 * r * r);
            case Kind::inverse:
                return 1 / r;
            default:
                return 1;
        }
    }

    Kind kind_ = Kind::constant;
    double horizon_;
    VolumeShare share_;
};

}  // namespace perimpm::peridynamics
