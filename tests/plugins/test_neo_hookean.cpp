// Point values: REFERENCES.md E11 (digits as printed there; at stretch 2 its last digit of P_11 is one too large). P = mu (F - F^-T) + lambda ln J F^-T, tau = P F^T.
#include "support/acoustic.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/model.hpp"
#include "support/particles.hpp"

using namespace perimpm;
using Eigen::Matrix3d;

namespace {

constexpr double kNu = 0.3, kMu = 1 / (2 * (1 + kNu)), kLambda = kNu / ((1 + kNu) * (1 - 2 * kNu));  // E = 1 Pa
constexpr double kDensity = 1000;

/// One particle of volume 1 at (1, 2, 3) with E = 1 Pa, nu = 0.3.
template <class Real = double>
struct Point {
    ModelPtr<ConstitutiveLaw, Real> law =
        make<ConstitutiveLaw, Real>("neo_hookean", "youngs_modulus = 1\npoisson_ratio = 0.3", {.density = kDensity});
    Particles<Real> particle{*law, {Vec3(1, 2, 3)}, 1.0};

    Matrix3d tau(const Matrix3d& F) {
        particle.set_F(0, F);
        particle.evaluate();
        return particle.tau(0);
    }
    double energy(const Matrix3d& F) {
        particle.set_F(0, F);
        return particle.energy();
    }
    double wave_speed(const Matrix3d& F) {
        particle.set_F(0, F);
        return law->max_wave_speed(particle.block());
    }
};

Matrix3d closed_form(const Matrix3d& F) {
    return kMu * (F * F.transpose() - Matrix3d::Identity()) +
           kLambda * std::log(F.determinant()) * Matrix3d::Identity();
}

Matrix3d random_upright(std::mt19937& random) {
    Matrix3d F = random_matrix(random);
    while (F.determinant() < 0.01) F = random_matrix(random);
    return F;
}

}  // namespace

TEST_CASE("neo_hookean: uniaxial stress finds the lateral stretch", "[constitutive]") {
    Point point;
    struct Row {
        double stretch, lateral, nominal;
    };
    for (const Row& row : {Row{0.5, 1.21077, -0.93535}, {2.0, 0.79808, 0.64674}}) {
        const double low = lateral_stretch(row.stretch, [&](const Matrix3d& F) { return point.tau(F); });
        CHECK_THAT(low, WithinAbs(row.lateral, 5e-6));
        CHECK_THAT(point.tau(diagonal(row.stretch, low, low))(0, 0) / row.stretch, WithinAbs(row.nominal, 5e-6));
    }
}

TEST_CASE("neo_hookean: crushing takes energy and load without bound", "[constitutive]") {
    Point point;
    double before = 0;
    for (const double J : {0.5, 1e-2, 1e-6, 1e-12}) {
        const double s = std::cbrt(J), log_J = std::log(J);
        const Matrix3d F = diagonal(s, s, s);
        const double nominal = (kMu * (s * s - 1) + kLambda * log_J) / s;
        CHECK_THAT(point.tau(F)(1, 1) / s, WithinRel(nominal, 1e-13));
        CHECK_THAT(point.energy(F),
                   WithinRel(1.5 * kMu * (s * s - 1) - kMu * log_J + kLambda / 2 * log_J * log_J, 1e-13));
        CHECK(nominal < 2 * before);
        before = nominal;
    }
}

TEMPLATE_TEST_CASE("neo_hookean: stress of ordinary and nearly flat states in full and partial packs", "[constitutive]",
                   float, double) {
    const auto law = make<ConstitutiveLaw, TestType>("neo_hookean", "youngs_modulus = 1\npoisson_ratio = 0.3",
                                                     {.density = kDensity});
    Particles<TestType> particles(*law, std::vector<Vec3>(37, Vec3::Zero()), 1.0);
    std::mt19937 random(3);
    std::vector<Matrix3d> states = {diagonal(1, 1, 1e-6), diagonal(3, 3, 0.1)};
    while (states.size() < particles.size()) states.push_back(random_upright(random));
    for (std::size_t p = 0; p < particles.size(); ++p) particles.set_F(p, states[p]);
    particles.evaluate();
    for (std::size_t p = 0; p < particles.size(); ++p) {
        const Matrix3d F = states[p].cast<TestType>().template cast<double>();
        const double size = F.norm(), J = F.determinant();
        // ln J is as uncertain as det F, whose terms are of size |F|^3
        const double tolerance = 8 * static_cast<double>(std::numeric_limits<TestType>::epsilon()) *
                                 (1 + size * size + size * size * size / J);
        CAPTURE(F);
        CHECK((particles.tau(p) - closed_form(F)).norm() <= tolerance);
    }
}

