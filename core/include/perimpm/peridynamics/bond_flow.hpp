#pragma once

#include <vector>

#include "perimpm/error.hpp"
#include "perimpm/model/params.hpp"
#include "perimpm/peridynamics/family_slice.hpp"
#include "perimpm/peridynamics/weights.hpp"

/*! Yielding of bonds in shear. With M the law's modulus (2 mu + lambda of Lyu et al. 2019, 15 mu of the linear peridynamic
    solid) and S = w_pq V_p V_q/|X|^2:
      (1) e_dev = (|Y| - |X|)/|X| - theta/3,  E = g (e_dev - e_p),  g = M S |X| / (V_p V_q)     deviatoric stress [N/m^6]
      (2) bond    E^2/2 <= psi                                  each bond by itself
          family  sum_q E^2 V_q / 2 <= psi                      Mitchell 2011 (SAND2011-3166)
      (3) consistent  De_p = excess strain / (1 + h) along e_dev - e_p: lands on (2)
          paper       the same times M/lambda (eq. 11 of Lyu et al., dimensions mended): misses (2)
      (4) yield strain of a bond: sqrt(2 psi)/g, or sigma_y/sigma_per_strain, which is where the bond along the axis of a bar
          in tension yields at the stress sigma_y; it grows by h times the strain yielded, h = H/sigma_per_strain
    For a family the strain in (3), (4) is sqrt(5 sum E^2 V / sum g^2 V): e_dev of the bond along the axis in tension. */
namespace perimpm::peridynamics {

constexpr ParamSpec yield_stress_param() {
    return {.key = "yield_stress",
            .unit = "Pa",
            .range = above(0),
            .optional = true,
            .doc = "stress in tension at which the material yields; without yield_stress and yield_psi it never does"};
}
constexpr ParamSpec yield_rule_param(const char* standard) {
    return {.key = "yield",
            .kind = ParamKind::choice,
            .default_text = standard,
            .choices = "bond|family",
            .doc = "what yields: each bond by itself, or all bonds of a particle together"};
}
constexpr ParamSpec hardening_param() {
    return {.key = "hardening_modulus",
            .unit = "Pa",
            .range = at_least(0),
            .default_value = 0,
            .doc = "growth of the yield stress per strain yielded"};
}

class BondFlow {
public:
    static constexpr bool kMayYield = true;
    /// Indices of fields.
    struct Fields {
        int own = -1;                                    ///< constant of bonds, the caller's
        int strain = -1, opposite = -1, hardening = -1;  ///< of bonds
        int dilatation = -1, family_hardening = -1;      ///< of particles, as the next two
        int dilatation_moment = -1;                      ///< -1: the caller has its own dilatation
        int has_yielded = -1;                            ///< 1 once a bond of the family did, else 0
    };

    /// `modulus`: M; `return_factor`: of (3); `stress_per_strain`: of (4) [Pa].
    BondFlow(const Params& p, double modulus, double stress_per_strain, double return_factor, const char* psi_key)
        : modulus_{modulus},
          family_{p.is("yield", "family")},
          factor_{return_factor},
          hardening_{p["hardening_modulus"] / stress_per_strain},
          by_stress_{p.given("yield_stress")},
          active_{by_stress_ || p.given(psi_key)},
          limit_{by_stress_ ? p["yield_stress"] / stress_per_strain
                 : active_  ? std::sqrt(2 * p[psi_key])
                            : 0} {
        if (by_stress_ && p.given(psi_key))
            throw InvalidParameter(psi_key, "contradicts yield_stress: give one of the two");
        if (active_ && p.context().dimension < 3)
            throw InvalidParameter(
                by_stress_ ? "yield_stress" : psi_key,
                "is for solids: how bonds yield in a sheet or a strand is not defined; leave it out");
        for (const char* key : {"yield", "hardening_modulus"})
            if (!active_ && p.given(key)) throw InvalidParameter(key, "needs yield_stress or a yield energy beside it");
    }
    bool active() const { return active_; }

