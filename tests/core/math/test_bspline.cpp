#include <algorithm>

#include "perimpm/math/bspline.hpp"
#include "support/catch.hpp"

using namespace perimpm;

namespace {

/// Places in cells: nodes, middles, negative ones, and many between.
std::vector<double> places() {
    std::vector<double> x = {-3, -2.5, -1e-9, 0, 0.25, 0.5, 1, 1.5, 7};
    for (int i = 0; i < 200; ++i) x.push_back(-2 + 0.0213 * i);
    return x;
}

/// Mean over many places of what the weights' sum has too much.
template <class Real, int Order>
double mean_excess() {
    constexpr int kPlaces = 20000;
    double total = 0;
    for (int i = 0; i < kPlaces; ++i) {
        const BSpline<Real, Order> s(static_cast<Real>(0.61803398875 * i - std::floor(0.61803398875 * i)));
        total += double(s.w[0]) + double(s.w[1]) + double(s.w[2]) + double(s.w[3]) - 1;
    }
    return total / kPlaces;
}

template <class Real, int Order>
void check_sums() {
    constexpr Real tolerance = 16 * std::numeric_limits<Real>::epsilon();
    for (const double x : places()) {
        CAPTURE(x, Order);
        const BSpline<Real, Order> s(static_cast<Real>(x));
        Real unity = 0, derivative = 0, first = 0, slope = 0, second = 0;
        for (int i = 0; i < 4; ++i) {
            const Real d = Real(i) - s.offset;  // from x to the node
            unity += s.w[i];                    // = 1
            derivative += s.dw[i];              // = 0
            first += s.w[i] * d;                // = 0: sum_i w_i x_i = x
            slope += s.dw[i] * d;               // = 1: the derivative of sum_i w_i x_i = x
            second += s.w[i] * d * d;
        }
        CHECK(std::abs(unity - 1) <= tolerance);
        CHECK(std::abs(derivative) <= tolerance);
        CHECK(std::abs(first) <= 8 * tolerance);
        CHECK(std::abs(slope - 1) <= 8 * tolerance);
        // Order 1 has the moment f (1 - f), which vanishes at nodes; the constants are 1/4 and 1/3 (Jiang et al. 2015).
        const Real f = static_cast<Real>(x) - std::floor(static_cast<Real>(x));
        const Real moment = Order == 1 ? f * (1 - f) : Order == 2 ? Real(1) / 4 : Real(1) / 3;
        CHECK(std::abs(second - moment) <= 8 * tolerance);
        if (Order > 1) CHECK(std::abs(static_cast<Real>(kSecondMoment<Order>) - moment) <= tolerance);
    }
}

/// The degree-n B-spline at distance t from a node: the (n + 1)-fold convolution of the unit box.
double box_convolution(int order, double t) {
    t = std::abs(t);
    if (order == 1) return std::max(0.0, 1 - t);
    if (order == 2) return t < 0.5 ? 0.75 - t * t : t < 1.5 ? 0.5 * (1.5 - t) * (1.5 - t) : 0.0;
    return t < 1 ? 2.0 / 3 - t * t + t * t * t / 2 : t < 2 ? (2 - t) * (2 - t) * (2 - t) / 6 : 0.0;
}

template <int Order>
void check_values() {
    for (const double x : places()) {
        const BSpline<double, Order> s(x);
        for (int i = 0; i <= Order; ++i) {
            CAPTURE(x, Order, i);
            const double t = x - (s.base + i);
            CHECK(std::abs(s.w[i] - box_convolution(Order, t)) <= 1e-14);
            CHECK(s.offset == Approx(x - s.base).margin(1e-14));
            const double h = 1e-6;
            if (std::abs(t * 2 - std::round(t * 2)) < 4 * h) continue;  // kinks of the derivative
            const double slope = (box_convolution(Order, t + h) - box_convolution(Order, t - h)) / (2 * h);
            CHECK(std::abs(s.dw[i] - slope) <= 1e-9);
        }
    }
}

}  // namespace

TEST_CASE("bspline: rounding does not favour one side, or momentum would grow step by step", "[math]") {
    constexpr double eps = std::numeric_limits<float>::epsilon();
    CHECK(std::abs(mean_excess<float, 1>()) < 0.02 * eps);
    CHECK(std::abs(mean_excess<float, 2>()) < 0.02 * eps);
    CHECK(std::abs(mean_excess<float, 3>()) < 0.02 * eps);
}

TEMPLATE_TEST_CASE("bspline: partition of unity and moments", "[math]", float, double) {
    check_sums<TestType, 1>();
    check_sums<TestType, 2>();
    check_sums<TestType, 3>();
}

TEST_CASE("bspline: values and derivatives of the piecewise polynomial", "[math]") {
    check_values<1>();
    check_values<2>();
    check_values<3>();
}

TEST_CASE("bspline: rows are padded with zeros", "[math]") {
    const BSpline<double, 1> s(0.3);
    CHECK(s.base == 0);
    for (int i = 2; i < 4; ++i) CHECK((s.w[i] == 0 && s.dw[i] == 0));
}
