#pragma once

#include "perimpm/peridynamics/averaged_bond_params.hpp"
#include "perimpm/peridynamics/averaged_slice.hpp"

/*! The first pass of the laws of Lyu et al. 2019: what neighbours need of each family (averaged_bonds.hpp). Equation
    numbers are in plugins/constitutive/pd_elastic.cpp. */
namespace perimpm::peridynamics {

/// A K, of one particle or of a slice; K: xx xy xz yy yz zz.
template <class T>
PERIMPM_INLINE void times_symmetric(const T A[9], const T K[6], T out[9]) {
    for (int r = 0; r < 9; r += 3) {
        out[r] = A[r] * K[0] + A[r + 1] * K[1] + A[r + 2] * K[2];
        out[r + 1] = A[r] * K[1] + A[r + 1] * K[3] + A[r + 2] * K[4];
        out[r + 2] = A[r] * K[2] + A[r + 1] * K[4] + A[r + 2] * K[5];
    }
}

template <class Real>
class AveragedSweep {
    using P = Pack<Real>;
    using State = AveragedState;

public:
    /// `printed`: the paper's form.
    AveragedSweep(Block<Real>& b, const BondFields& at, const SpringModuli& moduli, bool printed)
        : b_{b},
          lambda_{static_cast<Real>(moduli.lambda)},
          two_mu_{static_cast<Real>(2 * moduli.mu)},
          printed_{printed},
          at_{at},
          family_{{b, at}, {b, at}} {}

    /// Slices together, other families one by one: there the second sweep of a family after the first of the next one,
    /// so that neither waits for the other's sums.
    void operator()() {
        for (std::uint32_t i = 0; i < b_.size;) {
            if (slice_at(i)) {
                average(AveragedSlice<Real>(b_, at_, i));
                i += FamilySlice<Real>::kSize;
                continue;
            }
            const std::uint32_t first = i;
            do {
                set_mean_deformation(i);
                if (i > first) add_averaged(i - 1);
            } while (++i < b_.size && !slice_at(i));
            add_averaged(i - 1);
        }
    }

private:
    bool slice_at(std::uint32_t i) const { return !printed_ && FamilySlice<Real>::begins_at(b_, i); }

    void average(const AveragedSlice<Real>& slice) {
        const FamilySlice<Real>& families = slice.families();
        P sums[12], F[9], S[6], K[6], H[12], largest;
        const auto put = [&](const Field<Real>& field, const P* numbers, std::size_t count) {
            for (std::size_t c = 0; c < count; ++c) families.put(field[c], numbers[c]);
        };
        for (std::size_t c = 0; c < 6; ++c) K[c] = families.at(b_.particle_state[State::shape_inverse][c]);
        slice.sum_bonds(sums, largest);
        times_symmetric(sums, K, F);                         // (4)
        for (int c = 9; c < 12; ++c) sums[c] *= P(lambda_);  // (6), second term
        put(b_.particle_state[State::mean_deformation], F, 9);
        put(b_.particle_state[State::known_force], sums + 9, 3);
        put(b_.particle_state[State::extension], &largest, 1);

        slice.sum_averaged(F, S);
        stress_of(F, S, K, H);
        const P inverse_volume = P(1) / families.at(b_.volume);
        for (std::size_t c = 0; c < 9; ++c)
            families.put(b_.particle_state[State::averaged_stress][c], inverse_volume * H[c]);
        if (!families.is_read_alone()) return;
        P X[4];
        load_quads_apart(b_.family.reference + 4 * std::size_t{b_.first + families.first()}, X);
        times_position(H, X, H + 9);
        for (std::size_t c = 0; c < 12; c += 4) store_quads_apart<kSumRecord>(record(families.first()) + c, H + c);
    }

    void set_mean_deformation(std::uint32_t i) {
        Real sums[12], K[6], *F = mean_[i % 2];
        load_shape_inverse(i, K);
        b_.particle_state[State::extension][0][i] = family_[i % 2].sum_bonds(i, sums);
        times_symmetric(sums, K, F);  // (4)
        for (std::size_t c = 0; c < 9; ++c) b_.particle_state[State::mean_deformation][c][i] = F[c];
        for (std::size_t c = 0; c < 3; ++c)
            b_.particle_state[State::known_force][c][i] = lambda_ * sums[9 + c];  // (6), second term
    }

    void add_averaged(std::uint32_t i) {
        const AveragedFamily<Real>& family = family_[i % 2];
        const Real *F = mean_[i % 2], *X = b_.family.reference + 4 * std::size_t{b_.first + i};
        Real* to = record(i);
        if (printed_) {
            Real pulls[4], force[3];
            family.sum_averaged_pulls(i, F, pulls);
            deform(pulls, force, F);
            for (std::size_t c = 0; c < 3; ++c)
                b_.particle_state[State::known_force][c][i] += two_mu_ * force[c];  // (6), first term, of T<p,q>
            std::copy_n(F, 9, to), std::copy_n(X, 3, to + 9);
            return;
        }
        Real S[8], K[6];
        family.sum_averaged(i, F, S);
        load_shape_inverse(i, K);
        stress_of(F, S, K, to);
        times_position(to, X, to + 9);
        for (std::size_t c = 0; c < 9 && FamilySlice<Real>::exist_in(b_); ++c)
            b_.particle_state[State::averaged_stress][c][i] = to[c] / b_.volume[i];
    }

    /// V H from sum S_pq (|Y-| - |X|)/|Y-| X (x) X.
    template <class T>
    PERIMPM_INLINE void stress_of(const T F[9], const T S[6], const T K[6], T H[9]) const {
        T SK[9], G[9];
        const T full[9] = {S[0], S[1], S[2], S[1], S[3], S[4], S[2], S[4], S[5]};
        times_symmetric(full, K, SK);
        for (int c = 0; c < 9; ++c) G[c] = T(two_mu_) * F[c];
        for (int r = 0; r < 9; r += 3)
            for (int c = 0; c < 3; ++c) H[r + c] = G[r] * SK[c] + G[r + 1] * SK[3 + c] + G[r + 2] * SK[6 + c];
    }
    /// V H X with X counted from the material's first particle.
    template <class T>
    PERIMPM_INLINE void times_position(const T H[9], const T X[3], T out[3]) const {
        const Real* origin = b_.family.reference;
        const T from[3] = {X[0] - origin[0], X[1] - origin[1], X[2] - origin[2]};
        for (int r = 0; r < 3; ++r) out[r] = H[3 * r] * from[0] + H[3 * r + 1] * from[1] + H[3 * r + 2] * from[2];
    }

    /// What neighbours that go alone read, side by side: F- and X (as printed), or V H and V H X.
    Real* record(std::uint32_t i) const { return b_.particle_state[State::record].data + kSumRecord * std::size_t{i}; }
    void load_shape_inverse(std::uint32_t i, Real K[6]) const {
        for (std::size_t c = 0; c < 6; ++c) K[c] = b_.particle_state[State::shape_inverse][c][i];
    }

    Block<Real>& b_;
    Real lambda_, two_mu_;
    bool printed_;
    const BondFields& at_;
    AveragedFamily<Real> family_[2];
    Real mean_[2][9];  ///< F- of the families
};

/// A call of its own, without a law's type in it: all laws then have the same bits.
template <class Real>
[[gnu::noinline]] void average_families(Block<Real>& b, const BondFields& at, const SpringModuli& moduli,
                                        bool printed) {
    AveragedSweep<Real>(b, at, moduli, printed)();
}

}  // namespace perimpm::peridynamics
