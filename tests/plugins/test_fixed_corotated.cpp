// Point values: REFERENCES.md E11 (digits as printed there), E4, B9. tau = P F^T throughout.
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "support/catch.hpp"
#include "support/model.hpp"
#include "support/particles.hpp"

using namespace perimpm;
using Eigen::Matrix3d;

namespace {

constexpr double kNu = 0.3, kMu = 1 / (2 * (1 + kNu)), kLambda = kNu / ((1 + kNu) * (1 - 2 * kNu));  // E = 1 Pa

/// One particle of volume 1 with E = 1 Pa, nu = 0.3.
template <class Real = double>
struct Point {
    ModelPtr<ConstitutiveLaw, Real> law =
        make<ConstitutiveLaw, Real>("fixed_corotated", "youngs_modulus = 1\npoisson_ratio = 0.3", {.density = 1000});
    Particles<Real> particle{*law, {Vec3::Zero()}, 1.0};

    Matrix3d tau(const Matrix3d& F) {
        particle.set_F(0, F);
        particle.evaluate();
        return particle.tau(0);
    }
    double energy(const Matrix3d& F) {
        particle.set_F(0, F);
        return particle.energy();
    }
};

/// (3) of the law's header with U, V, S of Eigen's Jacobi SVD, the smallest value signed.
Matrix3d closed_form(const Matrix3d& F) {
    const Eigen::JacobiSVD<Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Vec3 s = svd.singularValues();
    const double J = F.determinant();
    if (J < 0) s[2] = -s[2];
    const Vec3 tau = (2 * kMu * s.array() * (s.array() - 1) + kLambda * J * (J - 1)).matrix();
    return svd.matrixU() * tau.asDiagonal() * svd.matrixU().transpose();
}

/// The same in long double, of F as rounded to Real. Kirchhoff stress is a smooth function of F F^T for det F > 0, so
/// errors of a few epsilon (|F| + |F|^2) and epsilon |J| (|F|^3 + 1) are all that rounding explains; det F < 0
/// adds the turning of the axes of s_2 and s_3, by (s_2 - s_3)/(s_2 + s_3) of that. Where these agree in size, either may be the
/// negative one: then the principal stresses must match.
template <class Real>
void check_accuracy(const Matrix3d& tau, const Matrix3d& state) {
    using Long3 = Eigen::Matrix<long double, 3, 3>;
    using LongVector = Eigen::Matrix<long double, 3, 1>;
    const Matrix3d F = state.cast<Real>().template cast<double>();
    const Eigen::JacobiSVD<Long3> svd(F.cast<long double>(), Eigen::ComputeFullU | Eigen::ComputeFullV);
    LongVector s = svd.singularValues();
    const long double J = F.cast<long double>().determinant();
    const bool unique = J >= 0 || s[1] - s[2] > 0.01;
    if (J < 0) s[2] = -s[2];
    const long double nu = 0.3, mu = 1 / (2 * (1 + nu)), lambda = nu / ((1 + nu) * (1 - 2 * nu));
    const LongVector principal =
        2 * mu * s.cwiseProduct(s - LongVector::Ones()) + LongVector::Constant(lambda * J * (J - 1));
    const Long3 exact = svd.matrixU() * principal.asDiagonal() * svd.matrixU().transpose();
    const double size = F.norm(), volume = std::abs(static_cast<double>(J));
    const double turned = J < 0 && unique ? static_cast<double>((s[1] - s[2]) / (s[1] + s[2])) : 0;
    const double tolerance = 16 * static_cast<double>(std::numeric_limits<Real>::epsilon()) *
                             ((1 + turned) * (size + size * size) + (volume + 1) * size * size * size);
    CAPTURE(F, tau, exact.cast<double>());
    if (unique) {
        CHECK((tau.cast<long double>() - exact).norm() <= tolerance);
    } else {
        Vec3 expected = principal.cast<double>();
        std::sort(expected.begin(), expected.end());
        CHECK((Eigen::SelfAdjointEigenSolver<Matrix3d>(tau).eigenvalues() - expected).norm() <= tolerance);
    }
}

/// dW/dF F^T by central differences; the error is of order step^2.
Matrix3d derived_tau(Point<>& point, const Matrix3d& F) {
    constexpr double step = 1e-5;
    Matrix3d P;
    for (int c = 0; c < 9; ++c) {
        Matrix3d more = F, less = F;
        more(c / 3, c % 3) += step, less(c / 3, c % 3) -= step;
        P(c / 3, c % 3) = (point.energy(more) - point.energy(less)) / (2 * step);
    }
    return P * F.transpose();
}

}  // namespace

