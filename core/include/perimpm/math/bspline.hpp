#pragma once

#include <cmath>

#include "perimpm/math/simd.hpp"

namespace perimpm {

/// Weights of the degree-`Order` B-spline in one dimension at `offset` (in units of dx) from the first of its `Order + 1`
/// nodes: linear [0,1), quadratic [1/2,3/2), cubic [1,2). dw is the derivative in 1/dx. T: a number or a pack. Rows are
/// padded to four with zeros.
template <class T, int Order>
struct BSplineWeights {
    static_assert(Order >= 1 && Order <= 3);

    T w[4], dw[4];

    explicit BSplineWeights(const T& f) {
        using Real = Scalar<T>;
        if constexpr (Order == 1) {
            w[0] = T(1) - f, w[1] = f, w[2] = w[3] = T(0);
            dw[0] = T(-1), dw[1] = T(1), dw[2] = dw[3] = T(0);
        } else if constexpr (Order == 2) {
            const T a = Real(1.5) - f, b = f - Real(1), c = f - Real(0.5);
            w[0] = Real(0.5) * a * a, w[1] = Real(0.75) - b * b, w[2] = Real(0.5) * c * c, w[3] = T(0);
            dw[0] = -a, dw[1] = Real(-2) * b, dw[2] = c, dw[3] = T(0);
        } else {
            const T a = Real(2) - f, b = f - Real(1);  // distances to the two middle nodes' far sides, a + b = 1
            constexpr Real half = Real(0.5), sixth = Real(1) / 6, two_thirds = Real(2) / 3;
            w[0] = sixth * a * a * a, w[3] = sixth * b * b * b;
            w[1] = two_thirds - b * b + half * b * b * b;
            w[2] = T(1) - (w[0] + w[3]) - w[1];  // 2/3 is rounded up: with it, every step would add momentum
            dw[0] = -half * a * a, dw[3] = half * b * b;
            dw[1] = Real(1.5) * b * b - Real(2) * b;
            dw[2] = Real(2) * a - Real(1.5) * a * a;
        }
    }
};

/// Where the stencil of x (in units of dx) begins, and its weights.
template <class T, int Order>
struct BSpline : BSplineWeights<T, Order> {
    T base, offset;  ///< first node; x - base

    explicit BSpline(const T& x) : BSpline(x, first_node(x)) {}

private:
    BSpline(const T& x, const T& first) : BSplineWeights<T, Order>(x - first), base(first), offset(x - first) {}
    static T first_node(const T& x) {
        using std::floor;
        using Real = Scalar<T>;
        return floor(Order == 2 ? x - Real(0.5) : x) - Real(Order == 3 ? 1 : 0);
    }
};

/// Second moment of the spline, D = kSecondMoment dx^2 (Jiang et al. 2015, below eq. 8); constant for degrees 2 and 3.
template <int Order>
inline constexpr double kSecondMoment = Order == 2 ? 1.0 / 4 : 1.0 / 3;
/// The same of degree 1, at x (in units of dx): zero at nodes.
inline double linear_second_moment(double x) {
    const double f = x - std::floor(x);
    return f * (1 - f);
}

/// Affine particles carry C = B / (kCarriedMoment dx^2): B D^-1, the velocity gradient, for degrees 2 and 3; for degree
/// 1, whose D vanishes at nodes, B / dx^2.
template <int Order>
inline constexpr double kCarriedMoment = Order == 1 ? 1.0 : kSecondMoment<Order>;

}  // namespace perimpm
