#pragma once

#include <vector>

#include "perimpm/error.hpp"
#include "perimpm/model/params.hpp"
#include "perimpm/peridynamics/family.hpp"
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
        int dilatation = -1, family_hardening = -1;      ///< of particles
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
        if (dilatation < 0)
            at.dilatation = add(particles, {.name = "dilatation", .doc = "theta, the relative change of volume"});
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
        for (std::uint32_t slot = b.family.row[0], i = 0; i < b.size; ++i)
            for (; slot < b.family.row[i + 1]; ++slot)
                b.bond_state[at.opposite][slot] =
                    static_cast<Real>(opposite_slot(b, i, slot) - row[b.family.neighbour[slot]]);
    }

    /// Part of a law's `prepare`: the dilatation sum S |X|^3 e over the live bonds to sum S |X|^4 over all, three times,
    /// and the return mapping.
    template <class Real>
    void advance(Block<Real>& b, const Fields& at) const {
        for (std::uint32_t i = 0; i < b.size; ++i) {
            Pack<Real> expansion(0);
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const Pack<Real>& live) PERIMPM_INLINE_LAMBDA {
                const Pack<Real> X = bonds.length();
                expansion += live * bonds.constant(b.bond_constants[at.own]) * X * X * X * extension(b, i, bonds, X);
            });
            double moment = 0;
            for (std::uint32_t slot = b.family.row[i]; slot < b.family.row[i + 1]; ++slot) {
                const std::uint32_t constant = constant_of(b.family, i, slot);
                const double X = static_cast<double>(b.family.length[constant]);
                moment += static_cast<double>(b.bond_constants[at.own][constant]) * X * X * X * X;
            }
            const Real theta = moment > 0 ? 3 * reduce(expansion) / static_cast<Real>(moment) : Real(0);
            b.particle_state[at.dilatation][0][i] = theta;
            yield(b, i, theta, at);
        }
    }

    /// The return mapping of particle i for its dilatation.
    template <class Real>
    void yield(Block<Real>& b, std::uint32_t i, Real theta, const Fields& at) const {
        family_ ? yield_together(b, i, theta, at) : yield_apart(b, i, theta, at);
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
    static Pack<Real> extension(const Block<Real>& b, std::uint32_t i, const BondPack<Real>& bonds,
                                const Pack<Real>& X) {
        Pack<Real> Y[3];
        bonds.difference(b.family.position, b.family.position + 4 * std::size_t{b.first + i}, Y);
        return norm(Y) - X;
    }
    /// e_dev - e_p, and g of (1).
    template <class Real>
    void state(const Block<Real>& b, std::uint32_t i, const BondPack<Real>& bonds, Real theta, const Fields& at,
               Pack<Real>& elastic, Pack<Real>& g) const {
        const Pack<Real> X = bonds.length();
        elastic = extension(b, i, bonds, X) * inverse_length(X) - theta / 3 - bonds.load(b.bond_state[at.strain]);
        g = static_cast<Real>(modulus_) * bonds.constant(b.bond_constants[at.own]) * X /
            (b.volume[i] * bonds.gather(b.family.volume));
    }

    template <class Real>
    void yield_apart(Block<Real>& b, std::uint32_t i, Real theta, const Fields& at) const {
        using P = Pack<Real>;
        const P factor(static_cast<Real>(factor_ / (1 + hardening_))), limit(static_cast<Real>(limit_));
        for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P elastic, g, allowed = limit;
            state(b, i, bonds, theta, at, elastic, g);
            const auto pulls = g > P(0);  // moment-exact weights may be negative: such bonds only balance others
            if (!by_stress_) allowed = limit / select(pulls, g, P(1));
            if (at.hardening >= 0) allowed += static_cast<Real>(hardening_) * bonds.load(b.bond_state[at.hardening]);
            const P excess = abs(elastic) - allowed;
            const auto over = pulls && live > P(0) && excess > P(0);
            if (!any_of(over)) return;
            const P flow = select(over, factor * excess, P(0));
            Real* strain = b.bond_state[at.strain] + bonds.slot;
            store(strain, P(bonds.load(b.bond_state[at.strain]) + copysign(flow, elastic)), bonds.size);
            if (at.hardening < 0) return;
            store(b.bond_state[at.hardening] + bonds.slot, P(bonds.load(b.bond_state[at.hardening]) + flow),
                  bonds.size);
        });
    }

    template <class Real>
    void yield_together(Block<Real>& b, std::uint32_t i, Real theta, const Fields& at) const {
        using P = Pack<Real>;
        // g^2 of small particles is beyond single precision; a power of two changes no other bit
        const auto unit = static_cast<Real>(std::exp2(-std::ilogb(modulus_ / static_cast<double>(b.volume[i]))));
        P stress2(0), gain2(0);
        for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P elastic, g;
            state(b, i, bonds, theta, at, elastic, g);
            g *= unit;
            const P weight = live * g * g * bonds.gather(b.family.volume);
            gain2 += weight, stress2 += weight * elastic * elastic;
        });
        const double gain = static_cast<double>(reduce(gain2));
        if (gain <= 0) return;
        const double strain = std::sqrt(5 * static_cast<double>(reduce(stress2)) / gain);
        Real& yielded = b.particle_state[at.family_hardening][0][i];
        const double allowed =
            (by_stress_ ? limit_ : limit_ * double(unit) * std::sqrt(5 / gain)) + hardening_ * double(yielded);
        if (strain <= allowed) return;
        const double flow = factor_ * (strain - allowed) / (1 + hardening_);
        yielded += static_cast<Real>(flow);
        const P share(static_cast<Real>(flow / strain));
        for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P elastic, g;
            state(b, i, bonds, theta, at, elastic, g);
            store(b.bond_state[at.strain] + bonds.slot, P(bonds.load(b.bond_state[at.strain]) + live * share * elastic),
                  bonds.size);
        });
    }

    double modulus_;
    bool family_;
    double factor_, hardening_;
    bool by_stress_, active_;
    double limit_;  ///< yield strain, or sqrt(2 psi)
};

}  // namespace perimpm::peridynamics
