#pragma once

#include "perimpm/peridynamics/averaged_bond_params.hpp"
#include "perimpm/peridynamics/averaged_slice.hpp"
#include "perimpm/peridynamics/row_sums.hpp"

/*! Forces of the laws of Lyu et al. 2019, from what their first pass left of each family (averaged_bonds.hpp). Equation
    numbers are in plugins/constitutive/pd_elastic.cpp. Whole blocks are calls of their own, as in average_families. */
namespace perimpm::peridynamics {

template <class Real>
[[gnu::noinline]] void force_of_springs(Block<Real>& b, const BondFields& at, double lambda) {
    using P = Pack<Real>;
    P largest(0);
    for_each_family(b, [&](const auto& family) PERIMPM_INLINE_LAMBDA {
        P f[3] = {}, extension(0);
        family.for_each_length(
            fetch_only, [&](const auto& bonds, const P&, const P Y[3], const Root<P>& y) PERIMPM_INLINE_LAMBDA {
                add_spring(Y, y, bonds.length(), bonds.constant(b.bond_constants[at.stiffness]), f, extension);
            });
        for (P& sum : f) sum *= P(static_cast<Real>(lambda));  // (6), second term
        family.write(f, b.force);
        largest = larger(largest, extension);
    });
    b.largest_stretch = stretch_of(hmax(largest));
}

/// (6) and (7) as printed.
template <class Real>
[[gnu::noinline]] void force_as_printed(Block<Real>& b, const BondFields& at, double mu) {
    using P = Pack<Real>;
    const Real* records = b.family_state[AveragedState::record].data;
    Real largest = 0;
    for (std::uint32_t i = 0; i < b.size; ++i) {
        const Real* mine = b.family.reference + 4 * std::size_t{b.first + i};
        P f[4] = {};
        for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P theirs[kSumRecord], X[3], there[3];
            bonds.template gather_packed<kSumRecord>(records, theirs);
            for (int c = 0; c < 3; ++c) X[c] = theirs[9 + c] - mine[c];
            deform(X, there, theirs);
            const P other = bonds.constant(b.bond_constants[at.stiffness]) - bonds.constant(b.bond_constants[at.own]);
            const P pull = live * other * relative_extension(length_of(there), bonds.length());
            for (int c = 0; c < 3; ++c) f[c] += pull * there[c];  // (6), first term, of -T<q,p>
        });
        Real sums[4];
        reduce_four(f, sums);
        for (std::size_t c = 0; c < 3; ++c)
            b.force[c][i] = b.particle_state[AveragedState::known_force][c][i] + static_cast<Real>(2 * mu) * sums[c];
        largest = larger(largest, b.particle_state[AveragedState::extension][0][i]);
    }
    b.largest_stretch = stretch_of(largest);
}

/*! Minus the gradient of (5): H_p and H_q act on the same bonds. What H_p does is one product with the family's moment. What
    the H_q do is linear in X_q - X_p, hence
      sum w^ V_q H_q (X_q - X_p) = sum w^ (V_q H_q X_q) - (sum w^ V_q H_q) X_p
    with twelve numbers of q in both sums. X counts from the material's first particle. The difference loses digits as the
    difference of positions y does, of H instead of the moduli: a strain's share of that. */
