// Reference: U V^T of Eigen's Jacobi SVD in long double, of the same rounded F. A perturbation eps |F| of F turns the rotation
// by up to 2 eps s_1 / (s_2 + s_3) (Higham 2008, theorem 8.9, with signed singular values): that is the unit of the error.
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <random>

#include "perimpm/math/polar3.hpp"
#include "support/catch.hpp"

using namespace perimpm;

namespace {

using Long3 = Eigen::Matrix<long double, 3, 3>;
using LongVector = Eigen::Matrix<long double, 3, 1>;

constexpr double kFewEpsilon = 6;

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

template <class Real>
Long3 wide(const Mat3<Real>& F) {
    Long3 out;
    for (int c = 0; c < 9; ++c) out(c / 3, c % 3) = static_cast<long double>(F.m[c]);
    return out;
}

/// Error of R in units of the precision's epsilon times the conditioning of the rotation.
template <class Real>
double error(const Mat3<Real>& F, const Mat3<Real>& R) {
    const Eigen::JacobiSVD<Long3> svd(wide(F), Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Long3 exact = svd.matrixU() * svd.matrixV().transpose();
    const LongVector s = svd.singularValues();
    const long double unit = std::numeric_limits<Real>::epsilon() * (1 + 2 * s[0] / (s[1] + s[2]));
    return static_cast<double>((wide(R) - exact).norm() / unit);
}

/// Singular values 1, then two between 1 and 1 / `condition`, evenly in their logarithms.
LongVector values(double condition, std::mt19937& random) {
    std::uniform_real_distribution<double> exponent(-1, 0);
    return {1, std::pow(condition, exponent(random)), std::pow(condition, exponent(random))};
}

}  // namespace

TEMPLATE_TEST_CASE("polar_rotation: a few epsilon from the SVD's rotation, at any scale", "[math]", float, double) {
    std::mt19937 random(1);
    for (const double condition : {2.0, 10.0, 1e3}) {
        double worst = 0;
        for (int trial = 0; trial < 500; ++trial) {
            std::uniform_real_distribution<double> exponent(-8, 8);
            const LongVector s = values(condition, random);
            const Mat3<TestType> F = turned<TestType>(s * std::pow(10.0L, exponent(random)), random);
            Mat3<TestType> R;
            const bool found = polar_rotation(F, determinant(F), R);
            // With |F|^2 = 3, det F > 0.03 leaves no singular value below 0.03 after the first iteration; from there
            // 8 iterations by a factor of 1.5 and 5 more reach 1.
            CAPTURE(condition, s[1], s[2]);
            CHECK((found || s.prod() * std::pow(3 / s.squaredNorm(), 1.5L) <= 0.03L));
            if (found) worst = std::max(worst, error(F, R));
        }
        CHECK(worst <= kFewEpsilon);
    }
}

TEMPLATE_TEST_CASE("polar_rotation: deformations near a rotation", "[math]", float, double) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> entry(-1, 1);
    for (const double strain : {0.0, 1e-12, 1e-7, 1e-4, 0.01, 0.3})
        for (int trial = 0; trial < 100; ++trial) {
            const LongVector s = LongVector(1, 1, 1) + strain * LongVector(entry(random), entry(random), entry(random));
            const Mat3<TestType> F = turned<TestType>(s, random);
            Mat3<TestType> R;
            CAPTURE(strain);
            REQUIRE(polar_rotation(F, determinant(F), R));
            CHECK(error(F, R) <= kFewEpsilon);
        }
    Mat3<TestType> R;
    REQUIRE(polar_rotation(Mat3<TestType>::identity(), TestType(1), R));
    CHECK((wide(R) - Long3::Identity()).norm() == 0);
}

TEMPLATE_TEST_CASE("polar_rotation: refuses what is inverted or nearly singular", "[math]", float, double) {
    using M = Mat3<TestType>;
    constexpr TestType nan = std::numeric_limits<TestType>::quiet_NaN();
    const M refused[] = {M::diagonal(0, 0, 0),
                         M::diagonal(1, 1, 0),
                         M::diagonal(1, 1, TestType(1e-8)),
                         M::diagonal(-1, 1, 1),
                         M::diagonal(1, 1, -2),
                         M::diagonal(-1, -1, -1),
                         M::diagonal(nan, 1, 1),
                         M::diagonal(1, TestType(1e-3), TestType(1e-3)),
                         {1, 1, 1, 1, 1, 1, 1, 1, 1}};
    for (const M& F : refused) {
        M R;
        CAPTURE(F.m[0], F.m[4], F.m[8]);
        CHECK_FALSE(polar_rotation(F, determinant(F), R));
    }
    std::mt19937 random(3);
    for (int trial = 0; trial < 100; ++trial) {
        LongVector s = values(10, random);
        s[2] = -s[2];
        const M F = turned<TestType>(s, random);
        M R;
        CHECK_FALSE(polar_rotation(F, determinant(F), R));
    }
}

TEMPLATE_TEST_CASE("polar_rotation: packs are right in every lane, and refused for one bad lane", "[math]", float,
                   double) {
    using P = Pack<TestType>;
    constexpr std::size_t N = kLanes<TestType>;
    std::mt19937 random(4);
    for (int trial = 0; trial < 100; ++trial) {
        Mat3<TestType> lanes[N];
        for (auto& lane : lanes) lane = turned<TestType>(values(10, random), random);
        const auto pack = [&] {
            Mat3<P> F;
            for (int c = 0; c < 9; ++c) F.m[c] = P([&](std::size_t lane) { return lanes[lane].m[c]; });
            return F;
        };
        Mat3<P> F = pack(), R;
        REQUIRE(polar_rotation(F, determinant(F), R));
        for (std::size_t lane = 0; lane < N; ++lane) {
            Mat3<TestType> own;
            for (int c = 0; c < 9; ++c) own.m[c] = R.m[c][lane];
            CHECK(error(lanes[lane], own) <= kFewEpsilon);
        }
        lanes[static_cast<std::size_t>(trial) % N] = Mat3<TestType>::diagonal(1, 1, -1);
        F = pack();
        CHECK_FALSE(polar_rotation(F, determinant(F), R));
    }
}