    /// `dilatation`: where the law already has it, else -1.
    Fields declare(int own, std::vector<FieldSpec>& particles, std::vector<FieldSpec>& bonds,
                   int dilatation = -1) const {
        const auto add = [](std::vector<FieldSpec>& to, const FieldSpec& spec) {
            to.push_back(spec);
            return static_cast<int>(to.size()) - 1;
        };
        Fields at{.own = own};
        at.strain = add(bonds, {.name = "plastic_strain", .doc = "e_p, what the bond has yielded, over its length"});
        at.opposite = add(bonds, {.name = "opposite", .doc = "place of the bond in the family of its other end"});
        at.dilatation = dilatation;
        if (dilatation < 0) {
            at.dilatation = add(particles, {.name = "dilatation", .doc = "theta, the relative change of volume"});
            at.dilatation_moment = add(
                particles, {.name = "dilatation_moment", .unit = "m^5", .doc = "sum S |X|^4 over the whole family"});
        }
        at.has_yielded = add(particles, {.name = "has_yielded", .doc = "1 once a bond of the family yielded, else 0"});
        if (hardening_ > 0 && !family_)
            at.hardening = add(bonds, {.name = "yielded", .doc = "strain yielded so far, either way"});
        if (family_)
            at.family_hardening = add(particles, {.name = "yielded", .doc = "strain yielded so far, either way"});
        return at;
    }

    /// Round 1 of a law's `initialise`.
    template <class Real>
    void initialise(Block<Real>& b, const Fields& at) const {
        const std::uint32_t* row = b.family.row - b.first;
        for (std::uint32_t i = 0; i < b.size; ++i) {
            double moment = 0;
            for (std::uint32_t slot = b.family.row[i]; slot < b.family.row[i + 1]; ++slot) {
                b.bond_state[at.opposite][slot] =
                    static_cast<Real>(opposite_slot(b, i, slot) - row[b.family.neighbour[slot]]);
                const std::uint32_t constant = constant_of(b.family, i, slot);
                const double X = static_cast<double>(b.family.length[constant]);
                moment += static_cast<double>(b.bond_constants[at.own][constant]) * X * X * X * X;
            }
            if (at.dilatation_moment >= 0) b.particle_state[at.dilatation_moment][0][i] = static_cast<Real>(moment);
        }
    }

    /// Part of a law's `prepare`: the dilatation sum S |X|^3 e over the live bonds to sum S |X|^4 over all, three times,
    /// and the return mapping.
    template <class Real>
    void advance(Block<Real>& b, const Fields& at) const {
        using P = Pack<Real>;
        for_each_family(b, [&](const auto& family) PERIMPM_INLINE_LAMBDA {
            P expansion(0);
            const auto expand = [&](const auto& bonds, const P& live, const P*,
                                    const Root<P>& y) PERIMPM_INLINE_LAMBDA {
                const P X = bonds.length();
                expansion += live * bonds.constant(b.bond_constants[at.own]) * X * X * X * (y.root - X);
            };
            family.for_each_length(fetch_only, expand);
            const auto moment = family.at(b.particle_state[at.dilatation_moment][0]);
            family.put(b.particle_state[at.dilatation][0], Real(3) * family.total(expansion) * inverse_length(moment));
            yield(b, family, at);
        });
    }

    /// The return mapping of a family, or of those of a slice, for their dilatation.
    template <class Real>
    void yield(Block<Real>& b, const OneFamily<Real>& family, const Fields& at) const {
        const std::uint32_t i = family.index();
        const Real theta = b.particle_state[at.dilatation][0][i];
        if (family_ ? yield_together(b, i, theta, at) : yield_apart(b, i, theta, at))
            b.particle_state[at.has_yielded][0][i] = 1;
    }
    /// Families go one by one where some have yielded, and where some may yield now.
    template <class Real>
    void yield(Block<Real>& b, const FamilySlice<Real>& slice, const Fields& at) const {
        using P = Pack<Real>;
        P may = slice.at(b.particle_state[at.has_yielded][0]);
        may = any_of(may != P(0)) ? P(1) : family_ ? may_yield_together(b, slice, at) : may_yield_apart(b, slice, at);
        for (std::uint32_t lane = 0; lane < kLanes<Real>; ++lane)
            if (may[lane] != 0) yield(b, OneFamily<Real>(b, slice.first() + lane), at);
    }

