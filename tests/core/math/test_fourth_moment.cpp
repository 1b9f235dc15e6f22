// Moments of weights: closed forms of the isotropic tensor of rank four.
#include <random>

#include "perimpm/math/fourth_moment.hpp"
#include "support/catch.hpp"

using perimpm::fourth_moment, perimpm::isotropic_change, perimpm::isotropic_fourth_moment;
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
        const Eigen::Matrix3Xd n = some_directions(40, flat);
        const Eigen::VectorXd a = Eigen::VectorXd::LinSpaced(40, 1.0, 2.0);
        const Eigen::VectorXd changed = (a.array() * (1 + isotropic_change(n, a).array())).matrix();
        Vec15 moment = Vec15::Zero();
        for (int k = 0; k < 40; ++k) moment += changed[k] * fourth_moment(n.col(k));
        const Vec15 wanted = a.sum() * isotropic_fourth_moment(Eigen::Matrix3d::Identity().leftCols(flat ? 2 : 3));
        CHECK((moment - wanted).norm() <= 1e-12 * wanted.norm());
        CHECK_THAT(changed.sum(), WithinRel(a.sum(), 1e-12));
    }
}

TEST_CASE("fourth moment: few bonds keep their sum and stay finite", "[math]") {
    for (const int count : {1, 2, 5, 10}) {
        const Eigen::Matrix3Xd n = some_directions(count, false);
        const Eigen::VectorXd a = Eigen::VectorXd::Ones(count), change = isotropic_change(n, a);
        CHECK(change.allFinite());
        CHECK(std::abs(change.sum()) <= 1e-9 * count);
    }
}
