#pragma once

#include <cmath>
#include <numbers>

#include "perimpm/error.hpp"
#include "perimpm/model/params.hpp"

/*! The horizon of a bond law and the influence of its bonds, w^(r) with r = |X|/horizon. */
namespace perimpm::peridynamics {

constexpr ParamSpec horizon_param() {
    return {
        .key = "horizon", .unit = "spacings", .range = above(1), .default_value = 3.015, .doc = "how far bonds reach"};
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
            .default_text = "constant",
            .choices = "constant|linear|cubic|gaussian|inverse",
            .doc =
                "weight of a bond of length r horizons: the same for all, 1 - r (the paper's), 1 - 3 r^2 + 2 r^3, "
                "exp(-4 r^2), or 1/r"};
}

class Influence {
public:
    Influence(const Params& p, double horizon) : horizon_{horizon} {
        constexpr const char* names[] = {"constant", "linear", "cubic", "gaussian", "inverse"};
        for (int k = 0; k < 5; ++k)
            if (p.is("influence", names[k])) kind_ = static_cast<Kind>(k);
    }
    bool is_constant() const { return kind_ == Kind::constant; }
    /// Bonds that reach the rim weigh nothing: they are no bonds.
    double reach() const { return kind_ == Kind::linear || kind_ == Kind::cubic ? horizon_ * (1 - 1e-9) : horizon_; }
    double operator()(double X) const {
        const double r = X / horizon_;
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

private:
    enum class Kind { constant, linear, cubic, gaussian, inverse };
    Kind kind_ = Kind::constant;
    double horizon_;
};

constexpr ParamSpec volume_correction_param() {
    return {.key = "volume_correction",
            .kind = ParamKind::choice,
            .default_text = "none",
            .choices = "none|linear",
            .doc = "\"linear\" counts of neighbours at the rim of the horizon only the share that lies inside"};
}
/// Share of a neighbour's cell of width h that lies inside the horizon (Parks et al. 2008).
inline double share_inside(double X, double horizon, double h) {
    return std::fmin(std::fmax((horizon - X) / h + 0.5, 0.0), 1.0);
}
/// How far the centres of cells of width h that reach into the horizon may lie.
inline double reach_of_cells(double horizon, double h) { return horizon + 0.5 * h * (1 - 1e-9); }

}  // namespace perimpm::peridynamics
