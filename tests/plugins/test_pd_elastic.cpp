// REFERENCES.md B2, A7 (rigid rotation), E13 (degenerate families); METHOD.md section 3.
#include "support/catch.hpp"
#include "support/lattice_stiffness.hpp"
#include "support/message.hpp"
#include "support/model.hpp"
#include "support/shaken.hpp"

using namespace perimpm;
using Eigen::Matrix3d;

namespace {

constexpr double kSpacing = 0.01, kVolume = kSpacing * kSpacing * kSpacing;
constexpr ModelContext kContext{.density = 1000, .particle_spacing = kSpacing, .grid_spacing = 2 * kSpacing};

template <class Real = double>
ModelPtr<ConstitutiveLaw, Real> pd_elastic(const std::string& table) {
    return make<ConstitutiveLaw, Real>("pd_elastic", table, kContext);
}

std::string paper(double mu, double lambda, const std::string& more = "") {
    return "calibration = \"paper\"\nmu = " + std::to_string(mu) + "\nlambda = " + std::to_string(lambda) + "\n" + more;
}

/// A block whose inner particles see no surface at horizon 3.015.
Particles<double> cube(const ConstitutiveLaw<double>& law, int count = 9) {
    return {law, lattice(count, kSpacing), kVolume};
}

std::string refused_key(const std::string& table) {
    try {
        pd_elastic(table);
    } catch (const InvalidParameter& e) {
        return e.key() + ": " + e.what();
    }
    return "";
}

Matrix3d some_stretch() {
    Matrix3d F;
    F << 1.1, 0.01, 0.0, 0.0, 1.2, 0.02, 0.03, 0.0, 1.3;
    return F;
}

}  // namespace

TEST_CASE("pd_elastic: small-strain stiffness is the lattice sum over the own family", "[constitutive]") {
    struct Case {
        double mu, lambda, horizon;
        const char* influence;
    };
    for (const Case& c : {Case{2e5, 1e6, 3.015, "linear"},
                          {1e6, 1e6, 2.01, "linear"},
                          {3e5, 0.0, 3.015, "constant"},
                          {0.0, 5e5, 2.01, "constant"}}) {
        CAPTURE(c.mu, c.lambda, c.horizon, c.influence);
        const auto law = pd_elastic(paper(
            c.mu, c.lambda,
            "horizon = " + std::to_string(c.horizon) + "\nsurface = \"family\"\ninfluence = \"" + c.influence + '"'));
        auto particles = cube(*law);
        const std::size_t p = middle(9);
        // C = (2 mu + lambda) sum_q w V_q nnnn with w V = 5 w^ V / sum_q w^ V
        const double delta = c.horizon * kSpacing;
        const auto influence = [&](double X) { return std::string(c.influence) == "linear" ? 1 - X / delta : 1.0; };
        double sum = 0;
        for (std::uint32_t s = particles.bonds().row[p]; s < particles.bonds().row[p + 1]; ++s)
            sum += influence((particles.reference()[particles.bonds().neighbour[s]] - particles.reference()[p]).norm());
        const Stiffness expected =
            lattice_stiffness(particles, p, [&](double X) { return (2 * c.mu + c.lambda) * 5 * influence(X) / sum; });
        const Stiffness measured = measure_stiffness(particles, p, kVolume);
        CHECK((measured - expected).norm() <= 1e-6 * expected.norm());
        const IsotropicAverage average = isotropic_average(measured);
        CHECK_THAT(average.poisson_ratio(), WithinAbs(0.25, 1e-6));
        CHECK_THAT(average.youngs_modulus(), WithinRel(5.0 / 6 * (2 * c.mu + c.lambda), 1e-6));
        CHECK_THAT(law->needs().moduli.youngs_modulus, WithinRel(5.0 / 6 * (2 * c.mu + c.lambda), 1e-12));
        CHECK(law->needs().moduli.poisson_ratio == 0.25);
    }
}

