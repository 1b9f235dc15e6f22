#pragma once

#include "perimpm/peridynamics/family.hpp"

/*! Sums over one family for the laws of Lyu et al. 2019 (averaged_bonds.hpp), each family in two sweeps: its bonds give F-
    and the springs, then F- gives the averaged bonds. */
namespace perimpm::peridynamics {

/// Fields of particles by index.
struct AveragedState {
    enum : std::uint32_t {
        normalisation,
        shape_inverse,
        moment,
        mean_deformation,
        known_force,
        extension,
        record,
        averaged_stress
    };
};
/// Fields of bonds by index; -1: not kept.
struct BondFields {
    std::uint32_t stiffness = 0;  ///< constants, as the next three
    int own = -1, influence = -1;
    int strain = -1;       ///< e_p, of bonds that may yield
    int has_yielded = -1;  ///< field of particles, likewise
};

template <class T, class Entry>
PERIMPM_INLINE void deform(const T X[3], T out[3], const Entry F[9]) {
    for (int r = 0; r < 3; ++r) out[r] = F[3 * r] * X[0] + F[3 * r + 1] * X[1] + F[3 * r + 2] * X[2];
}

/// Adds the spring S (|Y| - |X|) dir Y of a bond; `largest`: of the relative extensions.
template <class P>
PERIMPM_INLINE void add_spring(const P Y[3], const Root<P>& y, const P& length, const P& stiffness, P sum[3],
                               P& largest) {
    const P relative = relative_extension(y, length);
    largest = larger(largest, relative);
    const P spring = stiffness * relative;
    for (int c = 0; c < 3; ++c) sum[c] += spring * Y[c];
}
/// 2 E = F^T F - 1: xx, 2 xy, 2 xz, yy, 2 yz, zz, of F - 1, which costs no digits where strains are small.
template <class T>
PERIMPM_INLINE void twice_strain(const T F[9], T out[6]) {
    constexpr int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};
    T G[9];
    for (int c = 0; c < 9; ++c) G[c] = c % 4 == 0 ? F[c] - T(1) : F[c];
    for (int c = 0; c < 6; ++c) {
        const int i = row[c], j = column[c];
        const T sum = G[3 * i + j] + G[3 * j + i] + (G[i] * G[j] + G[3 + i] * G[3 + j] + G[6 + i] * G[6 + j]);
        out[c] = i == j ? sum : sum + sum;
    }
}
/// |Y-|^2 - |X|^2 = X.(2 E X) from X (x) X, which costs no digits where strains are small.
template <class P, class S, class T>
PERIMPM_INLINE P lengthening(const S XX[6], const T twice_strain[6]) {
    return (XX[0] * twice_strain[0] + XX[1] * twice_strain[1] + XX[2] * twice_strain[2]) +
           (XX[3] * twice_strain[3] + XX[4] * twice_strain[4] + XX[5] * twice_strain[5]);
}

/// Adds S (|Y-| - |X| - e_p |X|)/|Y-| X (x) X of a bond: xx xy xz yy yz zz. yield(longer, both) takes what e_p means from
/// |Y-|^2 - |X|^2, a product with both = |Y-| + |X|.
template <class P, class T, class Yield>
PERIMPM_INLINE void add_averaged(const P X[3], const T twice_strain[6], const P& length, const P& own,
                                 const Yield& yield, P sum[6]) {
    const P XX[6] = {X[0] * X[0], X[0] * X[1], X[0] * X[2], X[1] * X[1], X[1] * X[2], X[2] * X[2]};
    P longer = lengthening<P>(XX, twice_strain);
    const P z = root_of(larger(P(XX[0] + XX[3] + XX[5] + longer), P(0))).root, both = z + length;
    yield(longer, both);
    const P pull = own * (longer * inverse_length(P(z * both)));
    for (int c = 0; c < 6; ++c) sum[c] += pull * XX[c];
}
/// The same of all bonds on an axis, of which none yielded: S |X|^2 (|Y-| - |X|)/|Y-| n (x) n depends on their direction n
/// alone. `own`: sum S |X|^2.
template <class P, class Real>
PERIMPM_INLINE void add_averaged_axis(const Real nn[6], const P twice_strain[6], const P& own, P sum[6]) {
    const P pull = own * shortening_of(lengthening<P>(nn, twice_strain));
    for (int c = 0; c < 6; ++c) sum[c] += pull * nn[c];
}

