// Reference: U S U^T of Eigen's Jacobi SVD in long double, of the same rounded F. The stretch comes from b = F F^T, whose
// rounding eps |F|^2 changes it by up to that over the smallest sum of two (signed) stretches: that is the unit of the error.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <random>

#include "perimpm/math/stretch3.hpp"
#include "support/catch.hpp"

using namespace perimpm;

namespace {

using Long3 = Eigen::Matrix<long double, 3, 3>;
using LongVector = Eigen::Matrix<long double, 3, 1>;

constexpr double kFewEpsilon = 10;  ///< as many roundings lie between F and V

/// Uniform over rotations: a normalised quaternion of normal numbers.
Long3 random_rotation(std::mt19937& random) {
    std::normal_distribution<double> normal;
    Eigen::Quaternion<long double> q(normal(random), normal(random), normal(random), normal(random));
    return q.normalized().toRotationMatrix();
}

/// U diag(s) V^T with random U and V.
template <class Real>
Mat3<Real> turned(const LongVector& s, std::mt19937& random) {
    const Long3 F = random_rotation(random) * s.asDiagonal() * random_rotation(random);
    Mat3<Real> rounded;
    for (int c = 0; c < 9; ++c) rounded.m[c] = static_cast<Real>(F(c / 3, c % 3));
    return rounded;
}

template <class T>
bool stretch(const Mat3<T>& F, T V[6]) {
    T b[6];
    left_cauchy_green(F, b);
    return left_stretch(b, determinant(F), V);
}

/// Error of V relative to |F|, in units of the precision's epsilon times the conditioning.
template <class Real>
double error(const Mat3<Real>& F, const Real V[6]) {
    Long3 wide, found;
    for (int c = 0; c < 9; ++c) wide(c / 3, c % 3) = static_cast<long double>(F.m[c]);
    found << V[0], V[1], V[2], V[1], V[3], V[4], V[2], V[4], V[5];
    const Eigen::JacobiSVD<Long3> svd(wide, Eigen::ComputeFullU);
    LongVector s = svd.singularValues();
    if (wide.determinant() < 0) s[2] = -s[2];
    const Long3 exact = svd.matrixU() * s.asDiagonal() * svd.matrixU().transpose();
    const long double unit = std::numeric_limits<Real>::epsilon() * wide.squaredNorm() / (s[1] + s[2]);
    return static_cast<double>((found - exact).norm() / unit);
}

/// D / i_1^3 of the header.
long double denominator(const LongVector& s) {
    return (s[0] + s[1]) * (s[1] + s[2]) * (s[2] + s[0]) / std::pow(s.sum(), 3.0L);
}

}  // namespace

TEMPLATE_TEST_CASE("left_stretch: a few epsilon from the SVD's, at any scale, inverted or not", "[math]", float,
                   double) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> exponent(-6, 6), entry(-1, 1);
    int found = 0, inverted = 0;
    double worst = 0;
    for (int trial = 0; trial < 2000; ++trial) {
        const LongVector s(1, std::abs(entry(random)), entry(random));
        const Mat3<TestType> F = turned<TestType>(s * std::pow(10.0L, exponent(random)), random);
        TestType V[6];
        LongVector sorted = s.cwiseAbs();
        std::sort(sorted.data(), sorted.data() + 3, std::greater<>());
        if (s[2] < 0) sorted[2] = -sorted[2];
        const bool done = stretch(F, V);
        CAPTURE(s[0], s[1], s[2]);
        if (denominator(sorted) > 0.0626L) CHECK(done);
        if (denominator(sorted) < 0.0624L) CHECK_FALSE(done);
        if (!done) continue;
        ++found, inverted += s[2] < 0;
        worst = std::max(worst, error(F, V));
    }
    CHECK(worst <= kFewEpsilon);
    CHECK(found > 1000);
    CHECK(inverted > 100);
}

TEMPLATE_TEST_CASE("left_stretch: deformations near a rotation", "[math]", float, double) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> entry(-1, 1);
    for (const double strain : {0.0, 1e-12, 1e-7, 1e-4, 0.01, 0.3})
        for (int trial = 0; trial < 100; ++trial) {
            const LongVector s = LongVector(1, 1, 1) + strain * LongVector(entry(random), entry(random), entry(random));
            const Mat3<TestType> F = turned<TestType>(s, random);
            TestType V[6];
            CAPTURE(strain);
            REQUIRE(stretch(F, V));
            CHECK(error(F, V) <= kFewEpsilon);
        }
    TestType V[6];
    REQUIRE(stretch(Mat3<TestType>::identity(), V));
    for (int c = 0; c < 6; ++c) CHECK(V[c] == (c == 0 || c == 3 || c == 5 ? 1 : 0));
}

TEMPLATE_TEST_CASE("left_stretch: refuses where stretches cancel or vanish", "[math]", float, double) {
    using M = Mat3<TestType>;
    constexpr TestType nan = std::numeric_limits<TestType>::quiet_NaN();
    const M refused[] = {M::diagonal(0, 0, 0),       M::diagonal(-1, 1, 1),
                         M::diagonal(-1, -1, -1),    M::diagonal(3, 1, TestType(-0.999)),
                         M::diagonal(nan, 1, 1),     M::diagonal(1, TestType(1e-3), TestType(1e-3)),
                         {1, 1, 1, 1, 1, 1, 1, 1, 1}};
    for (const M& F : refused) {
        TestType V[6];
        CAPTURE(F.m[0], F.m[4], F.m[8]);
        CHECK_FALSE(stretch(F, V));
    }
}

TEMPLATE_TEST_CASE("left_stretch: packs are right in every lane, and refused for one bad lane", "[math]", float,
                   double) {
    using P = Pack<TestType>;
    constexpr std::size_t N = kLanes<TestType>;
    std::mt19937 random(4);
    std::uniform_real_distribution<double> value(0.2, 1.5);
    for (int trial = 0; trial < 100; ++trial) {
        Mat3<TestType> lanes[N];
        for (auto& lane : lanes)
            lane = turned<TestType>(LongVector(value(random), value(random), value(random)), random);
        const auto pack = [&] {
            Mat3<P> F;
            for (int c = 0; c < 9; ++c) F.m[c] = P([&](std::size_t lane) { return lanes[lane].m[c]; });
            return F;
        };
        P V[6];
        REQUIRE(stretch(pack(), V));
        for (std::size_t lane = 0; lane < N; ++lane) {
            TestType own[6];
            for (int c = 0; c < 6; ++c) own[c] = V[c][lane];
            CHECK(error(lanes[lane], own) <= kFewEpsilon);
        }
        lanes[static_cast<std::size_t>(trial) % N] = Mat3<TestType>::diagonal(1, 1, -1);
        CHECK_FALSE(stretch(pack(), V));
    }
}