template <class Real>
Real force_of_energy(Block<Real>& b, const BondFields& at, std::uint32_t i) {
    const Families<Real>& family = b.family;
    const Real* records = b.family_state[AveragedState::record].data;
    const Field<Real>& moment = b.particle_state[AveragedState::moment];
    const Real *origin = family.reference, *X = origin + 4 * std::size_t{b.first + i};
    const std::uint32_t begin = family.row[i], count = family.row[i + 1] - begin;
    const Real* influence = at.influence < 0 ? nullptr : b.bond_constants[at.influence] + family.shape[i];
    const Real* own = records + kSumRecord * std::size_t{b.first + i};
    const std::uint32_t* neighbours = family.neighbour + begin;
    for (std::uint32_t k = 0; k < count; k += 16) {
        prefetch(neighbours + k);
        if (influence) prefetch(influence + k);
    }
    Real sums[kSumRecord];
    const auto sum = [&](auto weight) PERIMPM_INLINE_LAMBDA { sum_records(records, neighbours, count, weight, sums); };
    if (family.damage && family.damage[i] > 0)
        sum([&](std::uint32_t k) {
            return family.is_broken(begin + k) ? Real(0) : influence ? influence[k] : Real(1);
        });
    else if (influence)
        sum([&](std::uint32_t k) { return influence[k]; });
    else
        sum([](std::uint32_t) { return Real(1); });
    for (int c = 0; c < 3; ++c) {
        Real here = 0, there = sums[9 + c];
        for (int k = 0; k < 3; ++k) {
            here += own[3 * c + k] * moment[k][i];
            there -= sums[3 * c + k] * (X[k] - origin[k]);
        }
        b.force[c][i] = b.particle_state[AveragedState::known_force][c][i] + here + b.volume[i] * there;
    }
    return b.particle_state[AveragedState::extension][0][i];
}
/// Force of `count` particles from i on, at most a pack, from sum w^ V_q H_q X; returns their relative extensions. Loads come
/// first: their branches for part of a pack must not come between a product and its sum, which whole packs round as one.
template <class Real>
PERIMPM_INLINE Pack<Real> put_force(Block<Real>& b, std::uint32_t i, std::size_t count, const Pack<Real> there[3]) {
    using P = Pack<Real>;
    const auto at = [&](const Real* of_block) PERIMPM_INLINE_LAMBDA { return load(of_block + i, count); };
    P stress[9], moment[3], known[3];
    for (std::size_t c = 0; c < 9; ++c) stress[c] = at(b.particle_state[AveragedState::averaged_stress][c]);
    for (std::size_t c = 0; c < 3; ++c) {
        moment[c] = at(b.particle_state[AveragedState::moment][c]);
        known[c] = at(b.particle_state[AveragedState::known_force][c]);
    }
    const P volume = at(b.volume);
    P force[3];
    for (std::size_t c = 0; c < 3; ++c) {
        P here(0);
        for (std::size_t k = 0; k < 3; ++k) here += stress[3 * c + k] * moment[k];
        force[c] = known[c] + volume * (here + there[c]);
    }
    for (std::size_t c = 0; c < 3; ++c) store(b.force[c] + i, force[c], count);
    return at(b.particle_state[AveragedState::extension][0]);
}
/// Of the rows of a lattice, whatever bonds they lost. First b.force holds their sums w^ V_q H_q X, one component of all rows
/// after the other: a row's neighbours are then still in the cache when the row beside it asks for them.
template <class Real>
Pack<Real> force_of_rows(Block<Real>& b) {
    using P = Pack<Real>;
    const Field<Real>& stress = b.family_state[AveragedState::averaged_stress];
    for (std::size_t r = 0; r < 3; ++r)
        for_each_row(b, [&](const LatticeRow& row, std::uint32_t begin, std::uint32_t end) {
            const std::int32_t offset = static_cast<std::int32_t>(b.first) - static_cast<std::int32_t>(row.first);
            RowSums<Real>(b.family.rows, row, stress)(r, static_cast<std::int32_t>(begin) + offset,
                                                      static_cast<std::int32_t>(end) + offset, b.force[r] - offset);
        });
    P longest(0);
    for_each_row(b, [&](const LatticeRow&, std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t i = begin; i < end; i += kLanes<Real>) {
            P there[3];
            for (std::size_t r = 0; r < 3; ++r) there[r] = load(b.force[r] + i, end - i);
            longest = larger(longest, put_force(b, i, end - i, there));
        }
    });
    return longest;
}
/// Rows of a lattice first, then families of theirs that lost bonds by themselves, and what is in no row with its slice or
/// by itself. A slice that reaches over an end of a row goes whole, over what the row left there.
template <class Real>
[[gnu::noinline]] void force_of_energy(Block<Real>& b, const BondFields& at) {
    using P = Pack<Real>;
    constexpr std::uint32_t kSize = FamilySlice<Real>::kSize;
    P longest = force_of_rows(b);
    std::uint32_t i = 0;
    const auto by_slices = [&](std::uint32_t end) {
        if (i == end) return;
        const std::uint32_t before = (b.first + i) % kSize;
        if (before <= i && FamilySlice<Real>::begins_at(b, i - before)) i -= before;
        while (i < end) {
            if (FamilySlice<Real>::begins_at(b, i)) {
                P there[3];
                AveragedSlice<Real>(b, at, i).sum_stress(b.family_state[AveragedState::averaged_stress], there);
                longest = larger(longest, put_force(b, i, kSize, there));
                i += kSize;
            } else {
                longest = larger(longest, P(force_of_energy(b, at, i++)));
            }
        }
    };
    for_each_row(b, [&](const LatticeRow&, std::uint32_t begin, std::uint32_t end) {
        by_slices(begin);
        for (i = begin; b.family.is_cut && i < end; ++i)
            if (b.family.damage[i] > 0) longest = larger(longest, P(force_of_energy(b, at, i)));
        i = end;
    });
    by_slices(b.size);
    b.largest_stretch = stretch_of(hmax(longest));
}