TEST_CASE("neo_hookean: stress is the energy's derivative", "[constitutive]") {
    Point point;
    std::mt19937 random(5);
    for (int i = 0; i < 100; ++i) {
        const Matrix3d F = random_upright(random);
        const double step = 1e-5 * F.determinant();
        Matrix3d P;
        for (int c = 0; c < 9; ++c) {
            Matrix3d more = F, less = F;
            more(c / 3, c % 3) += step, less(c / 3, c % 3) -= step;
            P(c / 3, c % 3) = (point.energy(more) - point.energy(less)) / (2 * step);
        }
        CAPTURE(F);
        CHECK((point.tau(F) - P * F.transpose()).norm() <= 1e-6 * std::max(point.tau(F).norm(), kMu));
    }
}

TEMPLATE_TEST_CASE("neo_hookean: small strains keep the digits of their energy", "[constitutive]", float, double) {
    Point<TestType> point;
    const double e = 1.0 / 4096;  // so that 1 + e and 1 - e have no rounding
    Matrix3d H;
    H << e, 2 * e, 0, 0, -e, e, 0, 0, 3 * e;
    const Matrix3d strain = (H + H.transpose()) / 2;
    const double linear = kMu * strain.squaredNorm() + kLambda / 2 * std::pow(strain.trace(), 2);
    CHECK_THAT(point.energy(Matrix3d::Identity() + H), WithinRel(linear, 10 * e));  // the next order
}

TEST_CASE("neo_hookean: wave speeds bound the tangent's", "[constitutive]") {
    Point point;
    CHECK_THAT(point.wave_speed(Matrix3d::Identity()), WithinRel(std::sqrt((kLambda + 2 * kMu) / kDensity), 1e-14));
    for (const double s : {0.1, 1.5, 4.0})  // uniaxial strain: rho c^2 = s^2 dP/ds
        CHECK_THAT(
            point.wave_speed(diagonal(s, 1, 1)),
            WithinRel(std::sqrt((kMu * std::max(s * s, 1.0) + kMu + kLambda * (1 - std::log(s))) / kDensity), 1e-13));
    std::mt19937 random(6);
    for (int i = 0; i < 300; ++i) {
        const Matrix3d F = random_upright(random) * (i % 3 ? 1.0 : 5.0);
        const Vec3 N = random_matrix(random).col(0).normalized();
        CAPTURE(F, N);
        const double bound = point.wave_speed(F);
        const double fastest = fastest_wave([&](const Matrix3d& at) { return point.tau(at); }, F, N, kDensity);
        CHECK(bound >= fastest * (1 - 1e-6));
    }
}

TEMPLATE_TEST_CASE("neo_hookean: a crushed or inverted particle is an error that says where", "[constitutive]", float,
                   double) {
    for (const Matrix3d& F : {diagonal(-1, 1, 1), diagonal(1, 0, 1), Matrix3d(Matrix3d::Constant(std::nan("")))}) {
        Point<TestType> point;
        const auto refusal = [&](auto action) { return message_of<SimulationError>([&] { action(); }); };
        for (const std::string& message : {refusal([&] { point.tau(F); }), refusal([&] { point.energy(F); }),
                                           refusal([&] { point.wave_speed(F); })}) {
            CHECK(contains(message, "neo_hookean: the particle at (1, 2, 3) m is"));
            CHECK(contains(message, "use 'fixed_corotated'"));
        }
        CHECK(contains(refusal([&] { point.tau(F); }), F(0, 0) < 0    ? "turned inside out: det F = -1"
                                                       : F(1, 1) == 0 ? "crushed to nothing: det F = 0"
                                                                      : "det F = nan"));
    }
}

TEST_CASE("neo_hookean: Young's modulus may vary from particle to particle", "[constitutive]") {
    const auto law =
        make<ConstitutiveLaw, double>("neo_hookean", "youngs_modulus = 1\npoisson_ratio = 0.3", {.density = kDensity});
    Particles<double> particles(*law, lattice(3, 1.0), 1.0);
    std::vector<double> modulus(particles.size());
    const Matrix3d F = diagonal(0.5, 1, 1);
    for (std::size_t p = 0; p < particles.size(); ++p) modulus[p] = 1.0 + static_cast<double>(p), particles.set_F(p, F);
    Block<double> b = particles.block();
    b.param[0] = modulus.data();
    law->evaluate(b, 1e-4);
    for (std::size_t p = 0; p < particles.size(); ++p)
        CHECK_THAT(particles.tau(p)(0, 0), WithinRel(modulus[p] * closed_form(F)(0, 0), 1e-13));
    const double each = Point().energy(F);
    CHECK_THAT(law->energy(b), WithinRel(each * 27 * 28 / 2, 1e-13));
}
