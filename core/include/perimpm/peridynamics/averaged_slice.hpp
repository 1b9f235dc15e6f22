#pragma once

#include "perimpm/peridynamics/averaged_family.hpp"
#include "perimpm/peridynamics/family_slice.hpp"

namespace perimpm::peridynamics {

/// The sums of AveragedFamily for a slice, a family in each lane.
template <class Real>
class AveragedSlice {
    using P = Pack<Real>;

public:
    AveragedSlice(const Block<Real>& b, const BondFields& at, std::uint32_t i) : b_{b}, at_{at}, families_{b, i} {}
    const FamilySlice<Real>& families() const { return families_; }

    /// AveragedFamily::sum_bonds.
    PERIMPM_INLINE void sum_bonds(P sums[12], P& largest) const {
        const Real* stiffness = b_.bond_constants[at_.stiffness];
        P spring[3], product[9], longest(0);
        for (P& each : spring) each = P(0);
        for (P& each : product) each = P(0);
        families_.for_each_bond([&](const SlicePack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P Y[3];
            families_.deformed(bonds, Y);
            add_spring(Y, bonds.length(), bonds.constant(stiffness), live, spring, longest);
        });
        // in a loop of its own: all twelve sums at once would not fit into the registers
        families_.for_each_bond([&](const SlicePack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P Y[3];
            families_.deformed(bonds, Y);
            const P weight = influence(bonds, live) * bonds.volume();
            for (int r = 0; r < 3; ++r) {
                const P y = weight * Y[r];
                for (std::size_t c = 0; c < 3; ++c) product[3 * r + static_cast<int>(c)] += y * bonds.reference(c);
            }
        });
        std::copy_n(product, 9, sums), std::copy_n(spring, 3, sums + 9);
        largest = longest;
    }

    /// AveragedFamily::sum_averaged.
    PERIMPM_INLINE void sum_averaged(const P F[9], P sums[6]) const {
        if (at_.own_is_exact)
            at_.strain < 0 ? sum_averaged_as<true, false>(F, sums) : sum_averaged_as<true, true>(F, sums);
        else
            at_.strain < 0 ? sum_averaged_as<false, false>(F, sums) : sum_averaged_as<false, true>(F, sums);
    }

    /// sum w^ V_q H_q X, with V H of all particles in `stress`.
    PERIMPM_INLINE void sum_stress(const Field<Real>& stress, P sums[3]) const {
        P sum[3] = {P(0), P(0), P(0)};
        families_.for_each_bond([&](const SlicePack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            const P weight = influence(bonds, live);
            for (std::size_t c = 0; c < 3; ++c) {
                const P X = weight * bonds.reference(c);
                for (std::size_t r = 0; r < 3; ++r) sum[r] += bonds.gather(stress[3 * r + c]) * X;
            }
        });
        std::copy_n(sum, 3, sums);
    }

private:
    template <bool Exact, bool Yields>
    PERIMPM_INLINE void sum_averaged_as(const P F[9], P sums[6]) const {
        P twice[6], sum[6];
        twice_strain(F, twice);
        for (P& each : sum) each = P(0);
        families_.for_each_bond([&](const SlicePack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            const P X[3] = {bonds.reference(0), bonds.reference(1), bonds.reference(2)};
            const P length = bonds.length();
            P own;
            if constexpr (Exact)
                own = bonds.constant(b_.bond_constants[at_.own]);
            else
                own = influence(bonds, live) * bonds.volume();
            const auto yield = [&](P& longer, const P& both) PERIMPM_INLINE_LAMBDA {
                if constexpr (Yields) longer -= length * bonds.load(b_.bond_state[at_.strain]) * both;
            };
            add_averaged(X, twice, length, own, Exact, yield, sum);
        });
        P scale(1);
        if constexpr (!Exact)
            scale = families_.at(b_.particle_state[AveragedState::normalisation][0]) * families_.at(b_.volume);
        for (int c = 0; c < 6; ++c) sums[c] = scale * sum[c];
    }
    /// w^, 0 in lanes without the bond.
    PERIMPM_INLINE P influence(const SlicePack<Real>& bonds, const P& live) const {
        return at_.influence < 0 ? live : bonds.constant(b_.bond_constants[at_.influence]);
    }

    const Block<Real>& b_;
    const BondFields& at_;
    FamilySlice<Real> families_;
};

}  // namespace perimpm::peridynamics