TEST_CASE("fixed_corotated: uniaxial strain is linear in F at any amplitude", "[constitutive]") {
    Point point;
    const double M = kLambda + 2 * kMu;
    const std::pair<double, double> printed[] = {{0.5, -0.6731}, {0.2, -1.0769}, {0.05, -1.2788}};
    for (const auto& [J, stress] : printed) {
        const Matrix3d cauchy =
            point.tau(diagonal(J, 1, 1)) / J;  // sigma_11 = P_11 = M (J - 1), lateral lambda (J - 1)
        CHECK_THAT(cauchy(0, 0), WithinRel(M * (J - 1), 1e-13));
        CHECK_THAT(cauchy(0, 0), WithinAbs(stress, 5e-5));
        CHECK_THAT(cauchy(1, 1), WithinRel(kLambda * (J - 1), 1e-13));
        CHECK_THAT(cauchy(2, 2), WithinRel(kLambda * (J - 1), 1e-13));
    }
}

TEST_CASE("fixed_corotated: hydrostatic compression has a finite crush load", "[constitutive]") {
    Point point;
    struct Row {
        double J, cauchy, nominal, digit;
    };
    for (const Row& row : {Row{0.5, 0.5404, -0.3404, 5e-5},
                           {0.2, 1.3954, -0.4772, 5e-5},
                           {0.05, 4.128, -0.5602, 5e-4},
                           {0.01, 13.57, -0.6300, 5e-3}}) {
        const double s = std::cbrt(row.J);
        const Matrix3d tau = point.tau(diagonal(s, s, s));
        const double nominal =
            2 * kMu * (s - 1) + kLambda * (row.J - 1) * row.J / s;  // P = 2 mu (s - 1) + lambda (J - 1) J / s
        CHECK_THAT(tau(0, 0) / s, WithinRel(nominal, 1e-13));
        CHECK_THAT(tau(0, 0) / s, WithinAbs(row.nominal, 5e-5));
        CHECK_THAT(-tau(1, 1) / row.J, WithinAbs(row.cauchy, row.digit));
        CHECK_THAT(tau(2, 2), WithinRel(tau(0, 0), 1e-13));
    }
}

TEST_CASE("fixed_corotated: uniaxial stress finds the lateral stretch", "[constitutive]") {
    Point point;
    struct Row {
        double stretch, lateral, nominal;
    };
    for (const Row& row : {Row{0.5, 1.14714, -0.64429}, {2.0, 0.77317, 0.83668}}) {
        const double low = lateral_stretch(row.stretch, [&](const Matrix3d& F) { return point.tau(F); });
        CHECK_THAT(low, WithinAbs(row.lateral, 5e-6));
        CHECK_THAT(point.tau(diagonal(row.stretch, low, low))(0, 0) / row.stretch, WithinAbs(row.nominal, 5e-6));
    }
}

