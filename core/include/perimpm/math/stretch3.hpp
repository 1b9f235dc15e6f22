#pragma once

#include <limits>

#include "perimpm/math/mat3.hpp"

namespace perimpm {

/// F F^T, components xx xy xz yy yz zz.
template <class T>
PERIMPM_INLINE void left_cauchy_green(const Mat3<T>& F, T b[6]) {
    int component = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) b[component++] = F(i, 0) * F(j, 0) + F(i, 1) * F(j, 1) + F(i, 2) * F(j, 2);
}

/*! Left stretch V of F = V R with a rotation R, from b = V^2 = F F^T by the invariants of V (Hoger & Carlson 1984,
    doi:10.1090/qam/736512; components as of b):
      (1) D V = -b^2 + (i_1^2 - i_2) b + i_1 i_3 I,   D = i_1 i_2 - i_3 = (s_1 + s_2)(s_2 + s_3)(s_3 + s_1),   i_3 = det F
    The trace i_1 is the largest root of (t^2 - I_1)^2 - 8 i_3 t - 4 I_2 with the invariants I_1, I_2 of b; Newton's iteration
    falls to it from sqrt(3 I_1). With b = I_1/3 I + d, (1) is
      (2) V = i_1/3 I + ((i_1^2/2 - I_1/6) d - dev d^2) / D
    where nothing cancels near a rotation. The smallest stretch carries the sign of det F. False when in some lane two
    stretches nearly cancel or vanish beside the third: take the singular values there. Works on numbers and on packs. */
template <class T>
PERIMPM_INLINE bool left_stretch(const T b[6], const T& det_F, T V[6]) {
    using std::abs, std::sqrt;
    using Real = Scalar<T>;
    constexpr int kMaxIterations = 12;
    constexpr Real kSmallestDenominator = Real(1) / 16;  // D / i_1^3; 8/27 for equal stretches
    const Real nearly_converged = std::sqrt(std::numeric_limits<Real>::epsilon());

    const T I1 = b[0] + b[3] + b[5];
    const T I2 = b[0] * b[3] - b[1] * b[1] + (b[3] * b[5] - b[4] * b[4]) + (b[5] * b[0] - b[2] * b[2]);
    T i1 = sqrt(Real(3) * I1);
    bool converged = false;
    for (int iteration = 0; iteration < kMaxIterations && !converged; ++iteration) {
        const T excess = i1 * i1 - I1;
        const T change =
            (excess * excess - Real(8) * det_F * i1 - Real(4) * I2) / (Real(4) * i1 * excess - Real(8) * det_F);
        i1 -= change;
        converged = all(abs(change) < nearly_converged * i1);
    }
    const T D = Real(0.5) * i1 * (i1 * i1 - I1) - det_F;
    if (!converged || !all(D > kSmallestDenominator * i1 * i1 * i1)) return false;

    const T mean = I1 * Real(1.0 / 3);
    const T d[6] = {b[0] - mean, b[1], b[2], b[3] - mean, b[4], b[5] - mean};
    T d2[6] = {d[0] * d[0] + d[1] * d[1] + d[2] * d[2], d[0] * d[1] + d[1] * d[3] + d[2] * d[4],
               d[0] * d[2] + d[1] * d[4] + d[2] * d[5], d[1] * d[1] + d[3] * d[3] + d[4] * d[4],
               d[1] * d[2] + d[3] * d[4] + d[4] * d[5], d[2] * d[2] + d[4] * d[4] + d[5] * d[5]};
    const T mean2 = (d2[0] + d2[3] + d2[5]) * Real(1.0 / 3), third = i1 * Real(1.0 / 3);
    const T inverse = Real(1) / D, linear = (Real(0.5) * i1 * i1 - I1 * Real(1.0 / 6)) * inverse;
    for (int c = 0; c < 6; ++c) {
        const bool diagonal = c == 0 || c == 3 || c == 5;
        if (diagonal) d2[c] -= mean2;
        V[c] = linear * d[c] - inverse * d2[c];
        if (diagonal) V[c] += third;
    }
    return true;
}

}  // namespace perimpm
