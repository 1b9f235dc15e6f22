#pragma once

#include <algorithm>

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
        P spring[3], product[9], longest(0);
        for (P& each : spring) each = P(0);
        for (P& each : product) each = P(0);
        const auto add_product = [&](const auto& bonds, const P Y[3]) PERIMPM_INLINE_LAMBDA {
            for (int r = 0; r < 3; ++r)
                for (int c = 0; c < 3; ++c) product[3 * r + c] += Y[r] * bonds.moment[c];
        };
        const auto add_spring_of = [&](const auto& bonds, const P&, const P Y[3],
                                       const Root<P>& y) PERIMPM_INLINE_LAMBDA {
            add_spring(Y, y, bonds.length(), bonds.constant(b_.bond_constants[at_.stiffness]), spring, longest);
        };
        families_.for_each_length(add_product, add_spring_of);
        std::copy_n(product, 9, sums), std::copy_n(spring, 3, sums + 9);
        largest = longest;
    }

    /// AveragedFamily::sum_averaged.
    PERIMPM_INLINE void sum_averaged(const P F[9], P sums[6]) const {
        P twice[6], sum[6];
        twice_strain(F, twice);
        for (P& each : sum) each = P(0);
        if (has_yielded())
            families_.for_each_bond([&](const SlicePack<Real>& bonds, const P&) PERIMPM_INLINE_LAMBDA {
                const P X[3] = {bonds.reference(0), bonds.reference(1), bonds.reference(2)}, length = bonds.length();
                const auto yield = [&](P& longer, const P& both) PERIMPM_INLINE_LAMBDA {
                    longer -= length * bonds.load(b_.bond_state[at_.strain]) * both;
                };
                add_averaged(X, twice, length, bonds.constant(b_.bond_constants[at_.own]), yield, sum);
            });
        else
            families_.for_each_axis([&](const Real nn[6], const P& own)
                                        PERIMPM_INLINE_LAMBDA { add_averaged_axis(nn, twice, own, sum); });
        std::copy_n(sum, 6, sums);
    }

    /// sum w^ V_q H_q X, with H of all particles in `stress`.
    PERIMPM_INLINE void sum_stress(const Field<Real>& stress, P sums[3]) const {
        P sum[3] = {P(0), P(0), P(0)};
        families_.for_each_bond([&](const SlicePack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            for (std::size_t c = 0; c < 3; ++c) {
                const P moment = live * P(bonds.moment[c]);
                for (std::size_t r = 0; r < 3; ++r) sum[r] += bonds.gather(stress[3 * r + c]) * moment;
            }
        });
        std::copy_n(sum, 3, sums);
    }

private:
    bool has_yielded() const {
        return at_.has_yielded >= 0 && any_of(families_.at(b_.particle_state[at_.has_yielded][0]) != P(0));
    }

    const Block<Real>& b_;
    const BondFields& at_;
    FamilySlice<Real> families_;
};

}  // namespace perimpm::peridynamics
