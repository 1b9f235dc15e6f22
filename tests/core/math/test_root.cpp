#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "perimpm/math/root.hpp"
#include "support/catch.hpp"

using namespace perimpm;

namespace {

template <class Real>
Pack<Real> pack_of(const Real* numbers) {
    return Pack<Real>(numbers, std::experimental::element_aligned);
}
/// Relative error of the reciprocal of x, in units of the last place, in twice the precision.
template <class Real>
double error_of(Real inverse, long double x) {
    return static_cast<double>(std::abs(static_cast<long double>(inverse) * x - 1) /
                               static_cast<long double>(std::numeric_limits<Real>::epsilon()));
}

}  // namespace

TEST_CASE("root: every root of single precision is the nearest number", "[math]") {
    // a factor of 4 changes exponents only: these are all mantissas
    std::vector<float> x(kLanes<float>);
    std::uint32_t wrong = 0;
    double worst = 0, worst_inverse = 0;
    for (std::uint32_t bits = 0x3f800000u; bits < 0x40800000u; bits += kLanes<float>) {
        for (std::uint32_t lane = 0; lane < kLanes<float>; ++lane) {
            const std::uint32_t own = bits + lane;
            std::memcpy(&x[lane], &own, sizeof own);
        }
        const Root<Pack<float>> found = root_of(pack_of(x.data()));
        const Pack<float> inverse = inverse_of(pack_of(x.data()));
        for (std::size_t lane = 0; lane < kLanes<float>; ++lane) {
            wrong += float(found.root[lane]) != std::sqrt(x[lane]);
            worst = std::max(worst, error_of(float(found.inverse[lane]), std::sqrt(static_cast<long double>(x[lane]))));
            worst_inverse = std::max(worst_inverse, error_of(float(inverse[lane]), x[lane]));
        }
    }
    CHECK(wrong == 0);
    CHECK(worst < 1);
    CHECK(worst_inverse < 1);
}

TEST_CASE("root: roots of double precision are the nearest numbers", "[math]") {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> mantissa(1, 4), exponent(-280, 280);
    std::vector<double> x(kLanes<double>);
    int wrong = 0;
    double worst = 0, worst_inverse = 0;
    for (int k = 0; k < 1000000; ++k) {
        for (double& number : x) number = mantissa(random) * std::pow(10.0, exponent(random));
        const Root<Pack<double>> found = root_of(pack_of(x.data()));
        const Pack<double> inverse = inverse_of(pack_of(x.data()));
        for (std::size_t lane = 0; lane < kLanes<double>; ++lane) {
            wrong += double(found.root[lane]) != std::sqrt(x[lane]);
            worst =
                std::max(worst, error_of(double(found.inverse[lane]), std::sqrt(static_cast<long double>(x[lane]))));
            worst_inverse = std::max(worst_inverse, error_of(double(inverse[lane]), x[lane]));
        }
    }
    CHECK(wrong == 0);
    CHECK(worst < 1);
    CHECK(worst_inverse < 1);
}

TEMPLATE_TEST_CASE("root: that of 0 is 0, and so is its reciprocal", "[math]", float, double) {
    const TestType smallest = std::numeric_limits<TestType>::min();
    std::vector<TestType> x(kLanes<TestType>, smallest);
    x[0] = 0;
    const Root<Pack<TestType>> found = root_of(pack_of(x.data()));
    const Pack<TestType> inverse = inverse_length(pack_of(x.data()));
    CHECK(TestType(found.root[0]) == 0);
    CHECK(TestType(found.inverse[0]) == 0);
    CHECK(TestType(inverse[0]) == 0);
    for (std::size_t lane = 1; lane < x.size(); ++lane) {
        CHECK(TestType(found.root[lane]) == std::sqrt(smallest));
        CHECK_THAT(double(TestType(found.inverse[lane])),
                   WithinRel(double(1 / std::sqrt(smallest)), 2 * double(std::numeric_limits<TestType>::epsilon())));
        CHECK_THAT(double(TestType(inverse[lane])),
                   WithinRel(double(1 / smallest), 2 * double(std::numeric_limits<TestType>::epsilon())));
    }
    CHECK(root_of(TestType(9)).root == 3);
    CHECK(root_of(TestType(9)).inverse == TestType(1) / 3);
    CHECK(root_of(TestType(0)).inverse == 0);
}

TEMPLATE_TEST_CASE("root: the shortening of small strains has digits that 1 + u has lost", "[math]", float, double) {
    using P = Pack<TestType>;
    constexpr double eps = std::numeric_limits<TestType>::epsilon();
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> exponent(-9, 0), sign(-1, 1);
    // what a step from 14 bits leaves: in single precision next to nothing of u, in double a fourth of a rounding of 1
    const double left = sizeof(TestType) == sizeof(float) ? 4 * std::ldexp(eps, -14) : eps / 4;
    double worst = 0;
    for (int k = 0; k < 200000; ++k) {
        const TestType u(static_cast<TestType>(std::copysign(0.9 * std::pow(10.0, exponent(random)), sign(random))));
        const auto x = static_cast<long double>(u), z = std::sqrt(1 + x), exact = x / (z * (1 + z));
        const double error = static_cast<double>(std::abs(TestType(shortening_of(P(u))[0]) - exact));
        const double size = static_cast<double>(std::abs(exact));
        worst = std::max(worst, error / ((size < 1e-3 ? 4 : 32) * eps * size + left));
    }
    CHECK(worst < 1);
    for (const TestType none : {TestType(0), TestType(-1), TestType(-2)})
        CHECK(TestType(shortening_of(P(none))[0]) == 0);
    CHECK_THAT(double(TestType(shortening_of(P(TestType(3)))[0])),
               WithinRel(0.5, 2 * double(std::numeric_limits<TestType>::epsilon())));
}