/// What permanent strains change in the forces. In the paper's form (`printed`) also |Y| for |Y-|, as (9) prints; the
/// other one has them in H.
template <class Real, class Flow>
void add_yielded(Block<Real>& b, const BondFields& at, const SpringModuli& moduli, const Flow& flow,
                 const typename Flow::Fields& flow_fields, bool printed) {
    using P = Pack<Real>;
    const P lambda(static_cast<Real>(moduli.lambda)), two_mu(static_cast<Real>(2 * moduli.mu));
    for (std::uint32_t i = 0; i < b.size; ++i) {
        if (!printed && FamilySlice<Real>::begins_at(b, i) &&
            flow.is_elastic(b, FamilySlice<Real>(b, i), flow_fields)) {
            i += FamilySlice<Real>::kSize - 1;
            continue;
        }
        const Real* position = b.family.position + 4 * std::size_t{b.first + i};
        P f[4] = {};
        for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P Y[3];
            bonds.difference(b.family.position, position, Y);
            const P length = bonds.length(), own = bonds.constant(b.bond_constants[at.own]);
            const P other = bonds.constant(b.bond_constants[at.stiffness]) - own, y = norm(Y);
            const P here = length * bonds.load(b.bond_state[at.strain]);  // e_p |X| of both directions
            const P there = length * flow.at_other_end(b, bonds, flow_fields);
            const P spring = live * lambda * inverse_length(y) * (own * here + other * there);
            for (int c = 0; c < 3; ++c) f[c] -= spring * Y[c];
            if (!printed) return;
            const Real* mine = b.particle_state[AveragedState::record].data + kSumRecord * std::size_t{i};
            P theirs[kSumRecord], X[3], mean[3];
            bonds.template gather_packed<kSumRecord>(b.family_state[AveragedState::record].data, theirs);
            bonds.difference(b.family.reference, mine + 9, X);
            const auto add = [&](const auto* F, const P& stiffness, const P& yielded) {
                deform(X, mean, F);
                const P z = norm(mean), pull = live * two_mu * stiffness * (y - z - yielded) * inverse_length(z);
                for (int c = 0; c < 3; ++c) f[c] += pull * mean[c];
            };
            add(mine, own, here);
            add(theirs, other, there);
        });
        Real sums[4];
        reduce_four(f, sums);
        for (int c = 0; c < 3; ++c) b.force[c][i] += sums[c];
    }
}

}  // namespace perimpm::peridynamics
