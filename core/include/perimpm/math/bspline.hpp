#pragma once

#include <cmath>
#include <cstdint>

namespace perimpm {

/// Weights of the degree-`Order` B-spline at x (in units of dx) in one dimension: `Order + 1` nodes from `base`.
/// dw is the derivative in 1/dx, d the node's distance from x in dx. Rows are padded to four.
template <class Real, int Order>
struct BSpline {
    static_assert(Order >= 1 && Order <= 3);
    static constexpr int kNodes = Order + 1;

    std::int32_t base;
    Real w[4], dw[4], d[4];

    explicit BSpline(Real x) {
        const Real start = std::floor(Order == 2 ? x - Real(0.5) : x) - (Order == 3 ? Real(1) : Real(0));
        base = static_cast<std::int32_t>(start);
        const Real f = x - start;  // linear [0,1), quadratic [1/2,3/2), cubic [1,2)
        for (int i = 0; i < 4; ++i) w[i] = dw[i] = d[i] = Real(0);
        for (int i = 0; i < kNodes; ++i) d[i] = Real(i) - f;
        if constexpr (Order == 1) {
            w[0] = 1 - f, w[1] = f;
            dw[0] = -1, dw[1] = 1;
        } else if constexpr (Order == 2) {
            const Real a = Real(1.5) - f, b = f - 1, c = f - Real(0.5);
            w[0] = Real(0.5) * a * a, w[1] = Real(0.75) - b * b, w[2] = Real(0.5) * c * c;
            dw[0] = -a, dw[1] = -2 * b, dw[2] = c;
        } else {
            const Real a = 2 - f, b = f - 1;  // distances to the two middle nodes' far sides, a + b = 1
            constexpr Real sixth = Real(1) / 6, two_thirds = Real(2) / 3;
            w[0] = sixth * a * a * a, w[3] = sixth * b * b * b;
            w[1] = two_thirds - b * b + Real(0.5) * b * b * b;
            w[2] = two_thirds - a * a + Real(0.5) * a * a * a;
            dw[0] = Real(-0.5) * a * a, dw[3] = Real(0.5) * b * b;
            dw[1] = -2 * b + Real(1.5) * b * b;
            dw[2] = 2 * a - Real(1.5) * a * a;
        }
    }
};

/// Second moment of the spline, D = kSecondMoment dx^2 (Jiang et al. 2015, below eq. 8); constant for degrees 2 and 3.
template <int Order>
inline constexpr double kSecondMoment = Order == 2 ? 1.0 / 4 : 1.0 / 3;

}  // namespace perimpm