TEST_CASE("fixed_corotated: simple shear", "[constitutive]") {
    Point point;
    Matrix3d F = Matrix3d::Identity();
    F(0, 1) = 1;  // gamma = 1, J = 1
    const Matrix3d tau = point.tau(F) / kMu;
    // R is the rotation by -atan(gamma/2): tau/mu = 2 (F F^T - R F^T)
    const double c = 2 / std::sqrt(5.0), s = 1 / std::sqrt(5.0);
    Matrix3d R = Matrix3d::Identity();
    R(0, 0) = R(1, 1) = c, R(0, 1) = s, R(1, 0) = -s;
    CHECK((tau - 2 * (F * F.transpose() - R * F.transpose())).norm() <= 1e-13);
    CHECK_THAT(tau(0, 0), WithinAbs(1.31672, 5e-6));
    CHECK_THAT(tau(0, 1), WithinAbs(1.10557, 5e-6));
    CHECK_THAT(tau(1, 1), WithinAbs(0.21115, 5e-6));
    CHECK(tau.row(2).norm() <= 1e-14);
}

TEST_CASE("fixed_corotated: an inversion costs 4 mu + 2 lambda", "[constitutive]") {
    Point point;
    for (const Matrix3d& F : {diagonal(-1, 1, 1), diagonal(1, -1, 1), diagonal(1, 1, -1)})
        CHECK_THAT(point.energy(F), WithinRel(4 * kMu + 2 * kLambda, 1e-13));
    CHECK_THAT(point.energy(Matrix3d::Zero()), WithinRel(3 * kMu + kLambda / 2, 1e-13));
}

TEST_CASE("fixed_corotated: stress is the energy's derivative", "[constitutive]") {
    Point point;
    std::mt19937 random(5);
    std::vector<Matrix3d> states = {diagonal(1, 1, 1e-8),    diagonal(1e-8, 1, 1),   diagonal(2, 2, 0.5),
                                    diagonal(0.7, 0.7, 0.7), diagonal(-0.5, 1, 1.2), diagonal(1.5, 1.5, -0.3),
                                    diagonal(1, 0.5, 0),     diagonal(1.2, 1.2, 1.2)};
    const std::size_t special = states.size();
    for (std::size_t i = 0; i < special; ++i) {
        const Matrix3d turned = rotation(1.0, {1, 2, 3}) * states[i] * rotation(0.5, {3, -1, 1});
        states.push_back(turned);
    }
    while (states.size() < 100) {
        const Matrix3d F = random_matrix(random);
        const Vec3 s = F.jacobiSvd().singularValues();
        if (F.determinant() > 0 || s[1] - s[2] > 0.01) states.push_back(F);  // W has a kink where s_2 = -s_3
    }
    for (const Matrix3d& F : states) {
        CAPTURE(F);
        CHECK((point.tau(F) - derived_tau(point, F)).norm() <= 1e-6 * std::max(point.tau(F).norm(), kMu));
    }
}

TEMPLATE_TEST_CASE("fixed_corotated: singular, inverted and repeated F give finite, right stress", "[constitutive]",
                   float, double) {
    Point<TestType> point;
    const double tolerance = 50 * static_cast<double>(std::numeric_limits<TestType>::epsilon());
    std::mt19937 random(6);
    std::vector<Matrix3d> states = {diagonal(-1, 1, 1),   Matrix3d::Zero(),  diagonal(1, 1, 1e-8),  diagonal(2, 2, 2),
                                    diagonal(-2, -2, -2), diagonal(1, 0, 0), diagonal(0, 0, 1e-30), Matrix3d::Ones()};
    for (int i = 0; i < 200; ++i) states.push_back(random_matrix(random));
    for (const Matrix3d& F : states) {
        CAPTURE(F);
        const Matrix3d tau = point.tau(F);
        CHECK(tau.allFinite());
        CHECK(std::isfinite(point.energy(F)));
        const Vec3 s = F.jacobiSvd().singularValues();
        const bool unique =
            F.determinant() >= 0 || s[1] - s[2] > 0.01;  // else any choice of the negative direction is right
        if (unique)
            CHECK((tau - closed_form(F)).norm() <= tolerance * std::max(1.0, F.squaredNorm()));
        else
            CHECK_THAT(tau.trace(), WithinAbs(closed_form(F).trace(), tolerance * std::max(1.0, F.squaredNorm())));
    }
}

