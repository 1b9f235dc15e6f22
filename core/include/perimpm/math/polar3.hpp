#pragma once

#include <limits>

#include "perimpm/math/mat3.hpp"

namespace perimpm {

/// Rotation R of F = R U by Newton-Schulz iteration X <- X (3 I - X^T X)/2 (Higham 2008, "Functions of Matrices", eq. 8.20),
/// which needs neither square roots nor divisions and converges quadratically for singular values in (0, sqrt 3); F is
/// scaled to |F|^2 = 3 for that. False when a lane is inverted or nearly singular: take the singular values there.
/// Works on numbers and on packs.
template <class T>
bool polar_rotation(const Mat3<T>& F, const T& det_F, Mat3<T>& R) {
    using std::abs, std::sqrt;
    using Real = Scalar<T>;
    constexpr int kMaxIterations = 16;
    constexpr Real kSmallestDeterminant = Real(1e-3);  // after scaling to |F|^2 = 3
    const Real nearly_orthogonal = std::sqrt(std::numeric_limits<Real>::epsilon());

    T norm2 = F.m[0] * F.m[0];
    for (int k = 1; k < 9; ++k) norm2 += F.m[k] * F.m[k];
    const T scale = sqrt(Real(3) / norm2);
    if (!all(det_F * (scale * scale * scale) > kSmallestDeterminant)) return false;
    for (int k = 0; k < 9; ++k) R.m[k] = scale * F.m[k];
    for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
        T G[6];  // (3 I - R^T R)/2: xx xy xz yy yz zz
        int k = 0;
        for (int i = 0; i < 3; ++i)
            for (int j = i; j < 3; ++j)
                G[k++] =
                    Real(i == j ? 1.5 : 0) - Real(0.5) * (R(0, i) * R(0, j) + R(1, i) * R(1, j) + R(2, i) * R(2, j));
        T change = larger(abs(G[0] - Real(1)), larger(abs(G[3] - Real(1)), abs(G[5] - Real(1))));
        change = larger(change, larger(abs(G[1]), larger(abs(G[2]), abs(G[4]))));
        for (int i = 0; i < 3; ++i) {
            const T x = R(i, 0), y = R(i, 1), z = R(i, 2);
            R(i, 0) = x * G[0] + y * G[1] + z * G[2];
            R(i, 1) = x * G[1] + y * G[3] + z * G[4];
            R(i, 2) = x * G[2] + y * G[4] + z * G[5];
        }
        if (all(change < nearly_orthogonal)) return true;
    }
    return false;
}

}  // namespace perimpm
