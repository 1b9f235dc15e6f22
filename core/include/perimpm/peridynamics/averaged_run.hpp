#pragma once

#include "perimpm/peridynamics/averaged_family.hpp"
#include "perimpm/peridynamics/family_run.hpp"

namespace perimpm::peridynamics {

/// The sums of AveragedFamily for a run of families, a family in each lane. What depends on X alone is worked out once
/// for all runs of one twin that follow each other.
template <class Real>
class AveragedRun {
    using P = Pack<Real>;

public:
    AveragedRun(const Block<Real>& b, const BondFields& at) : b_{b}, at_{at} {}

    /// How many families from the block's particle i on one run may take, or none.
    std::uint32_t size_at(std::uint32_t i) const {
        return b_.family.row[i + 1] - b_.family.row[i] > kLargest ? 0 : FamilyRun<Real>::size_at(b_, i);
    }

    /// AveragedFamily::sum_bonds.
    void sum_bonds(const FamilyRun<Real>& run, P sums[12], P& largest) {
        turn_to(run);
        const Real* stiffness = b_.bond_constants[at_.stiffness];
        P spring[3] = {}, product[9] = {}, longest(0);
        run.for_each_bond([&](const auto& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P Y[3];
            run.deformed(bonds, Y);
            add_spring(Y, table_(Table::length, bonds.k), bonds.constant(stiffness), live, spring, longest);
        });
        // in a loop of its own: all twelve sums at once would not fit into the registers
        run.for_each_bond([&](const auto& bonds, const P&) PERIMPM_INLINE_LAMBDA {
            P Y[3];
            run.deformed(bonds, Y);
            for (int r = 0; r < 3; ++r)
                for (int c = 0; c < 3; ++c) product[3 * r + c] += Y[r] * table_(Table::moment + c, bonds.k);
        });
        std::copy_n(product, 9, sums), std::copy_n(spring, 3, sums + 9);
        largest = longest;
    }

    /// AveragedFamily::sum_averaged, after `sum_bonds`.
    void sum_averaged(const FamilyRun<Real>& run, const P F[9], P sums[6]) const {
        P twice[6], sum[6] = {};
        twice_strain(F, twice);
        const Real* strain = at_.strain < 0 ? nullptr : b_.bond_state[at_.strain];
        const Real* exact = at_.own_is_exact ? b_.bond_constants[at_.own] : nullptr;
        run.for_each_bond([&](const auto& bonds, const P&) PERIMPM_INLINE_LAMBDA {
            P XX[6], longer(0);
            for (int c = 0; c < 6; ++c) XX[c] = table_(Table::XX + c, bonds.k), longer += XX[c] * twice[c];
            const P length = table_(Table::length, bonds.k);
            const P z = mean_length<P>(table_(Table::square, bonds.k), longer), both = z + length;
            if (strain) longer -= length * bonds.load(strain) * both;
            const P own = exact ? bonds.constant(exact) : table_(Table::own, bonds.k);
            const P pull = own * (longer * inverse_length(P(z * both)));
            for (int c = 0; c < 6; ++c) sum[c] += pull * XX[c];
        });
        const P scale =
            exact ? P(1) : P(run.at(b_.particle_state[AveragedState::normalisation][0]) * run.at(b_.volume));
        for (int c = 0; c < 6; ++c) sums[c] = scale * sum[c];
    }

    /// sum w^ V_q H_q X, with V H of all particles in `stress`.
    void sum_stress(const FamilyRun<Real>& run, const Field<Real>& stress, P sums[3]) {
        turn_to(run);
        P sum[3] = {};
        run.for_each_bond([&](const auto& bonds, const P&) PERIMPM_INLINE_LAMBDA {
            for (std::size_t r = 0; r < 3; ++r)
                for (std::size_t c = 0; c < 3; ++c)
                    sum[r] += bonds.gather(stress[3 * r + c]) * table_(Table::weighted + static_cast<int>(c), bonds.k);
        });
        std::copy_n(sum, 3, sums);
    }

private:
    static constexpr std::uint32_t kLargest = 512;  ///< families with more bonds are summed one by one
    static constexpr std::uint32_t kNone = ~0u;

    /// What the bonds of a twin have in common, bond by bond: w^ X, w^ V X, X (x) X, |X|^2, |X|, and S_pq over
    /// AveragedFamily::scale unless `own_is_exact`.
    struct Table {
        enum { weighted, moment = 3, XX = 6, square = 12, length, own, kRows };
        Real number[kRows][kLargest + kSlotPadding];

        P operator()(int row, std::uint32_t k) const { return P(number[row][k]); }
    };

    void turn_to(const FamilyRun<Real>& run) {
        const std::uint32_t i = run.first();
        if (b_.family.twin[i] == twin_) return;
        twin_ = b_.family.twin[i];
        const Real* influence = at_.influence < 0 ? nullptr : b_.bond_constants[at_.influence];
        const Real* reference = b_.family.reference + 4 * std::size_t{b_.first + i};
        std::uint32_t k = 0;
        for_each_bond(b_, i, [&](const BondPack<Real>& bonds, const P&) PERIMPM_INLINE_LAMBDA {
            P row[Table::kRows], X[4];
            bonds.template gather_packed<4>(b_.family.reference, X);
            const P w = influence ? bonds.constant(influence) : P(1), wV = w * X[3];
            for (int c = 0; c < 3; ++c) {
                X[c] -= reference[c];
                row[Table::weighted + c] = w * X[c], row[Table::moment + c] = wV * X[c];
            }
            for (int r = 0, at = Table::XX; r < 3; ++r)
                for (int c = r; c < 3; ++c) row[at++] = X[r] * X[c];
            row[Table::square] = row[Table::XX] + row[Table::XX + 3] + row[Table::XX + 5];
            row[Table::length] = bonds.constant(b_.family.length);
            row[Table::own] = wV / row[Table::square];
            for (int r = 0; r < Table::kRows; ++r)
                row[r].copy_to(table_.number[r] + k, std::experimental::element_aligned);
            k += kLanes<Real>;
        });
    }

    const Block<Real>& b_;
    BondFields at_;
    std::uint32_t twin_ = kNone;
    Table table_;
};

}  // namespace perimpm::peridynamics