TEST_CASE("pd_elastic: calibration by modulus has the modulus whatever the bending ratio, at surfaces as well",
          "[constitutive]") {
    for (const double ratio : {0.0, 0.3, 1.0, 10.0}) {
        const auto law = pd_elastic("youngs_modulus = 2.5e5\nbending_ratio = " + std::to_string(ratio));
        CHECK_THAT(law->needs().moduli.youngs_modulus, WithinRel(2.5e5, 1e-12));
        auto particles = cube(*law, 5);
        CHECK_THAT(isotropic_average(measure_stiffness(particles, middle(5), kVolume)).youngs_modulus(),
                   WithinRel(2.5e5, 1e-6));
        // Surface families are lopsided, their isotropic average is not: sum w V = 5 by normalisation.
        CHECK_THAT(isotropic_average(measure_stiffness(particles, 0, kVolume)).youngs_modulus(),
                   WithinRel(2.5e5, 1e-6));
        CHECK_THAT(isotropic_average(measure_stiffness(particles, 0, kVolume)).poisson_ratio(), WithinAbs(0.25, 1e-6));
    }
}

TEST_CASE("pd_elastic: surface = \"none\" leaves incomplete families softer by their missing weight",
          "[constitutive]") {
    const auto law = pd_elastic("youngs_modulus = 2.5e5\nsurface = \"none\"\nhorizon = 2.01\ninfluence = \"constant\"");
    auto particles = cube(*law, 7);
    const auto& row = particles.bonds().row;
    const double full = 32, corner = row[1] - row[0];
    CHECK_THAT(isotropic_average(measure_stiffness(particles, middle(7), kVolume)).youngs_modulus(),
               WithinRel(2.5e5, 1e-6));
    CHECK_THAT(isotropic_average(measure_stiffness(particles, 0, kVolume)).youngs_modulus(),
               WithinRel(2.5e5 * corner / full, 1e-6));
}

TEST_CASE("pd_elastic: rigid motion makes no force", "[constitutive]") {
    const double E = 1e6, K = E / 1.5;
    for (const char* ratio : {"0.0", "1.0", "5.0"}) {
        const auto law = pd_elastic(std::string("youngs_modulus = 1e6\nhorizon = 3.015\nbending_ratio = ") + ratio);
        auto particles = cube(*law, 7);
        for (const double angle : {0.3, 1.7, 3.1}) {
            const Matrix3d R = rotation(angle, {1, -2, 3});
            particles.move([&](const Vec3& X) -> Vec3 { return R * X + Vec3(0.01, 0.0, -0.02); });
            particles.evaluate();
            CHECK(particles.largest_force() <= 1e-12 * K * kSpacing * kSpacing);
        }
    }
}

TEST_CASE("pd_elastic: under homogeneous strain averaged bonds are the bonds", "[constitutive]") {
    // Y- = F X = Y, so mu and lambda act as one spring of 2 mu + lambda: the bending ratio cannot matter, even at
    // surfaces.
    // The variational form spreads the same stress over other bonds: equal energy, and equal forces in the interior.
    const auto springs = pd_elastic("youngs_modulus = 1e6\nbending_ratio = 0.0"),
               averaged = pd_elastic("youngs_modulus = 1e6\nbending_ratio = 4.0\nformulation = \"paper\""),
               variational = pd_elastic("youngs_modulus = 1e6\nbending_ratio = 4.0");
    auto c = cube(*variational, 7);
    c.deform(some_stretch());
    c.evaluate();
    auto a = cube(*springs, 7), b = cube(*averaged, 7);
    a.deform(some_stretch()), b.deform(some_stretch());
    a.evaluate(), b.evaluate();
    REQUIRE(a.largest_force() > 0);
    for (std::size_t p = 0; p < a.size(); ++p) CHECK((a.force(p) - b.force(p)).norm() <= 1e-12 * a.largest_force());
    CHECK_THAT(a.energy(), WithinRel(b.energy(), 1e-12));
    CHECK_THAT(c.energy(), WithinRel(b.energy(), 1e-12));
}

