// Numbered values: REFERENCES.md C1 and C6 (E = 200 GPa, nu = 0.3, sigma_y = 250 MPa, H = 2 GPa), digits as printed there.
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "support/acoustic.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/model.hpp"
#include "support/particles.hpp"

using namespace perimpm;
using Eigen::Matrix3d;

namespace {

constexpr double kE = 200e9, kNu = 0.3, kYield = 250e6, kH = 2e9, kDensity = 7800;
constexpr double kMu = kE / (2 * (1 + kNu)), kBulk = kE / (3 * (1 - 2 * kNu));
constexpr double kMPa = 1e6;

std::string table(double youngs_modulus, double yield_stress, double hardening) {
    return "youngs_modulus = " + std::to_string(youngs_modulus) +
           "\npoisson_ratio = 0.3\nyield_stress = " + std::to_string(yield_stress) +
           "\nhardening = " + std::to_string(hardening);
}

Matrix3d deviator(const Matrix3d& m) { return m - m.trace() / 3 * Matrix3d::Identity(); }
double von_mises(const Matrix3d& tau) { return std::sqrt(1.5) * deviator(tau).norm(); }

/// One particle of volume 1 that keeps its state from step to step.
template <class Real = double>
struct Point {
    ModelPtr<ConstitutiveLaw, Real> law;
    Particles<Real> particle;

    explicit Point(double hardening = kH, double yield_stress = kYield, double youngs_modulus = kE)
        : law{make<ConstitutiveLaw, Real>("von_mises", table(youngs_modulus, yield_stress, hardening),
                                          {.density = kDensity})},
          particle{*law, {Vec3(1, 2, 3)}, 1.0} {}

    Matrix3d F() {
        Matrix3d F;
        for (std::size_t c = 0; c < 9; ++c)
            F(static_cast<int>(c / 3), static_cast<int>(c % 3)) = static_cast<double>(particle.block().F[c][0]);
        return F;
    }
    double plastic_strain() { return static_cast<double>(particle.block().particle_state[0][0][0]); }
    void set(const Matrix3d& F, double plastic_strain) {
        particle.set_F(0, F);
        particle.block().particle_state[0][0][0] = static_cast<Real>(plastic_strain);
    }
    /// A step in which the surroundings deform by `by`.
    Matrix3d step(const Matrix3d& by) {
        particle.set_F(0, by * F());
        particle.evaluate();
        return particle.tau(0);
    }
    /// What `step` would give, without taking it.
    Matrix3d probe(const Matrix3d& by) {
        const Matrix3d before = F();
        const double alpha = plastic_strain();
        const Matrix3d tau = step(by);
        set(before, alpha);
        return tau;
    }
    /// A step of axial logarithmic strain under uniaxial stress; gives that stress.
    double pull(double strain) {
        double low = -2 * std::abs(strain), high = -low;  // lateral logarithmic strain; its stress grows with it
        const auto by = [&](double lateral) {
            return diagonal(std::exp(strain), std::exp(lateral), std::exp(lateral));
        };
        for (int i = 0; i < 80; ++i) {
            const double middle = 0.5 * (low + high);
            (probe(by(middle))(1, 1) < 0 ? low : high) = middle;
        }
        return step(by(low))(0, 0);
    }
};

/// 2 mu dev(ln V) + K tr(ln V) I with V^2 = F F^T.
Matrix3d hencky(const Matrix3d& F) {
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(F * F.transpose());
    const Vec3 strain = 0.5 * eigen.eigenvalues().array().log();
    const Vec3 dev = strain - Vec3::Constant(strain.sum() / 3);
    const Vec3 tau = 2 * kMu * dev + Vec3::Constant(kBulk * strain.sum());
    return eigen.eigenvectors() * tau.asDiagonal() * eigen.eigenvectors().transpose();
}

Matrix3d shear(double gamma) {
    Matrix3d F = Matrix3d::Identity();
    F(0, 1) = gamma;
    return F;
}

Matrix3d random_upright(std::mt19937& random, double size) {
    Matrix3d F = Matrix3d::Identity() + size * random_matrix(random);
    while (F.determinant() < 0.01) F = Matrix3d::Identity() + size * random_matrix(random);
    return F;
}

}  // namespace

