#pragma once

#include "perimpm/peridynamics/family.hpp"

/*! Sums over one family for the laws of Lyu et al. 2019 (averaged_bonds.hpp), each family in two sweeps: its bonds give F-
    and the springs, then F- gives the averaged bonds. */
namespace perimpm::peridynamics {

/// Fields of particles by index.
struct AveragedState {
    enum : std::uint32_t { normalisation, shape_inverse, moment, mean_deformation, averaged_stress };
};
/// What the field mean_deformation holds of a particle: F- row-major and, in one cache line of single precision with it,
/// X, the part of the force that needs no neighbour's F- [N] and the largest relative extension of the bonds.
struct MeanRecord {
    enum : std::size_t { kReference = 9, kForce = 12, kExtension = 15, kWidth = 16 };
};
/// Fields of bonds by index; -1: not kept.
struct BondFields {
    std::uint32_t stiffness = 0;
    int own = -1, influence = -1, strain = -1;
    bool own_is_exact = false;  ///< S_pq is no function of |X|: surface "moment"
};

template <class T, class Entry>
PERIMPM_INLINE void deform(const T X[3], T out[3], const Entry F[9]) {
    for (int r = 0; r < 3; ++r) out[r] = F[3 * r] * X[0] + F[3 * r + 1] * X[1] + F[3 * r + 2] * X[2];
}

template <class Real>
class AveragedFamily {
    using P = Pack<Real>;
    static constexpr std::uint32_t kKept = 512 / kLanes<Real>;  ///< packs that the second sweep need not fetch again

public:
    AveragedFamily(const Block<Real>& b, const BondFields& at) : b_{b}, at_{at} {}

    /// First sweep: sums[0..8] = sum w^ V Y (x) X, sums[9..11] = sum S (|Y| - |X|) dir Y; returns the largest
    /// (|Y| - |X|)/|Y|, at least 0.
    PERIMPM_INLINE Real sum_bonds(std::uint32_t i, Real sums[12]) {
        const Real* position = b_.family.position + 4 * std::size_t{b_.first + i};
        const std::uint32_t begin = b_.family.row[i];
        P sum[12] = {}, largest(0);
        for_each_bond(b_, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P X[4], Y[3];
            fetch(i, bonds, live, X);
            const std::uint32_t k = (bonds.slot - begin) / kLanes<Real>;
            for (int c = 0; c < 4 && k < kKept; ++c) kept_[4 * k + c] = X[c];
            bonds.difference(b_.family.position, position, Y);
            const P y = norm(Y);
            const P relative = live * ((y - bonds.load(b_.family.length)) * inverse_length(y));
            largest = larger(largest, relative);
            const P spring = bonds.load(b_.bond_state[at_.stiffness]) * relative;
            for (int c = 0; c < 3; ++c) sum[9 + c] += spring * Y[c];
            for (int c = 0; c < 3; ++c) Y[c] *= X[3];
            for (int c = 0; c < 9; ++c) sum[c] += Y[c / 3] * X[c % 3];
        });
        for (int c = 0; c < 12; c += 4) reduce_four(sum + c, sums + c);
        return hmax(largest);
    }

    /// sum S_pq (|Y-| - |X| - e_p |X|)/|Y-| X (x) X for Y- = F X: xx xy xz yy yz zz, and two numbers without meaning.
    PERIMPM_INLINE void sum_averaged(std::uint32_t i, const Real F[9], Real sums[8]) const {
        P sum[8] = {};
        const Real* strain = at_.strain < 0 ? nullptr : b_.bond_state[at_.strain];
        for_each_averaged(i, F, strain, [&](const P X[3], const P& pull) PERIMPM_INLINE_LAMBDA {
            const P x = pull * X[0], y = pull * X[1];
            sum[0] += x * X[0], sum[1] += x * X[1], sum[2] += x * X[2];
            sum[3] += y * X[1], sum[4] += y * X[2], sum[5] += pull * X[2] * X[2];
        });
        reduce_four(sum, sums), reduce_four(sum + 4, sums + 4);
        for (int c = 0; c < 6; ++c) sums[c] *= scale(i);
    }
    /// sum S_pq (|Y-| - |X|)/|Y-| X, and a number without meaning.
    PERIMPM_INLINE void sum_averaged_pulls(std::uint32_t i, const Real F[9], Real sums[4]) const {
        P sum[4] = {};
        for_each_averaged(i, F, nullptr, [&](const P X[3], const P& pull) PERIMPM_INLINE_LAMBDA {
            for (int c = 0; c < 3; ++c) sum[c] += pull * X[c];
        });
        reduce_four(sum, sums);
        for (int c = 0; c < 3; ++c) sums[c] *= scale(i);
    }

private:
    /// X and w^ V of the neighbours, 0 for broken bonds.
    PERIMPM_INLINE void fetch(std::uint32_t i, const BondPack<Real>& bonds, const P& live, P X[4]) const {
        const Real* reference = b_.family.reference + 4 * std::size_t{b_.first + i};
        bonds.template gather_packed<4>(b_.family.reference, X);
        for (int c = 0; c < 3; ++c) X[c] -= reference[c];
        X[3] *= live;
        if (at_.influence >= 0) X[3] *= bonds.load(b_.bond_state[at_.influence]);
    }
    /// Second sweep: body(X, S_pq (|Y-| - |X| - e_p |X|)/|Y-| over `scale`) for the packs of bonds; e_p = 0 without
    /// `strain`. S_pq is made from what the first sweep kept: another number per bond would have to come from memory.
    template <class Body>
    PERIMPM_INLINE void for_each_averaged(std::uint32_t i, const Real F[9], const Real* strain, Body body) const {
        const std::uint32_t begin = b_.family.row[i];
        for_each_bond(b_, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P X[4], mean[3];
            const std::uint32_t k = (bonds.slot - begin) / kLanes<Real>;
            if (k < kKept)
                for (int c = 0; c < 4; ++c) X[c] = kept_[4 * k + c];
            else
                fetch(i, bonds, live, X);
            deform(X, mean, F);
            const P z = norm(mean), length(b_.family.length + bonds.slot, std::experimental::element_aligned);
            P extension = z - length;
            if (strain) extension -= length * bonds.load(strain);
            P weight = X[3], divisor = z * (length * length);
            if (at_.own_is_exact) weight = live * bonds.load(b_.bond_state[at_.own]), divisor = z;
            body(X, P(weight * (extension * inverse_length(divisor))));
        });
    }
    Real scale(std::uint32_t i) const {
        return at_.own_is_exact ? Real(1) : b_.particle_state[AveragedState::normalisation][0][i] * b_.volume[i];
    }

    const Block<Real>& b_;
    BondFields at_;
    P kept_[4 * kKept];  ///< X and w^ V of the family that `sum_bonds` was asked for last
};

}  // namespace perimpm::peridynamics