template <class Real>
class AveragedFamily {
    using P = Pack<Real>;
    static constexpr std::uint32_t kKept =
        512 / kLanes<Real>;  ///< packs kept for the second sweep, of families up to so many
    static constexpr std::size_t kEntry = 7 * kLanes<Real>;  ///< X, w^ V and Y of a pack of bonds

public:
    AveragedFamily(const Block<Real>& b, const BondFields& at) : b_{b}, at_{at} {}

    /// First sweep: sums[0..8] = sum w^ V Y (x) X, sums[9..11] = sum S (|Y| - |X|) dir Y; returns the largest
    /// (|Y| - |X|)/|Y|, at least 0.
    PERIMPM_INLINE Real sum_bonds(std::uint32_t i, Real sums[12]) {
        const std::uint32_t last = b_.family.row[i + 1];
        P sum[12], largest(0);
        for (P& each : sum) each = P(0);
        for (std::uint32_t slot = b_.family.row[i]; slot < last; slot += kKept * kLanes<Real>) {
            const std::uint32_t end = slot + std::min(last - slot, kKept * static_cast<std::uint32_t>(kLanes<Real>));
            keep(i, slot, end);
            add_springs(i, slot, end, sum + 9, largest);
            add_products(end - slot, sum);
        }
        for (int c = 0; c < 12; c += 4) reduce_four(sum + c, sums + c);
        return hmax(largest);
    }