TEMPLATE_TEST_CASE("fixed_corotated: ordinary, inverted and crushed particles share packs and keep their accuracy",
                   "[constitutive]", float, double) {
    std::mt19937 random(7);
    std::vector<Matrix3d> states;
    for (const double J : {0.5, 0.2, 0.05, 0.01})  // E11: uniaxial and hydrostatic strain
        states.push_back(diagonal(J, 1, 1)), states.push_back(std::cbrt(J) * Matrix3d::Identity());
    states.push_back(diagonal(0.5, 1.14714, 1.14714)), states.push_back(diagonal(2, 0.77317, 0.77317));
    states.push_back(Matrix3d::Identity() + Vec3::UnitX() * Vec3::UnitY().transpose());  // simple shear
    const std::size_t ordinary = states.size();
    for (const Matrix3d& F : {diagonal(-1, 1, 1), diagonal(0, 0, 0), diagonal(1, 1, 1e-8), diagonal(2, 2, 2)})
        states.push_back(F);  // E4
    for (int i = 0; i < 20; ++i) states.push_back(random_matrix(random));
    const std::size_t plain = states.size();
    for (std::size_t i = 0; i < plain; ++i)
        states.push_back(rotation(1.0, {1, 2, 3}) * states[i] * rotation(0.5, {3, -1, 1}));
    const auto law = make<ConstitutiveLaw, TestType>("fixed_corotated", "youngs_modulus = 1\npoisson_ratio = 0.3",
                                                     {.density = 1000});
    Particles<TestType> particles(*law, std::vector<Vec3>(states.size() + 3, Vec3::Zero()), 1.0);

    // Packs of ordinary states alone, mixed at random, and in the order of the list, with a last pack that is not full.
    for (int trial = 0; trial < 50; ++trial) {
        std::vector<std::size_t> chosen;
        for (std::size_t p = 0; p < particles.size(); ++p)
            chosen.push_back(trial == 0   ? p % ordinary
                             : trial == 1 ? p % states.size()
                                          : std::uniform_int_distribution<std::size_t>(0, states.size() - 1)(random));
        for (std::size_t p = 0; p < particles.size(); ++p) particles.set_F(p, states[chosen[p]]);
        particles.evaluate();
        for (std::size_t p = 0; p < particles.size(); ++p)
            check_accuracy<TestType>(particles.tau(p), states[chosen[p]]);
    }
}

TEST_CASE("fixed_corotated: wave speeds bound the tangent's", "[constitutive]") {
    Point point;
    const double rho = 1000;
    const double at_rest = point.law->max_wave_speed(point.particle.block());
    CHECK_THAT(at_rest, WithinRel(std::sqrt((kLambda + 2 * kMu) / rho), 1e-12));
    // Uniaxial strain: P_11 = M (F - 1), so the Eulerian speed is F sqrt(M / rho).
    point.particle.set_F(0, diagonal(1.5, 1, 1));
    CHECK(point.law->max_wave_speed(point.particle.block()) >= 1.5 * at_rest);
}

TEST_CASE("fixed_corotated: Young's modulus may vary from particle to particle", "[constitutive]") {
    const auto law =
        make<ConstitutiveLaw, double>("fixed_corotated", "youngs_modulus = 1\npoisson_ratio = 0.3", {.density = 1000});
    Particles<double> particles(*law, lattice(3, 1.0), 1.0);
    std::vector<double> modulus(particles.size());
    for (std::size_t p = 0; p < particles.size(); ++p) {
        modulus[p] = 1.0 + static_cast<double>(p);
        particles.set_F(p, diagonal(0.5, 1, 1));
    }
    Block<double> b = particles.block();
    b.param[0] = modulus.data();
    law->evaluate(b, 1e-4);
    for (std::size_t p = 0; p < particles.size(); ++p)
        CHECK_THAT(particles.tau(p)(0, 0), WithinRel(0.5 * modulus[p] * (kLambda + 2 * kMu) * (0.5 - 1), 1e-13));
}