TEST_CASE("pd_elastic: the variational form is minus the energy's gradient and conserves momenta", "[constitutive]") {
    for (const char* more : {"", "surface = \"family\"\n", "surface = \"ghost\"\n", "influence = \"constant\"\n",
                             "influence = \"gaussian\"\nsurface = \"none\"\n"}) {
        CAPTURE(more);
        const auto law = pd_elastic(std::string("youngs_modulus = 1e6\nbending_ratio = 1.0\nhorizon = 2.01\n") + more);
        auto particles = cube(*law, 5);
        const std::vector<Vec3> y = shake(particles, kSpacing);
        check_momenta(particles, y, kSpacing);
        check_gradient(particles, y, kSpacing);
    }
}

TEST_CASE("pd_elastic: families of more bonds than the first sweep keeps for the second", "[constitutive]") {
    const auto law = pd_elastic("youngs_modulus = 1e6\nbending_ratio = 1.0\nhorizon = 8.0\nsurface = \"family\"\n");
    auto particles = cube(*law);
    const Bonds& bonds = particles.bonds();
    REQUIRE(bonds.row[middle(9) + 1] - bonds.row[middle(9)] > 512);
    const std::vector<Vec3> y = shake(particles, kSpacing);
    check_momenta(particles, y, kSpacing);
    check_gradient(particles, y, kSpacing);
}

TEST_CASE("pd_elastic: moment-exact weights have the modulus along every direction, at faces as well",
          "[constitutive]") {
    // sum w V n n n n = (1 1 + 1 1 + 1 1)/3: C11 = 3 C12 = 3 C44 = (2 mu + lambda) = 1.2 E
    const auto law = pd_elastic("youngs_modulus = 1e6\nhorizon = 2.01\ninfluence = \"constant\"");
    auto particles = cube(*law, 7);
    for (const std::size_t p : {middle(7), middle(7) - 3}) {
        const Stiffness C = measure_stiffness(particles, p, kVolume);
        CHECK_THAT(C(0, 0), WithinRel(1.2e6, 1e-5));
        CHECK_THAT(C(2, 2), WithinRel(1.2e6, 1e-5));
        CHECK_THAT(C(0, 1), WithinRel(0.4e6, 1e-5));
        CHECK_THAT(C(5, 5), WithinRel(0.4e6, 1e-5));
    }
}

TEST_CASE("pd_elastic: the integral deformation gradient is exact for affine maps", "[constitutive]") {
    const auto law = pd_elastic("youngs_modulus = 1e6\nhorizon = 3.015");
    auto particles = cube(*law, 5);
    particles.deform(some_stretch());
    Block<double> b = particles.block();
    law->prepare(b);
    const LawNeeds needs = law->needs();
    std::size_t field = 0;
    while (std::string(needs.particle_state.data[field].name) != "mean_deformation") ++field;
    for (std::size_t p = 0; p < particles.size(); ++p)
        for (std::size_t c = 0; c < 9; ++c)
            CHECK_THAT(b.particle_state[field][c][p],
                       WithinAbs(some_stretch()(static_cast<int>(c / 3), static_cast<int>(c % 3)), 1e-12));
}

TEST_CASE("pd_elastic: forces of any motion cancel in pairs", "[constitutive]") {
    const auto law = pd_elastic("youngs_modulus = 1e6");
    auto particles = cube(*law, 5);
    std::mt19937 random(9);
    std::uniform_real_distribution<double> shift(-0.3 * kSpacing, 0.3 * kSpacing);
    particles.move([&](const Vec3& X) -> Vec3 { return X + Vec3(shift(random), shift(random), shift(random)); });
    particles.evaluate();
    Vec3 sum = Vec3::Zero();
    double scale = 0;
    for (std::size_t p = 0; p < particles.size(); ++p) sum += particles.force(p), scale += particles.force(p).norm();
    CHECK(sum.norm() <= 1e-13 * scale);
}