    /// Whether no bond of the slice has yielded, at neither end.
    template <class Real>
    PERIMPM_INLINE bool is_elastic(const Block<Real>& b, const FamilySlice<Real>& slice, const Fields& at) const {
        Pack<Real> any = slice.at(b.particle_state[at.has_yielded][0]);
        if (any_of(any != Pack<Real>(0))) return false;
        slice.for_each_entry([&](const SliceEntry<Real>& bonds)
                                 PERIMPM_INLINE_LAMBDA { any += bonds.gather(b.family_state[at.has_yielded][0]); });
        return all(any == Pack<Real>(0));
    }

    /// e_p of the bonds as their other ends have it.
    template <class Real>
    PERIMPM_INLINE Pack<Real> at_other_end(const Block<Real>& b, const BondPack<Real>& bonds, const Fields& at) const {
        const std::uint32_t* row = b.family.row - b.first;
        const Real *strain = b.bond_state[at.strain], *opposite = b.bond_state[at.opposite] + bonds.slot;
        return Pack<Real>([&](std::size_t lane) {
            if (lane >= bonds.size) return Real(0);
            return strain[row[bonds.neighbour(lane)] + static_cast<std::uint32_t>(opposite[lane])];
        });
    }

private:
    template <class Real>
    static Pack<Real> volume(const Block<Real>& b, const BondPack<Real>& bonds) {
        return bonds.gather(b.family.volume);
    }
    template <class Real>
    static Pack<Real> volume(const Block<Real>&, const SliceEntry<Real>& bonds) {
        return bonds.volume();
    }
    /// e_dev - e_p, and g of (1), for the |Y|, theta, e_p and V_p of the bonds.
    template <class Real, class Bonds>
    PERIMPM_INLINE void state(const Block<Real>& b, const Bonds& bonds, const Pack<Real>& y, const Pack<Real>& theta,
                              const Pack<Real>& strain, const Pack<Real>& own_volume, const Fields& at,
                              Pack<Real>& elastic, Pack<Real>& g) const {
        const Pack<Real> X = bonds.length();
        elastic = (y - X) * inverse_length(X) - theta / 3 - strain;
        g = static_cast<Real>(modulus_) * bonds.constant(b.bond_constants[at.own]) * X /
            (own_volume * volume(b, bonds));
    }
    template <class Real>
    void state(const Block<Real>& b, std::uint32_t i, const BondPack<Real>& bonds, Real theta, const Fields& at,
               Pack<Real>& elastic, Pack<Real>& g) const {
        Pack<Real> Y[3];
        bonds.difference(b.family.position, b.family.position + 4 * std::size_t{b.first + i}, Y);
        state(b, bonds, norm(Y), Pack<Real>(theta), bonds.load(b.bond_state[at.strain]), Pack<Real>(b.volume[i]), at,
              elastic, g);
    }
    /// The bond's limit of |e_dev - e_p|, without hardening.
    template <class P>
    PERIMPM_INLINE P limit_of(const P& g) const {
        const P limit(static_cast<Scalar<P>>(limit_));
        return by_stress_ ? limit : limit * inverse_length(g);
    }
    /// A power of two by which g is small enough for its square to be a number of single precision.
    template <class Real>
    Real unit_of(Real volume) const {
        return static_cast<Real>(std::exp2(-std::ilogb(modulus_ / static_cast<double>(volume))));
    }

