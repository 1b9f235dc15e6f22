#include <fmt/format.h>

#include <random>

#include "perimpm/peridynamics/family.hpp"
#include "support/catch.hpp"
#include "support/model.hpp"
#include "support/particles.hpp"
#include "support/stable_step.hpp"

using namespace perimpm;

namespace {

constexpr double kSpacing = 0.01, kVolume = kSpacing * kSpacing * kSpacing, kDensity = 1000;

struct Kind {
    std::string type, more;
};
Kind any_kind() {
    return GENERATE(Kind{"pd_bond", ""}, Kind{"pd_lps", "poisson_ratio = 0.1"}, Kind{"pd_lps", "poisson_ratio = 0.4"},
                    Kind{"pd_elastic", ""}, Kind{"pd_elastic", "bending_ratio = 1.0"});
}
ModelPtr<ConstitutiveLaw, double> make_law(const Kind& kind, const std::string& surface, double horizon) {
    return make<ConstitutiveLaw, double>(
        kind.type, fmt::format("youngs_modulus = 1e6\nhorizon = {}\nsurface = \"{}\"\n{}", horizon, surface, kind.more),
        {.density = kDensity, .particle_spacing = kSpacing, .grid_spacing = 2 * kSpacing});
}
/// A cube whose particles lie up to `jitter` spacings off their lattice.
std::vector<Vec3> cloud(double jitter) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> shift(-jitter * kSpacing, jitter * kSpacing);
    std::vector<Vec3> X = lattice(5, kSpacing);
    for (Vec3& x : X) x += Vec3(shift(random), shift(random), shift(random));
    return X;
}
/// Two bonds in five, chosen at random.
void break_bonds(Particles<double>& particles) {
    std::mt19937 random(4);
    Bonds& bonds = particles.bonds();
    for (std::uint32_t p = 0; p < particles.size(); ++p)
        for (std::uint32_t slot = bonds.row[p]; slot < bonds.row[p + 1]; ++slot) {
            const std::uint32_t q = bonds.neighbour[slot];
            if (q < p || random() % 5 > 1) continue;
            bonds.break_direction(p, slot), bonds.break_direction(q, bonds.opposite(p, slot));
        }
    particles.renew();
}

}  // namespace

TEST_CASE("stable step: below 2/omega and not far from it, on and off the lattice, whole and broken",
          "[peridynamics]") {
    const Kind kind = any_kind();
    const std::string surface = GENERATE("none", "family", "moment", "ghost");
    const double horizon = GENERATE(1.5, 2.2), jitter = GENERATE(0.0, 0.5);
    CAPTURE(kind.type, kind.more, surface, horizon, jitter);
    const auto law = make_law(kind, surface, horizon);
    Particles<double> particles(*law, cloud(jitter), kVolume);
    for (const bool broken : {false, true}) {
        if (broken) break_bonds(particles);
        const StableStep step = law->stable_step(particles.block());
        const double true_step = largest_stable_step(particles, Eigen::Matrix3d::Identity());
        CAPTURE(broken, step.any_stretch / true_step);
        CHECK(step.small_strains <= true_step);
        CHECK(step.small_strains >= 0.4 * true_step);
    }
}

TEST_CASE("stable step: below 2/omega for stretched and squeezed families, too", "[peridynamics]") {
    const Kind kind = any_kind();
    const double jitter = GENERATE(0.0, 0.5);
    const auto law = make_law(kind, "moment", 2.2);
    Particles<double> particles(*law, cloud(jitter), kVolume);
    const StableStep step = law->stable_step(particles.block());
    const double x = GENERATE(0.3, 0.7, 1.0, 2.0), y = GENERATE(0.3, 0.7, 1.0, 2.0), z = GENERATE(0.3, 0.7, 1.0, 2.0);
    if (x > y || y > z) return;
    const Eigen::Matrix3d F = diagonal(x, y, z);
    particles.deform(F);
    particles.evaluate();
    const double extension = 1 - 1 / std::max(1.0, peridynamics::largest_stretch(particles.block()));
    const double true_step = largest_stable_step(particles, F);
    CAPTURE(kind.type, kind.more, jitter, x, y, z, step.at(extension) / true_step, step.any_stretch / true_step);
    CHECK(step.at(extension) <= (x < 0.7 ? 1.1 : 1) * true_step);
}