    /// sum S_pq (|Y-| - |X| - e_p |X|)/|Y-| X (x) X for Y- = F X: xx xy xz yy yz zz, and two numbers without meaning.
    PERIMPM_INLINE void sum_averaged(std::uint32_t i, const Real F[9], Real sums[8]) const {
        const Real* strain = at_.strain < 0 ? nullptr : b_.bond_state[at_.strain];
        Real twice[6];
        twice_strain(F, twice);
        P sum[8] = {};
        for_each_kept(i, [&](const BondPack<Real>& bonds, const P X[4], const P& own) PERIMPM_INLINE_LAMBDA {
            const P length = bonds.length();
            const auto yield = [&](P& longer, const P& both) PERIMPM_INLINE_LAMBDA {
                if (strain) longer -= length * bonds.load(strain) * both;
            };
            add_averaged(X, twice, length, own, yield, sum);
        });
        reduce_four(sum, sums), reduce_four(sum + 4, sums + 4);
    }
    /// sum S_pq (|Y-| - |X|)/|Y-| X, and a number without meaning. Rounded as the neighbours' terms are in
    /// `force_as_printed`: the two ends of a bond pull alike.
    PERIMPM_INLINE void sum_averaged_pulls(std::uint32_t i, const Real F[9], Real sums[4]) const {
        P sum[4] = {};
        for_each_kept(i, [&](const BondPack<Real>& bonds, const P X[4], const P& own) PERIMPM_INLINE_LAMBDA {
            P mean[3];
            deform(X, mean, F);
            const P pull = own * relative_extension(length_of(mean), bonds.length());
            for (int c = 0; c < 3; ++c) sum[c] += pull * X[c];
        });
        reduce_four(sum, sums);
    }

private:
    /// X and w^ V of the neighbours, 0 for broken bonds.
    PERIMPM_INLINE void fetch(std::uint32_t i, const BondPack<Real>& bonds, const P& live, const Real* influence,
                              P X[4]) const {
        const Real* reference = b_.family.reference + 4 * std::size_t{b_.first + i};
        bonds.template gather_packed<4>(b_.family.reference, X);
        for (int c = 0; c < 3; ++c) X[c] -= reference[c];
        X[3] *= live;
        if (influence) X[3] *= bonds.constant(influence);
    }
    /// Keeps X, w^ V and Y of the bonds in the slots from `slot` to `end`. A loop of its own: the processor then fetches for
    /// many bonds at a time instead of waiting for the roots and divisions of a few.
    PERIMPM_INLINE void keep(std::uint32_t i, std::uint32_t slot, std::uint32_t end) {
        const Real *positions = b_.family.position, *influence = influences();
        const Real* position = positions + 4 * std::size_t{b_.first + i};
        Real* to = kept_;
        for_each_bond(b_, i, slot, end, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P X[4], Y[3];
            fetch(i, bonds, live, influence, X);
            bonds.difference(positions, position, Y);
            for (int c = 0; c < 4; ++c) X[c].copy_to(to + c * kLanes<Real>, std::experimental::vector_aligned);
            for (int c = 0; c < 3; ++c)
                P(live * Y[c]).copy_to(to + (4 + c) * kLanes<Real>, std::experimental::vector_aligned);
            to += kEntry;
        });
    }
    /// Adds the springs of the bonds kept, which are those in the slots from `slot` to `end`.
    PERIMPM_INLINE void add_springs(std::uint32_t i, std::uint32_t slot, std::uint32_t end, P sum[3],
                                    P& largest) const {
        const Real *stiffness = b_.bond_constants[at_.stiffness], *from = kept_;
        for_each_bond(b_, i, slot, end, [&](const BondPack<Real>& bonds, const P&) PERIMPM_INLINE_LAMBDA {
            const P Y[3] = {kept(from, 4), kept(from, 5), kept(from, 6)};
            from += kEntry;
            add_spring(Y, length_of(Y), bonds.length(), bonds.constant(stiffness), sum, largest);
        });
    }
    /// Adds w^ V Y (x) X of the first `count` bonds kept. A loop of its own: with those of the springs, its sums would not
    /// fit into the registers.
    PERIMPM_INLINE void add_products(std::uint32_t count, P sum[9]) const {
        const Real* const end = kept_ + (count + kLanes<Real> - 1) / kLanes<Real> * kEntry;
        for (const Real* from = kept_; from < end; from += kEntry) {
            const P X[3] = {kept(from, 0), kept(from, 1), kept(from, 2)}, weight = kept(from, 3);
            for (int r = 0; r < 3; ++r) {
                const P y = weight * kept(from, 4 + r);
                for (int c = 0; c < 3; ++c) sum[3 * r + c] += y * X[c];
            }
        }
    }
    PERIMPM_INLINE static P kept(const Real* entry, int c) {
        return P(entry + c * kLanes<Real>, std::experimental::vector_aligned);
    }
    /// Second sweep: body(pack, X, S_pq) for the packs of bonds.
    template <class Body>
    PERIMPM_INLINE void for_each_kept(std::uint32_t i, Body body) const {
        const Real* influence = influences();
        const bool whole = b_.family.row[i + 1] - b_.family.row[i] <= kKept * kLanes<Real>;
        const Real* from = kept_;
        for_each_bond(b_, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P X[4];
            if (whole)
                for (int c = 0; c < 4; ++c) X[c] = kept(from, c);
            else
                fetch(i, bonds, live, influence, X);
            from += kEntry;
            body(bonds, X, P(live * bonds.constant(b_.bond_constants[at_.own])));
        });
    }
    const Real* influences() const { return at_.influence < 0 ? nullptr : b_.bond_constants[at_.influence]; }

    const Block<Real>& b_;
    BondFields at_;
    alignas(P) Real kept_[kKept * kEntry];  ///< of the family that `sum_bonds` was asked for last
};

}  // namespace perimpm::peridynamics