    /// Calls body(bonds, e_dev, g) for the bonds of a slice that has not yielded.
    template <class Real, class Body>
    PERIMPM_INLINE void for_each_state(const Block<Real>& b, const FamilySlice<Real>& slice, const Fields& at,
                                       Body body) const {
        using P = Pack<Real>;
        const P theta = slice.at(b.particle_state[at.dilatation][0]), V = slice.at(b.volume);
        slice.for_each_length(fetch_only,
                              [&](const auto& bonds, const P&, const P*, const Root<P>& y) PERIMPM_INLINE_LAMBDA {
                                  P elastic, g;
                                  state(b, bonds, y.root, theta, P(0), V, at, elastic, g);
                                  body(bonds, elastic, g);
                              });
    }
    /// Other than 0 in the lanes whose families yield, or nearly so.
    template <class Real>
    Pack<Real> may_yield_apart(const Block<Real>& b, const FamilySlice<Real>& slice, const Fields& at) const {
        using P = Pack<Real>;
        P may(0);
        for_each_state(b, slice, at, [&](const auto&, const P& elastic, const P& g) PERIMPM_INLINE_LAMBDA {
            may = select(g > P(0) && abs(elastic) + kRounding<Real> > kNearly<Real> * limit_of(g), P(1), may);
        });
        return may;
    }
    template <class Real>
    Pack<Real> may_yield_together(const Block<Real>& b, const FamilySlice<Real>& slice, const Fields& at) const {
        using P = Pack<Real>;
        const Real unit = unit_of(b.volume[slice.first()]);
        P stress2(0), gain2(0);
        for_each_state(b, slice, at, [&](const auto& bonds, const P& elastic, const P& g) PERIMPM_INLINE_LAMBDA {
            const P scaled = unit * g, weight = scaled * scaled * bonds.volume();
            gain2 += weight, stress2 += weight * elastic * elastic;
        });
        const P five_per_gain = Real(5) * inverse_length(gain2), limit(static_cast<Real>(limit_));
        const P allowed = by_stress_ ? limit : limit * unit * sqrt(five_per_gain);
        return select(sqrt(stress2 * five_per_gain) + kRounding<Real> > kNearly<Real> * allowed, P(1), P(0));
    }
    /// A few roundings, of strains; and as many below 1.
    template <class Real>
    static constexpr Real kRounding = 16 * std::numeric_limits<Real>::epsilon();
    template <class Real>
    static constexpr Real kNearly = 1 - 64 * std::numeric_limits<Real>::epsilon();

    /// Whether any bond yields.
    template <class Real>
    bool yield_apart(Block<Real>& b, std::uint32_t i, Real theta, const Fields& at) const {
        using P = Pack<Real>;
        const P factor(static_cast<Real>(factor_ / (1 + hardening_)));
        bool yields = false;
        for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P elastic, g;
            state(b, i, bonds, theta, at, elastic, g);
            P allowed = limit_of(g);
            if (at.hardening >= 0) allowed += static_cast<Real>(hardening_) * bonds.load(b.bond_state[at.hardening]);
            const P excess = abs(elastic) - allowed;
            const auto over = g > P(0) && live > P(0) && excess > P(0);
            if (!any_of(over)) return;
            yields = true;
            const P flow = select(over, factor * excess, P(0));
            Real* strain = b.bond_state[at.strain] + bonds.slot;
            store(strain, P(bonds.load(b.bond_state[at.strain]) + copysign(flow, elastic)), bonds.size);
            if (at.hardening < 0) return;
            store(b.bond_state[at.hardening] + bonds.slot, P(bonds.load(b.bond_state[at.hardening]) + flow),
                  bonds.size);
        });
        return yields;
    }

    /// Whether the family yields.
    template <class Real>
    bool yield_together(Block<Real>& b, std::uint32_t i, Real theta, const Fields& at) const {
        using P = Pack<Real>;
        const Real unit = unit_of(b.volume[i]);
        P stress2(0), gain2(0);
        for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P elastic, g;
            state(b, i, bonds, theta, at, elastic, g);
            g *= unit;
            const P weight = live * g * g * bonds.gather(b.family.volume);
            gain2 += weight, stress2 += weight * elastic * elastic;
        });
        const double gain = static_cast<double>(reduce(gain2));
        if (gain <= 0) return false;
        const double strain = std::sqrt(5 * static_cast<double>(reduce(stress2)) / gain);
        Real& yielded = b.particle_state[at.family_hardening][0][i];
        const double allowed =
            (by_stress_ ? limit_ : limit_ * double(unit) * std::sqrt(5 / gain)) + hardening_ * double(yielded);
        if (strain <= allowed) return false;
        const double flow = factor_ * (strain - allowed) / (1 + hardening_);
        yielded += static_cast<Real>(flow);
        const P share(static_cast<Real>(flow / strain));
        for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P elastic, g;
            state(b, i, bonds, theta, at, elastic, g);
            store(b.bond_state[at.strain] + bonds.slot, P(bonds.load(b.bond_state[at.strain]) + live * share * elastic),
                  bonds.size);
        });
        return true;
    }

    double modulus_;
    bool family_;
    double factor_, hardening_;
    bool by_stress_, active_;
    double limit_;  ///< yield strain, or sqrt(2 psi)
};

}  // namespace perimpm::peridynamics