TEST_CASE("von_mises: uniaxial stress follows the bilinear curve", "[constitutive]") {
    const double tangent = kE * kH / (kE + kH);
    for (const int steps : {1, 7, 100}) {
        Point point;
        double stress = 0;
        for (int i = 1; i <= steps; ++i) {
            stress = point.pull(0.01 / steps);
            const double strain = 0.01 * i / steps;
            const double expected = strain < kYield / kE ? kE * strain : kYield + tangent * (strain - kYield / kE);
            CHECK_THAT(stress, WithinRel(expected, 1e-10));
        }
        CHECK_THAT(stress / kMPa, WithinAbs(267.326733, 5e-7));
        CHECK_THAT(point.plastic_strain(), WithinAbs(8.66336634e-3, 5e-12));
    }
}

TEST_CASE("von_mises: uniaxial strain yields at the elastic limit and then keeps the stress difference",
          "[constitutive]") {
    const double limit = kYield / (2 * kMu);
    CHECK_THAT(limit, WithinRel(1.625e-3, 1e-12));
    Point before(0);
    const Matrix3d at = before.step(diagonal(std::exp(limit * (1 - 1e-12)), 1, 1));
    CHECK_THAT(at(0, 0) / kMPa, WithinRel(437.5, 1e-10));
    CHECK(before.plastic_strain() == 0);
    for (const int steps : {1, 3, 40}) {
        Point point(0);
        Matrix3d tau;
        for (int i = 0; i < steps; ++i) tau = point.step(diagonal(std::exp(0.004 / steps), 1, 1));
        CHECK_THAT(tau(0, 0), WithinRel(kBulk * 0.004 + 2 * kYield / 3, 1e-11));
        CHECK_THAT(tau(0, 0) / kMPa, WithinAbs(833.333, 5e-4));
        CHECK_THAT(tau(1, 1) / kMPa, WithinAbs(583.333, 5e-4));
        CHECK_THAT(tau(0, 0) - tau(2, 2), WithinRel(kYield, 1e-11));
    }
}

TEST_CASE("von_mises: cyclic strain", "[constitutive]") {
    Point hardening, perfect(0);
    const double peaks[] = {267.327, -301.637, 335.268, -368.233, 400.545};  // MPa
    double strain = 0.01, flowed = 0;
    for (std::size_t i = 0; i < 5; ++i, strain = i % 2 ? -0.02 : 0.02) {
        double stress = 0;
        for (int k = 0; k < 10; ++k) stress = hardening.pull(strain / 10);
        CHECK_THAT(stress / kMPa, WithinAbs(peaks[i], 5e-4));
        CHECK_THAT(perfect.pull(strain), WithinRel(i % 2 ? -kYield : kYield, 1e-10));
        if (i == 2) flowed = perfect.plastic_strain();
    }
    // a loop's area sigma_y d(alpha) is 4 sigma_y (0.01 - sigma_y/E)
    CHECK_THAT(kYield * (perfect.plastic_strain() - flowed), WithinRel(8.75e6, 1e-9));
}

TEMPLATE_TEST_CASE("von_mises: the return lands on the yield surface from anywhere", "[constitutive]", float, double) {
    const double rounding = static_cast<double>(std::numeric_limits<TestType>::epsilon());
    std::mt19937 random(4);
    for (const double hardening : {0.0, kH, kE}) {
        for (const double yield_stress : {kYield, 0.1 * kE}) {
            Point<TestType> point(hardening, yield_stress);
            for (int i = 0; i < 50; ++i) {
                const Matrix3d F = random_upright(random, 0.8).template cast<TestType>().template cast<double>();
                if (von_mises(hencky(F)) <= (yield_stress + 0.02 * hardening) * 1.001) continue;
                point.set(F, 0.02);
                point.particle.evaluate();
                const Matrix3d tau = point.particle.tau(0), returned = point.F();
                const double alpha = point.plastic_strain();
                CAPTURE(F, tau, alpha, hardening, yield_stress);
                const double size = hencky(F).norm();
                const double tolerance = 64 * rounding * std::max(1.0, F.norm() * F.inverse().norm());
                CHECK(std::abs(von_mises(tau) - yield_stress - hardening * alpha) <= tolerance * size);
                CHECK(alpha > 0.02);
                CHECK_THAT(tau.trace(), WithinAbs(3 * kBulk * std::log(F.determinant()), tolerance * size));
                CHECK_THAT(returned.determinant(), WithinRel(F.determinant(), tolerance));
                CHECK((hencky(returned) - tau).norm() <= tolerance * size);  // F and tau agree
                point.particle.evaluate();                                   // nothing left to do
                CHECK_THAT(point.plastic_strain(), WithinAbs(alpha, tolerance));
                CHECK((point.particle.tau(0) - tau).norm() <= tolerance * size);
            }
        }
    }
}

