// REFERENCES.md B2 (F- exact for affine maps, surfaces included), B5, B9 (zero-energy modes); a local law inside another.
#include <fmt/format.h>

#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/model.hpp"
#include "support/shaken.hpp"

using namespace perimpm;
using Eigen::Matrix3d;

namespace {

constexpr double kSpacing = 0.01, kVolume = kSpacing * kSpacing * kSpacing, kModulus = 1e6;
const std::string kFixedCorotated = "law = { type = \"fixed_corotated\", youngs_modulus = 1e6 }\n";

template <class Real = double>
ModelPtr<ConstitutiveLaw, Real> correspondence(const std::string& more = "", const std::string& law = kFixedCorotated) {
    return make<ConstitutiveLaw, Real>("pd_correspondence", law + more,
                                       {.density = 1000, .particle_spacing = kSpacing, .grid_spacing = 2 * kSpacing});
}
Particles<double> cube(const ConstitutiveLaw<double>& law, int count = 5) {
    return {law, lattice(count, kSpacing), kVolume};
}
/// Of the block's field `index` for particle p: 9 numbers row by row, or 6 of a symmetric matrix.
Matrix3d matrix(const Block<double>& b, std::size_t field, std::size_t p, bool symmetric = false) {
    constexpr std::size_t at[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
    Matrix3d m;
    for (std::size_t c = 0; c < 9; ++c)
        m(static_cast<int>(c / 3), static_cast<int>(c % 3)) = b.particle_state[field][symmetric ? at[c] : c][p];
    return m;
}

/// B9: rms force per volume of a checkerboard of amplitude a, over E 2 a/(h delta), delta = 2.2 h.
double checkerboard(const std::string& more) {
    const auto law = correspondence(more);
    Particles<double> particles = cube(*law, 9);
    const double a = 0.05 * kSpacing;
    for (std::size_t p = 0; p < particles.size(); ++p) {
        const Vec3 X = particles.reference()[p];
        const long odd = std::lround((X[0] + X[1] + X[2]) / kSpacing) & 1;
        particles.place(p, X + Vec3(odd ? -a : a, 0, 0));
    }
    particles.evaluate();
    return particles.force(middle(9)).norm() / kVolume / (kModulus * 2 * a / (2.2 * kSpacing * kSpacing));
}

}  // namespace

TEST_CASE("pd_correspondence: F- is exact for affine maps at every point, and so is the stress", "[constitutive]") {
    Matrix3d F;
    F << 1.1, 0.01, 0.0, 0.0, 1.2, 0.02, 0.03, 0.0, 1.3;  // Peridynamics.jl, test_uniform_deformation
    const auto law = correspondence();
    const auto local = make<ConstitutiveLaw, double>("fixed_corotated", "youngs_modulus = 1e6", {.density = 1000});
    Particles<double> particles = cube(*law), one(*local, {Vec3::Zero()}, kVolume);
    particles.deform(F), particles.evaluate();
    one.set_F(0, F), one.evaluate();
    const Block<double> b = particles.block();
    for (std::size_t p = 0; p < particles.size(); ++p) {
        CHECK((matrix(b, 0, p) - F).norm() <= 1e-12 * F.norm());
        CHECK((matrix(b, 3, p, true) - one.tau(0)).norm() <= 1e-12 * one.tau(0).norm());
    }
    CHECK_THAT(particles.energy(), WithinRel(one.energy() * static_cast<double>(particles.size()), 1e-12));
}

TEST_CASE("pd_correspondence: forces are minus the energy's gradient and conserve both momenta", "[constitutive]") {
    for (const char* more : {"", "stabilisation = 0\n", "influence = \"constant\"\nhorizon = 3.015\n"}) {
        CAPTURE(more);
        const auto law = correspondence(more);
        Particles<double> particles = cube(*law);
        const std::vector<Vec3> y = shake(particles, kSpacing);
        check_momenta(particles, y, kSpacing);
        check_gradient(particles, y, kSpacing);
    }
}

TEST_CASE("pd_correspondence: stabilisation resists the checkerboard that F- does not see", "[constitutive]") {
    // z = -2 a for bonds of odd length: |b| = 4 a s sum_odd w V with s = G M/sum w |X|^2 V, M = 1.2 E, w = 1 - |X|/delta
    double odd = 0, trace = 0;
    for (int i = -2; i <= 2; ++i)
        for (int j = -2; j <= 2; ++j)
            for (int k = -2; k <= 2; ++k) {
                const double x2 = i * i + j * j + k * k, w = 1 - std::sqrt(x2) / 2.2;
                if (x2 == 0 || w <= 0) continue;
                odd += (i + j + k) % 2 ? w : 0, trace += w * x2;
            }
    const double expected = 4 * 1.2 * odd / trace / (2 / 2.2);
    CHECK_THAT(checkerboard(""), WithinRel(expected, 1e-9));
    CHECK_THAT(checkerboard("stabilisation = 0.25"), WithinRel(expected / 4, 1e-9));
    CHECK(checkerboard("") > 0.5);
    CHECK(checkerboard("stabilisation = 0") < 0.1 * checkerboard(""));
}

TEST_CASE("pd_correspondence: a law that flows leaves the same stress as by itself", "[constitutive]") {
    const std::string table = "youngs_modulus = 1e6, poisson_ratio = 0.3, yield_stress = 1e4, hardening = 1e5";
    const auto law = correspondence("", "law = { type = \"von_mises\", " + table + " }\n");
    std::string lines = table;
    std::replace(lines.begin(), lines.end(), ',', '\n');
    const auto local = make<ConstitutiveLaw, double>("von_mises", lines, {.density = 1000});
    Particles<double> particles = cube(*law), one(*local, {Vec3::Zero()}, kVolume);
    Matrix3d before = Matrix3d::Identity();
    for (const double stretch : {1.005, 1.03, 1.05, 1.02, 0.99}) {
        const Matrix3d F = rotation(stretch, {1, 2, 3}) * diagonal(stretch, 1 / std::sqrt(stretch), 0.999);
        particles.deform(F), particles.evaluate();
        Matrix3d elastic;
        for (int c = 0; c < 9; ++c) elastic(c / 3, c % 3) = one.block().F[static_cast<std::size_t>(c)][0];
        one.set_F(0, F * before.inverse() * elastic), one.evaluate();
        before = F;
        for (const std::size_t p : {std::size_t{0}, middle(5)})
            CHECK((matrix(particles.block(), 4, p, true) - one.tau(0)).norm() <= 1e-10 * one.tau(0).norm());
    }
    CHECK(one.block().particle_state[0][0][0] > 0.01);
}

TEST_CASE("pd_correspondence: by the grid it writes stress and no force", "[constitutive]") {
    const auto law = correspondence("divergence = \"grid\"\n");
    const LawNeeds needs = law->needs();
    CHECK((needs.bonds && needs.stress && !needs.deformation_gradient));
    CHECK(needs.particle_state.size == 2);  // neither force states nor a second stress
    CHECK_FALSE(correspondence()->needs().stress);
}

TEST_CASE("pd_correspondence: families that span no space carry nothing", "[constitutive]") {
    const auto law = correspondence();
    for (const std::vector<Vec3>& X : {std::vector<Vec3>{Vec3::Zero()},
                                       {Vec3::Zero(), Vec3(kSpacing, 0, 0)},
                                       {Vec3::Zero(), Vec3(kSpacing, 0, 0), Vec3(0, kSpacing, 0)}}) {
        Particles<double> few(*law, X, kVolume);
        few.deform(diagonal(1.5, 0.5, 1));
        few.evaluate();
        CHECK(few.largest_force() == 0);
        CHECK(few.energy() == 0);
    }
}

TEST_CASE("pd_correspondence: what it cannot take is refused where it is given", "[constitutive]") {
    const auto input = [](const std::string& law) { return message_of([&] { correspondence("", law); }); };
    const auto refusal = [](const std::string& more, const std::string& law = kFixedCorotated) {
        return message_of<InvalidParameter>([&] { correspondence(more, law); });
    };
    CHECK(contains(input(""), "missing key 'law'"));
    CHECK(contains(input("law = \"fixed_corotated\"\n"), "write law = { type = \"fixed_corotated\", ... }"));
    CHECK(contains(input("law = { type = \"fixed_corotatet\", youngs_modulus = 1 }\n"), "fixed_corotated"));
    CHECK(
        contains(input("law = { type = \"fixed_corotated\", youngs_module = 1 }\n"), "did you mean 'youngs_modulus'?"));
    CHECK(contains(input("law = { type = \"fixed_corotated\", youngs_modulus = -1 }\n"), "must be above 0 Pa"));
    CHECK(contains(refusal("", "law = { type = \"pd_elastic\", youngs_modulus = 1 }\n"), "must be a local law"));
    CHECK(contains(refusal("divergence = \"grid\"\nstabilisation = 1\n"), "belongs to divergence = \"bonds\""));
}
