#pragma once

#include "perimpm/peridynamics/averaged_bond_params.hpp"
#include "perimpm/peridynamics/averaged_slice.hpp"

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
/// Of the families of a slice, which have X in common; returns the largest relative extension.
template <class Real>
Real force_of_energy(Block<Real>& b, const AveragedSlice<Real>& slice) {
    using P = Pack<Real>;
    const Field<Real>& stress = b.family_state[AveragedState::averaged_stress];
    const FamilySlice<Real>& families = slice.families();
    P there[3];
    slice.sum_stress(stress, there);
    const P volume = families.at(b.volume);
    for (std::size_t c = 0; c < 3; ++c) {
        P here(0);
        for (std::size_t k = 0; k < 3; ++k)
            here += families.at(b.particle_state[AveragedState::averaged_stress][3 * c + k]) *
                    families.at(b.particle_state[AveragedState::moment][k]);
        there[c] = families.at(b.particle_state[AveragedState::known_force][c]) + volume * (here + there[c]);
    }
    families.write(there, b.force);
    return hmax(families.at(b.particle_state[AveragedState::extension][0]));
}
template <class Real>
[[gnu::noinline]] void force_of_energy(Block<Real>& b, const BondFields& at) {
    Real largest = 0;
    for (std::uint32_t i = 0; i < b.size;) {
        const bool together = FamilySlice<Real>::begins_at(b, i);
        const Real found = together ? force_of_energy(b, AveragedSlice<Real>(b, at, i)) : force_of_energy(b, at, i);
        largest = larger(largest, found);
        i += together ? FamilySlice<Real>::kSize : 1;
    }
    b.largest_stretch = stretch_of(largest);
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
