#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "perimpm/peridynamics/family.hpp"
#include "support/catch.hpp"
#include "support/model.hpp"
#include "support/particles.hpp"

using namespace perimpm;

namespace {

constexpr double kSpacing = 0.01, kVolume = kSpacing * kSpacing * kSpacing, kDensity = 1000;

/// 2/omega of the largest frequency about the present state, by the forces' finite differences [s].
double largest_stable_step(Particles<double>& particles, const Eigen::Matrix3d& F) {
    const auto size = static_cast<Eigen::Index>(3 * particles.size());
    const double step = 1e-6 * kSpacing;
    Eigen::MatrixXd K(size, size);
    for (Eigen::Index j = 0; j < size; ++j) {
        const auto p = static_cast<std::size_t>(j / 3);
        const Vec3 at = F * particles.reference()[p];
        for (const double sign : {1.0, -1.0}) {
            particles.place(p, at + sign * step * Vec3::Unit(j % 3));
            particles.evaluate();
            for (Eigen::Index i = 0; i < size; ++i) {
                const double share = -sign * particles.force(static_cast<std::size_t>(i / 3))[i % 3] / (2 * step);
                K(i, j) = sign > 0 ? share : K(i, j) + share;
            }
        }
        particles.place(p, at);
    }
    const Eigen::MatrixXd symmetric = (K + K.transpose()) / 2;
    const double largest =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
    return 2 / std::sqrt(largest / (kDensity * kVolume));
}

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