TEMPLATE_TEST_CASE("von_mises: what does not reach the yield stress is Hencky elasticity, to the bit", "[constitutive]",
                   float, double) {
    constexpr std::size_t count = 21;
    const auto build = [&](double yield_stress) {
        return make<ConstitutiveLaw, TestType>("von_mises", table(kE, yield_stress, kH), {.density = kDensity});
    };
    const auto law = build(kYield), elastic = build(1e6 * kE);
    Particles<TestType> particles(*law, std::vector<Vec3>(count, Vec3::Zero()), 1.0);
    Particles<TestType> reference(*elastic, std::vector<Vec3>(count, Vec3::Zero()), 1.0);
    std::mt19937 random(8);
    std::vector<Matrix3d> states;
    for (std::size_t p = 0; p < count; ++p) {
        const bool flows = p % 3 == 0;  // packs of both kinds
        states.push_back(rotation(0.7, {1, 2, 3}) * random_upright(random, flows ? 0.1 : 1e-4));
        REQUIRE((von_mises(hencky(states[p])) > kYield) == flows);
        particles.set_F(p, states[p]), reference.set_F(p, states[p]);
    }
    particles.evaluate(), reference.evaluate();
    const Block<TestType> at = particles.block(), was = reference.block();
    const double tolerance = 100 * static_cast<double>(std::numeric_limits<TestType>::epsilon()) * kE;
    for (std::size_t p = 0; p < count; ++p) {
        const bool flows = p % 3 == 0;
        CHECK((at.particle_state[0][0][p] > 0) == flows);
        CHECK((particles.tau(p) == reference.tau(p)) == !flows);
        CHECK((reference.tau(p) - hencky(states[p])).norm() <= tolerance);
        bool same = true;
        for (std::size_t c = 0; c < 9; ++c) same &= at.F[c][p] == was.F[c][p];
        CHECK(same == !flows);
    }
}

TEST_CASE("von_mises: simple shear saturates at sigma_y / sqrt 3 and keeps the volume", "[constitutive]") {
    Point point(0);
    double gamma = 0;
    for (int i = 0; i < 100000; ++i) {  // to gamma = 5
        const Matrix3d tau = point.step(shear(5e-5));
        gamma += 5e-5;
        if (gamma < 0.05 || i % 100) continue;
        CHECK_THAT(tau(0, 1) / kMPa, WithinAbs(144.34, 5e-3));
        CHECK_THAT(von_mises(tau), WithinRel(kYield, 1e-12));
    }
    CHECK_THAT(point.F().determinant(), WithinAbs(1, 1e-10));
    CHECK_THAT(point.plastic_strain(), WithinRel((5 - kYield / std::sqrt(3.0) / kMu) / std::sqrt(3.0), 1e-4));
}

TEST_CASE("von_mises: rigid turns of a stressed particle make no plastic strain", "[constitutive]") {
    for (const double strain : {0.001, 0.01}) {  // below the yield stress and after flowing
        Point point;
        point.pull(strain);
        const Matrix3d start = point.particle.tau(0);
        const double alpha = point.plastic_strain();
        constexpr int steps = 3600;
        const Matrix3d by = rotation(2 * EIGEN_PI / steps, {1, -2, 0.5});
        for (int i = 1; i <= steps; ++i) {
            const Matrix3d tau = point.step(by);
            const Matrix3d R = rotation(2 * EIGEN_PI * i / steps, {1, -2, 0.5});
            if (i % 100 == 0) CHECK((tau - R * start * R.transpose()).norm() <= 1e-9 * start.norm());
        }
        CHECK_THAT(point.plastic_strain(), WithinAbs(alpha, 1e-12));
    }
}

TEST_CASE("von_mises: turning the frame turns the answer, during flow as well", "[constitutive]") {
    std::mt19937 random(9);
    const Matrix3d R = rotation(1.3, {2, -1, 3}), Q = rotation(0.4, {0, 1, 1});
    for (int i = 0; i < 30; ++i) {
        const Matrix3d F = random_upright(random, 0.5);
        Point straight, turned;
        straight.step(F), turned.step(R * F * Q);
        const double scale = kE;
        CHECK((turned.particle.tau(0) - R * straight.particle.tau(0) * R.transpose()).norm() <= 1e-12 * scale);
        CHECK((turned.F() - R * straight.F() * Q).norm() <= 1e-12);
        CHECK_THAT(turned.plastic_strain(), WithinAbs(straight.plastic_strain(), 1e-12));
    }
}

