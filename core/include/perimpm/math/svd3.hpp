#pragma once

#include <limits>

#include "perimpm/math/mat3.hpp"

namespace perimpm {

namespace detail {

/// Turns columns p and q of B by the angle that makes them orthogonal; V turns along when given. Lanes that are
/// orthogonal to rounding already stay untouched. Returns where a turn was made.
template <class T>
PERIMPM_INLINE auto orthogonalise(Mat3<T>& B, Mat3<T>* V, int p, int q) {
    using std::abs, std::sqrt;
    constexpr Scalar<T> eps = std::numeric_limits<Scalar<T>>::epsilon();
    T alpha = T(0), beta = T(0), gamma = T(0);
    for (int i = 0; i < 3; ++i) {
        alpha += B(i, p) * B(i, p);
        beta += B(i, q) * B(i, q);
        gamma += B(i, p) * B(i, q);
    }
    const auto turn = gamma * gamma > (Scalar<T>(0.25) * eps * eps * alpha) * beta;
    const T delta = beta - alpha;
    const T twice = gamma + gamma;
    const T root = abs(delta) + sqrt(delta * delta + twice * twice);
    const T t = select(turn, select(delta < T(0), -twice, twice) / select(turn, root, T(1)), T(0));
    const T c = T(1) / sqrt(T(1) + t * t);
    const T s = c * t;
    for (int i = 0; i < 3; ++i) {
        const T bp = B(i, p), bq = B(i, q);
        B(i, p) = c * bp - s * bq;
        B(i, q) = s * bp + c * bq;
    }
    for (int i = 0; V && i < 3; ++i) {
        const T vp = (*V)(i, p), vq = (*V)(i, q);
        (*V)(i, p) = c * vp - s * vq;
        (*V)(i, q) = s * vp + c * vq;
    }
    return turn;
}

}  // namespace detail

/// One-sided Jacobi (Hestenes 1958): B <- B V with orthogonal columns, V a rotation; V turns along when given. The
/// column lengths are the singular values, to high relative accuracy (Demmel & Veselic 1992). Works on numbers and on
/// packs.
template <class T>
void orthogonalise_columns(Mat3<T>& B, Mat3<T>* V = nullptr) {
    constexpr int kMaxSweeps = 12;
    for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
        const auto a = detail::orthogonalise(B, V, 0, 1);
        const auto b = detail::orthogonalise(B, V, 0, 2);
        const auto c = detail::orthogonalise(B, V, 1, 2);
        if (all(!(a || b || c))) return;
    }
}

/// F = U diag(sigma) V^T with rotations U and V, sigma[0] >= sigma[1] >= |sigma[2]|; the last one carries det F's sign.
template <class Real>
struct Svd3 {
    Mat3<Real> U, V;
    Real sigma[3];
};

/// For single matrices (reference quantities, tests); laws use orthogonalise_columns on packs.
template <class Real>
Svd3<Real> svd3(const Mat3<Real>& F) {
    Svd3<Real> r{F, Mat3<Real>::identity(), {}};
    orthogonalise_columns(r.U, &r.V);
    const auto length = [&](int j) { return std::hypot(r.U(0, j), r.U(1, j), r.U(2, j)); };
    for (int j = 0; j < 3; ++j) r.sigma[j] = length(j);
    // Swapping two columns and negating one keeps V a rotation and U's handedness.
    const auto order = [&](int p, int q) {
        if (r.sigma[p] >= r.sigma[q]) return;
        std::swap(r.sigma[p], r.sigma[q]);
        for (Mat3<Real>* M : {&r.U, &r.V})
            for (int i = 0; i < 3; ++i) {
                const Real keep = (*M)(i, p);
                (*M)(i, p) = (*M)(i, q);
                (*M)(i, q) = -keep;
            }
    };
    order(0, 1), order(0, 2), order(1, 2);
    // U: the first column normalised, the second made orthogonal to it, the third their cross product, so that U is a
    // rotation also where singular values vanish.
    const auto normalise = [&](int j, Real by) {
        for (int i = 0; i < 3; ++i) r.U(i, j) /= by;
    };
    const auto any_orthogonal = [&](int to, int j) {
        int smallest = 0;
        for (int i = 1; i < 3; ++i)
            if (std::abs(r.U(i, to)) < std::abs(r.U(smallest, to))) smallest = i;
        for (int i = 0; i < 3; ++i) r.U(i, j) = (i == smallest) - r.U(smallest, to) * r.U(i, to);
    };
    if (r.sigma[0] > 0)
        normalise(0, r.sigma[0]);
    else
        for (int i = 0; i < 3; ++i) r.U(i, 0) = i == 0;
    // A vanishing second column is rounding, which may lie along the first one.
    const Real along = r.U(0, 0) * r.U(0, 1) + r.U(1, 0) * r.U(1, 1) + r.U(2, 0) * r.U(2, 1);
    if (!(r.sigma[1] > std::numeric_limits<Real>::min() && std::abs(along) < Real(0.5) * r.sigma[1]))
        any_orthogonal(0, 1);
    else
        for (int i = 0; i < 3; ++i) r.U(i, 1) -= along * r.U(i, 0);
    normalise(1, length(1));
    const Real third[3] = {r.U(0, 2), r.U(1, 2), r.U(2, 2)};
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        r.U(i, 2) = r.U(j, 0) * r.U(k, 1) - r.U(k, 0) * r.U(j, 1);
    }
    r.sigma[2] = third[0] * r.U(0, 2) + third[1] * r.U(1, 2) + third[2] * r.U(2, 2);
    return r;
}

}  // namespace perimpm
