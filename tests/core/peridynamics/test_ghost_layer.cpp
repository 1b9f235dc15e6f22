#include <fmt/format.h>

#include "perimpm/peridynamics/ghost_layer.hpp"
#include "support/catch.hpp"
#include "support/model.hpp"
#include "support/particles.hpp"
#include "support/stable_step.hpp"

using namespace perimpm;

namespace {

constexpr double kSpacing = 0.01;
constexpr int kCount = 9;

/// A bond law by its type and what it has besides, over all of them.
struct Law {
    std::string type, more;
    ModelPtr<ConstitutiveLaw, double> with(const std::string& surface, double horizon) const {
        return make<ConstitutiveLaw, double>(
            type, fmt::format("youngs_modulus = 1e6\nhorizon = {}\nsurface = \"{}\"\n{}", horizon, surface, more),
            {.density = 1000, .particle_spacing = kSpacing, .grid_spacing = 2 * kSpacing});
    }
};
/// Energies of particles of `pd_bond` hold half of what neighbours see: of the others they are the particle's own.
Law any_law() {
    return GENERATE(Law{"pd_bond", ""}, Law{"pd_lps", "poisson_ratio = 0.1"}, Law{"pd_lps", "poisson_ratio = 0.4"},
                    Law{"pd_elastic", ""}, Law{"pd_elastic", "bending_ratio = 1.0"},
                    Law{"pd_elastic", "bending_ratio = 0.0"});
}
Particles<double> cube(const ConstitutiveLaw<double>& law) {
    return {law, lattice(kCount, kSpacing), kSpacing * kSpacing * kSpacing};
}

}  // namespace

TEST_CASE("ghost layer: particles at faces have the energy of inner ones, whatever the strain", "[peridynamics]") {
    const Law any = any_law();
    const double horizon = GENERATE(2.2, 3.015);
    CAPTURE(any.type, any.more, horizon);
    if (any.type == "pd_bond") return;
    const auto law = any.with("ghost", horizon);
    auto particles = cube(*law);
    Eigen::Matrix3d F;
    F << 1.1, 0.01, 0.0, 0.0, 1.2, 0.02, 0.03, 0.0, 1.3;
    particles.deform(F);
    const std::size_t inner = middle(kCount);
    const double whole = particles.energy(inner, 1);
    REQUIRE(whole > 0);
    for (const std::size_t towards_face : {2u, 3u, 4u})
        CHECK_THAT(particles.energy(inner - towards_face, 1), WithinRel(whole, 1e-12));
}

TEST_CASE("ghost layer: so have those at edges and corners where all directions are stretched alike",
          "[peridynamics]") {
    const Law any{"pd_elastic", GENERATE("", "bending_ratio = 1.0", "bending_ratio = 0.0")};
    const double horizon = GENERATE(2.2, 3.015);
    CAPTURE(any.more, horizon);
    const auto ghost = any.with("ghost", horizon), none = any.with("none", horizon);
    auto with = cube(*ghost), without = cube(*none);
    for (auto* particles : {&with, &without}) particles->deform(diagonal(1.02, 1.02, 1.02));
    const double whole = without.energy(middle(kCount), 1);
    double octant = 0, all = 0;  // sum w^ of the bonds that a corner has, and of all
    for (int i = -3; i <= 3; ++i)
        for (int j = -3; j <= 3; ++j)
            for (int k = -3; k <= 3; ++k) {
                const double weight = std::max(0.0, 1 - std::sqrt(double(i * i + j * j + k * k)) / horizon);
                if (i == 0 && j == 0 && k == 0) continue;
                all += weight, octant += i >= 0 && j >= 0 && k >= 0 ? weight : 0;
            }
    CHECK_THAT(without.energy(0, 1), WithinRel(octant / all * whole, 1e-9));
    for (std::size_t p = 0; p < with.size(); ++p) REQUIRE_THAT(with.energy(p, 1), WithinRel(whole, 1e-12));
}

TEST_CASE("ghost layer: off the lattice a swelling stores the same energy everywhere", "[peridynamics]") {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> shift(-0.25 * kSpacing, 0.25 * kSpacing);
    std::vector<Vec3> X = lattice(kCount, kSpacing);
    for (Vec3& x : X) x += Vec3(shift(random), shift(random), shift(random));
    const Law any = any_law();
    const auto law = any.with("ghost", 2.2);
    Particles<double> particles(*law, X, std::pow(kSpacing, 3));
    particles.deform(diagonal(1.02, 1.02, 1.02));
    if (any.type == "pd_bond") {
        const auto other = Law{"pd_elastic", "bending_ratio = 0.0\ninfluence = \"constant\""}.with("ghost", 2.2);
        Particles<double> same(*other, X, std::pow(kSpacing, 3));
        same.deform(diagonal(1.02, 1.02, 1.02));
        CHECK_THAT(particles.energy(), WithinRel(same.energy(), 1e-12));
        return;
    }
    const double inner = particles.energy(middle(kCount), 1);
    REQUIRE(inner > 0);  // sum w V over family and ghosts is the same for all
    for (std::size_t p = 0; p < X.size(); ++p) REQUIRE_THAT(particles.energy(p, 1), WithinRel(inner, 1e-12));
}

namespace {

/// The bound of the time step over 2/omega of the largest frequency of a small cube.
double share_of_stable_step(const ConstitutiveLaw<double>& law) {
    Particles<double> particles(law, lattice(5, kSpacing), std::pow(kSpacing, 3));
    return law.stable_step(particles.block()).small_strains /
           largest_stable_step(particles, Eigen::Matrix3d::Identity());
}

}  // namespace

TEST_CASE("ghost layer: the bound of the time step is below the largest frequency's", "[peridynamics]") {
    const Law any = any_law();
    const double horizon = GENERATE(1.5, 2.2);
    const double ghost = share_of_stable_step(*any.with("ghost", horizon)),
                 none = share_of_stable_step(*any.with("none", horizon));
    CAPTURE(any.type, any.more, horizon, ghost, none);
    CHECK(ghost <= 1);
    CHECK(ghost >= 0.95 * none);  // hardly more cautious than the bound is without ghosts
}

TEST_CASE("ghost layer: an inner particle has the bound of the time step that it has without ghosts",
          "[peridynamics]") {
    const Law any = any_law();
    CAPTURE(any.type, any.more);
    const auto ghost = any.with("ghost", 2.2), none = any.with("none", 2.2);
    auto with = cube(*ghost), without = cube(*none);
    const double inside = none->stable_step(without.block(middle(kCount), 1)).small_strains;
    CHECK_THAT(ghost->stable_step(with.block(middle(kCount), 1)).small_strains, WithinRel(inside, 1e-12));
}

TEST_CASE("ghost layer: sheets and strands have none", "[peridynamics]") {
    const auto make_sheet = [] {
        make<ConstitutiveLaw, double>(
            "pd_bond", "youngs_modulus = 1e6\nsurface = \"ghost\"",
            {.density = 1000, .particle_spacing = kSpacing, .grid_spacing = 0, .dimension = 2, .across = 1e-3});
    };
    CHECK_THROWS_AS(make_sheet(), InvalidParameter);
}
