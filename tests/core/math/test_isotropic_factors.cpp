// Moments of weights: closed forms of the isotropic tensor of rank four.
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <random>

#include "math/fourth_moment.hpp"
#include "perimpm/math/isotropic_factors.hpp"
#include "support/catch.hpp"

using perimpm::fourth_moment, perimpm::isotropic_fourth_moment, perimpm::kLeastFactor;
using Vec15 = Eigen::Matrix<double, 15, 1>;

namespace {
Eigen::Matrix3Xd some_directions(int count, bool flat) {
    std::mt19937 random(4);
    std::normal_distribution<double> component;
    Eigen::Matrix3Xd n(3, count);
    for (int k = 0; k < count; ++k)
        n.col(k) = Eigen::Vector3d(component(random), component(random), flat ? 0.0 : component(random)).normalized();
    return n;
}

Eigen::VectorXd factors_of(const Eigen::Matrix3Xd& n, const Eigen::VectorXd& a) {
    Eigen::VectorXd f(a.size());
    const auto count = static_cast<std::size_t>(a.size());
    perimpm::isotropic_factors({n.data(), 3 * count}, {a.data(), count}, {f.data(), count});
    return f;
}

Vec15 moment_of(const Eigen::Matrix3Xd& n, const Eigen::VectorXd& weights) {
    Vec15 moment = Vec15::Zero();
    for (Eigen::Index k = 0; k < n.cols(); ++k) moment += weights[k] * fourth_moment(n.col(k));
    return moment;
}
Vec15 isotropic(double sum, int span = 3) {
    return sum * isotropic_fourth_moment(Eigen::Matrix3d::Identity().leftCols(span));
}
}  // namespace

TEST_CASE("fourth moment: the inner product is the fourth power of the cosine", "[math]") {
    const Eigen::Vector3d n(0.3, -1.2, 0.7), m(1.1, 0.4, -0.2);
    CHECK_THAT(fourth_moment(n).dot(fourth_moment(m)), WithinRel(std::pow(n.dot(m), 4), 1e-13));
}

TEST_CASE("fourth moment: the isotropic one has the same component along every direction of its span", "[math]") {
    // (n . u)^4 averaged over the sphere: 1/5, over the circle 3/8, over a line 1
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
    for (const auto& [span, mean] : {std::pair{3, 0.2}, {2, 0.375}, {1, 1.0}}) {
        const Eigen::Matrix3Xd basis = turn.leftCols(span);
        const Vec15 moment = isotropic_fourth_moment(basis);
        for (const double angle : {0.0, 0.4, 2.1}) {
            Eigen::Vector3d u = basis.col(0);
            if (span > 1) u = std::cos(angle) * basis.col(0) + std::sin(angle) * basis.col(span - 1);
            CHECK_THAT(moment.dot(fourth_moment(u)), WithinRel(mean, 1e-12));
        }
    }
}

TEST_CASE("fourth moment: changed weights are isotropic and have the same sum", "[math]") {
    for (const bool flat : {false, true}) {
        const Eigen::Matrix3Xd n = some_directions(80, flat);
        const Eigen::VectorXd a = Eigen::VectorXd::LinSpaced(80, 1.0, 2.0), f = factors_of(n, a);
        const Eigen::VectorXd changed = a.cwiseProduct(f);
        const Vec15 wanted = isotropic(a.sum(), flat ? 2 : 3);
        CHECK((moment_of(n, changed) - wanted).norm() <= 1e-5 * wanted.norm());
        CHECK_THAT(changed.sum(), WithinRel(a.sum(), 1e-12));
        CHECK(f.minCoeff() > kLeastFactor);  // so that the least change is the one without a bound, below
        Eigen::MatrixXd m(15, n.cols());
        for (Eigen::Index k = 0; k < n.cols(); ++k) m.col(k) = fourth_moment(n.col(k));
        const Eigen::VectorXd root = a.cwiseSqrt();
        const Eigen::VectorXd least =
            (m * root.asDiagonal()).completeOrthogonalDecomposition().solve(wanted - moment_of(n, a));
        CHECK((root.cwiseProduct(f - Eigen::VectorXd::Ones(80)) - least).norm() <= 1e-4 * least.norm());
    }
}

TEST_CASE("fourth moment: where weights must be positive, no others come nearer to isotropic", "[math]") {
    const Eigen::Matrix3Xd n = some_directions(40, false).cwiseAbs();  // one octant, as at a corner
    const Eigen::VectorXd a = Eigen::VectorXd::Ones(40), f = factors_of(n, a);
    CHECK(f.minCoeff() > 0);
    CHECK_THAT(f.sum(), WithinRel(40.0, 1e-12));
    // Karush-Kuhn-Tucker, before the sum was restored: the miss has no slope along free weights, none down along others
    const Eigen::VectorXd before = kLeastFactor / f.minCoeff() * f;
    const Vec15 miss = moment_of(n, before) - isotropic(40);
    CHECK(miss.norm() > 0.01 * isotropic(40).norm());
    for (int k = 0; k < 40; ++k) {
        const double slope = miss.dot(fourth_moment(n.col(k))) / miss.norm();
        CHECK(slope > -1e-4);
        if (before[k] > 1.001 * kLeastFactor) CHECK(slope < 1e-4);
    }
}

TEST_CASE("fourth moment: few bonds keep their sum and stay positive", "[math]") {
    for (const int count : {1, 2, 5, 10}) {
        const Eigen::Matrix3Xd n = some_directions(count, false);
        const Eigen::VectorXd a = Eigen::VectorXd::Ones(count), f = factors_of(n, a);
        CHECK(f.allFinite());
        CHECK(f.minCoeff() > 0);
        CHECK_THAT(f.sum(), WithinRel(double(count), 1e-9));
    }
}