TEST_CASE("von_mises: work is stored or becomes heat sigma_y d(alpha)", "[constitutive]") {
    // The increment of stored energy and heat is a potential of the step's stress (Ortiz & Stainier 1999).
    std::mt19937 random(10);
    for (int i = 0; i < 30; ++i) {
        Point point(kE / 10);
        const Matrix3d F = random_upright(random, 0.3);
        const auto potential = [&](const Matrix3d& at) {
            point.set(at, 0.05);
            const double before_return = point.particle.energy();
            point.particle.evaluate();
            CHECK_THAT(point.particle.energy(), WithinRel(before_return, 1e-12));
            return before_return + kYield * point.plastic_strain();
        };
        constexpr double step = 1e-6;
        Matrix3d P;
        for (int c = 0; c < 9; ++c) {
            Matrix3d more = F, less = F;
            more(c / 3, c % 3) += step, less(c / 3, c % 3) -= step;
            P(c / 3, c % 3) = (potential(more) - potential(less)) / (2 * step);
        }
        point.set(F, 0.05);
        point.particle.evaluate();
        CHECK((P * F.transpose() - point.particle.tau(0)).norm() <= 1e-6 * kE);
    }
    // Work along a path: sum tau : d, by the trapezoidal rule.
    Point point;
    double work = 0;
    const double stored = point.particle.energy();
    const Matrix3d rate = deviator(random_matrix(random)) + 0.01 * Matrix3d::Identity();
    Matrix3d before = Matrix3d::Zero();
    for (int i = 0; i < 4000; ++i) {
        const Matrix3d after = point.step(Matrix3d::Identity() + 1e-5 * rate);
        work += 0.5e-5 * (before + after).cwiseProduct(rate).sum();
        before = after;
    }
    CHECK(point.plastic_strain() > 0.01);
    CHECK_THAT(point.particle.energy() - stored + kYield * point.plastic_strain(), WithinRel(work, 1e-4));
}

TEST_CASE("von_mises: wave speeds bound the elastic tangent's", "[constitutive]") {
    Point point(0, 100 * kE);
    const double at_rest = std::sqrt((kBulk + 4 * kMu / 3) / kDensity);
    CHECK_THAT(point.law->max_wave_speed(point.particle.block()), WithinRel(at_rest, 1e-14));
    std::mt19937 random(6);
    for (int i = 0; i < 300; ++i) {
        const Matrix3d F = random_upright(random, 0.8);
        const Vec3 N = random_matrix(random).col(0).normalized();
        point.set(F, 0);
        const double bound = point.law->max_wave_speed(point.particle.block());
        const auto tau = [&](const Matrix3d& at) {
            point.set(at, 0);
            point.particle.evaluate();
            return point.particle.tau(0);
        };
        CAPTURE(F, N);
        CHECK(bound >= fastest_wave(tau, F, N, kDensity) * (1 - 1e-5));
    }
}

TEMPLATE_TEST_CASE("von_mises: a crushed or inverted particle is an error that says where", "[constitutive]", float,
                   double) {
    for (const Matrix3d& F : {diagonal(-1, 1, 1), diagonal(1, 0, 1)}) {
        Point<TestType> point;
        point.set(F, 0);
        for (const std::string& message :
             {message_of<SimulationError>([&] { point.particle.evaluate(); }),
              message_of<SimulationError>([&] { point.particle.energy(); }),
              message_of<SimulationError>([&] { point.law->max_wave_speed(point.particle.block()); })})
            CHECK(contains(message, "von_mises: the particle at (1, 2, 3) m is"));
    }
}

TEST_CASE("von_mises: Young's modulus and yield stress may vary from particle to particle", "[constitutive]") {
    const auto law = make<ConstitutiveLaw, double>("von_mises", table(kE, kYield, 0), {.density = kDensity});
    Particles<double> particles(*law, lattice(3, 1.0), 1.0);
    std::vector<double> modulus, yield_stress;
    for (std::size_t p = 0; p < particles.size(); ++p) {
        modulus.push_back(kE * (1 + static_cast<double>(p)));
        yield_stress.push_back(kYield * (1 + static_cast<double>(p % 5)));
        particles.set_F(p, diagonal(1.1, 0.95, 1));
    }
    Block<double> b = particles.block();
    b.param[0] = modulus.data(), b.param[1] = yield_stress.data();
    law->evaluate(b, 1e-4);
    for (std::size_t p = 0; p < particles.size(); ++p) {
        CHECK_THAT(von_mises(particles.tau(p)), WithinRel(yield_stress[p], 1e-11));
        CHECK_THAT(particles.tau(p).trace(), WithinRel(3 * kBulk * modulus[p] / kE * std::log(1.1 * 0.95), 1e-11));
    }
}
