#include <random>

#include "perimpm/math/svd3.hpp"
#include "support/catch.hpp"

using namespace perimpm;

namespace {

template <class Real>
Real distance(const Mat3<Real>& a, const Mat3<Real>& b) {
    Real largest = 0;
    for (int c = 0; c < 9; ++c) largest = std::max(largest, std::abs(a.m[c] - b.m[c]));
    return largest;
}

template <class Real>
Real size(const Mat3<Real>& a) {
    return distance(a, Mat3<Real>{});
}

/// U and V proper rotations, ordered values, the last one with det F's sign, and F again, all to rounding.
template <class Real>
void check_svd(const Mat3<Real>& F) {
    constexpr Real tolerance = 16 * std::numeric_limits<Real>::epsilon();
    const Svd3<Real> r = svd3(F);
    const auto identity = Mat3<Real>::identity();
    CHECK(distance(transpose(r.U) * r.U, identity) <= tolerance);
    CHECK(distance(transpose(r.V) * r.V, identity) <= tolerance);
    CHECK(std::abs(determinant(r.U) - 1) <= tolerance);
    CHECK(std::abs(determinant(r.V) - 1) <= tolerance);
    CHECK(r.sigma[0] >= r.sigma[1]);
    CHECK(r.sigma[1] >= std::abs(r.sigma[2]) - tolerance * r.sigma[0]);
    const Mat3<Real> again = r.U * Mat3<Real>::diagonal(r.sigma[0], r.sigma[1], r.sigma[2]) * transpose(r.V);
    CHECK(distance(again, F) <= tolerance * size(F));
}

template <class Real>
Mat3<Real> random_matrix(std::mt19937& random) {
    std::uniform_real_distribution<Real> entry(-1, 1);
    Mat3<Real> F;
    for (Real& c : F.m) c = entry(random);
    return F;
}

/// A rotation: the left factor of a random matrix.
template <class Real>
Mat3<Real> random_rotation(std::mt19937& random) {
    return svd3(random_matrix<Real>(random)).U;
}

}  // namespace

TEMPLATE_TEST_CASE("svd3: random matrices come back, inverted ones included", "[math]", float, double) {
    std::mt19937 random(1);
    for (int i = 0; i < 1000; ++i) check_svd(random_matrix<TestType>(random));
}

TEMPLATE_TEST_CASE("svd3: special matrices have proper rotations", "[math]", float, double) {
    using M = Mat3<TestType>;
    const M special[] = {M::identity(),
                         M::diagonal(0, 0, 0),
                         M::diagonal(-1, 1, 1),
                         M::diagonal(-1, -1, -1),
                         M::diagonal(2, 2, -2),
                         M::diagonal(1, 1, TestType(1e-8)),
                         M::diagonal(TestType(1e-8), 1, 1),
                         M::diagonal(3, 0, 0),
                         M::diagonal(0, 0, -3),
                         M::diagonal(0, 2, 2),
                         {0, 1, 0, 0, 0, 0, 0, 0, 0},
                         {1, 1, 1, 1, 1, 1, 1, 1, 1},
                         {0, 1, 0, 0, 0, 1, 1, 0, 0}};
    for (const M& F : special) {
        CAPTURE(F.m[0], F.m[4], F.m[8]);
        check_svd(F);
    }
}

TEMPLATE_TEST_CASE("svd3: repeated and small singular values survive rotations", "[math]", float, double) {
    std::mt19937 random(2);
    const TestType values[][3] = {{1, 1, 1},  {2, 2, 1}, {2, 1, 1}, {1, 1, TestType(1e-8)}, {1, TestType(1e-6), 0},
                                  {1, 1, -1}, {1, 0, 0}};
    for (const auto& s : values)
        for (int i = 0; i < 100; ++i) {
            const auto F = random_rotation<TestType>(random) * Mat3<TestType>::diagonal(s[0], s[1], s[2]) *
                           random_rotation<TestType>(random);
            check_svd(F);
            CHECK(std::abs(svd3(F).sigma[2] - s[2]) <= 16 * std::numeric_limits<TestType>::epsilon());
        }
}

TEMPLATE_TEST_CASE("svd3: singular values of a diagonal matrix are exact, however small", "[math]", float, double) {
    const auto r = svd3(Mat3<TestType>::diagonal(TestType(1e-8), 1, TestType(0.5)));
    CHECK(r.sigma[0] == TestType(1));
    CHECK(r.sigma[1] == TestType(0.5));
    CHECK(std::abs(r.sigma[2] / TestType(1e-8) - 1) <= std::numeric_limits<TestType>::epsilon());
}

TEMPLATE_TEST_CASE("orthogonalise_columns: every lane of a pack comes out as a number would", "[math]", float, double) {
    using P = Pack<TestType>;
    using M = Mat3<TestType>;
    constexpr TestType tolerance = 16 * std::numeric_limits<TestType>::epsilon();
    std::mt19937 random(3);
    for (int trial = 0; trial < 200; ++trial) {
        M lanes[kLanes<TestType>];
        for (auto& lane : lanes) lane = random_matrix<TestType>(random);
        lanes[0] = M::diagonal(1, 1, 1);  // converged at once, beside lanes that are not
        Mat3<P> B, V = Mat3<P>::identity();
        for (int c = 0; c < 9; ++c) B.m[c] = P([&](std::size_t lane) { return lanes[lane].m[c]; });
        orthogonalise_columns(B, &V);
        for (std::size_t lane = 0; lane < kLanes<TestType>; ++lane) {
            M b, v;
            for (int c = 0; c < 9; ++c) b.m[c] = B.m[c][lane], v.m[c] = V.m[c][lane];
            CHECK(distance(transpose(v) * v, M::identity()) <= tolerance);
            CHECK(distance(lanes[lane] * v, b) <= tolerance);
            const M gram = transpose(b) * b;
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < i; ++j)
                    CHECK(std::abs(gram(i, j)) <= tolerance * std::sqrt(gram(i, i) * gram(j, j)));
#if !defined(__FMA__)  // contraction is the compiler's choice, else the operations are the same
            M expected_b = lanes[lane], expected_v = M::identity();
            orthogonalise_columns(expected_b, &expected_v);
            CHECK(distance(b, expected_b) == 0);
            CHECK(distance(v, expected_v) == 0);
#endif
        }
    }
}