TEST_CASE("pd_elastic: sheets and strands are exact in their span and free across it", "[constitutive]") {
    const auto averaged = pd_elastic("youngs_modulus = 1e6\nformulation = \"paper\""),
               springs = pd_elastic("youngs_modulus = 1e6\nbending_ratio = 0.0");
    for (const int dimensions : {2, 1}) {
        CAPTURE(dimensions);
        const Matrix3d turn = rotation(0.7, {1, 2, -1});  // the span is not aligned with the axes
        std::vector<Vec3> X;
        for (int i = 0; i < 9; ++i)
            for (int j = 0; j < (dimensions == 2 ? 9 : 1); ++j)
                X.push_back(turn * Vec3(i * kSpacing, j * kSpacing, 0.0));
        Particles<double> a(*averaged, X, kVolume), b(*springs, X, kVolume);
        a.deform(some_stretch()), b.deform(some_stretch());
        a.evaluate(), b.evaluate();
        REQUIRE(b.largest_force() > 0);
        for (std::size_t p = 0; p < X.size(); ++p) CHECK((a.force(p) - b.force(p)).norm() <= 1e-11 * b.largest_force());
        CHECK_THAT(a.energy(), WithinRel(b.energy(), 1e-11));
        a.deform(rotation(2.0, {0, 1, 1}));
        a.evaluate();
        CHECK(a.largest_force() <= 1e-11 * b.largest_force());
    }
}

TEMPLATE_TEST_CASE("pd_elastic: few bonds or none leave no NaN", "[constitutive]", float, double) {
    const auto law = pd_elastic<TestType>("youngs_modulus = 1e6");
    check_few_bonds(*law, kSpacing, kVolume);
}

TEST_CASE("pd_elastic: a particle that lost all bonds is free", "[constitutive]") {
    const auto law = pd_elastic("youngs_modulus = 1e6");
    auto particles = cube(*law, 5);
    const auto p = static_cast<std::uint32_t>(middle(5));
    Bonds& bonds = particles.bonds();
    for (std::uint32_t s = bonds.row[p]; s < bonds.row[p + 1]; ++s) {
        bonds.break_direction(p, s);
        bonds.break_direction(bonds.neighbour[s], bonds.opposite(p, s));
    }
    particles.renew();
    particles.deform(some_stretch());
    particles.evaluate();
    CHECK(particles.force(p).norm() == 0);
    for (std::size_t q = 0; q < particles.size(); ++q) CHECK(particles.force(q).allFinite());
    Block<double> all = particles.block();
    CHECK(law->energy(particles.block(p, 1)) == 0);
    CHECK(std::isfinite(law->energy(all)));
}

TEST_CASE("pd_elastic: parameters that contradict are refused by name", "[constitutive]") {
    CHECK(contains(refused_key("youngs_modulus = 1e6\npoisson_ratio = 0.3"), "poisson_ratio: "));
    CHECK(contains(refused_key("youngs_modulus = 1e6\npoisson_ratio = 0.3"), "pd_lps"));
    CHECK(contains(refused_key(""), "youngs_modulus: "));
    CHECK(contains(refused_key("youngs_modulus = 1e6\nmu = 1.0"), "mu: "));
    CHECK(contains(refused_key("calibration = \"paper\"\nmu = 1.0"), "lambda: "));
    CHECK(contains(refused_key(paper(1, 1, "youngs_modulus = 1.0")), "youngs_modulus: "));
    CHECK(contains(refused_key(paper(1, 1, "bending_ratio = 1.0")), "bending_ratio: "));
    CHECK(contains(refused_key(paper(0, 0)), "lambda: "));
    CHECK(contains(message_of([] { pd_elastic("youngs_modulus = 1e6\nhorizon = 1.0"); }),
                   "'horizon' in pd_elastic must be above 1"));
}

TEST_CASE("pd_elastic: one spring per bond needs no averaged deformation", "[constitutive]") {
    const LawNeeds springs = pd_elastic("youngs_modulus = 1e6\nbending_ratio = 0.0")->needs();
    CHECK_FALSE(springs.prepare);
    CHECK_FALSE(springs.deformation_gradient);
    for (std::uint32_t k = 0; k < springs.particle_state.size; ++k)
        CHECK(std::string(springs.particle_state.data[k].name) == "normalisation");
    CHECK(pd_elastic("youngs_modulus = 1e6")->needs().prepare);
}
