// REFERENCES.md B9: modes that must cost energy, and one that bonds cannot see.
#include <fmt/format.h>

#include <iostream>

#include "support/catch.hpp"
#include "support/model.hpp"
#include "support/particles.hpp"

using namespace perimpm;

namespace {

constexpr double kSpacing = 0.01, kVolume = kSpacing * kSpacing * kSpacing, kModulus = 1e6;

ModelPtr<ConstitutiveLaw, double> law_of(const std::string& name, const std::string& more = "") {
    return make<ConstitutiveLaw, double>(name, fmt::format("youngs_modulus = {}\n{}", kModulus, more),
                                         {.density = 1000, .particle_spacing = kSpacing, .grid_spacing = 2 * kSpacing});
}

/// Force density of the middle point over E (2 a/h)/delta where points of odd and even coordinate sum move by +-a along x.
double checkerboard(const ConstitutiveLaw<double>& law, double horizon) {
    constexpr int n = 13;
    Particles<double> points(law, lattice(n, kSpacing), kVolume);
    const double a = 0.05 * kSpacing;
    points.move(
        [&](const Vec3& X) -> Vec3 { return X + (std::lround(X.sum() / kSpacing) % 2 == 0 ? a : -a) * Vec3::UnitX(); });
    points.evaluate();
    return points.force(middle(n)).norm() / kVolume / (kModulus * 2 * a / kSpacing / (horizon * kSpacing));
}

}  // namespace

TEST_CASE("modes: a checkerboard is resisted, but not by averaged bonds alone", "[verification]") {
    for (const double horizon : {2.01, 3.015}) {
        const std::string reach = fmt::format("horizon = {}\n", horizon);
        const double averaged = checkerboard(
            *make<ConstitutiveLaw, double>("pd_elastic", reach + "calibration = \"paper\"\nmu = 6e5\nlambda = 0\n",
                                           {.density = 1000, .particle_spacing = kSpacing, .grid_spacing = 0}),
            horizon);
        std::cout << fmt::format("checkerboard, horizon {}: mu only {:.1e}", horizon, averaged);
        for (const char* name : {"pd_bond", "pd_lps", "pd_elastic"}) {
            const double resisted = checkerboard(*law_of(name, reach), horizon);
            std::cout << fmt::format("  {} {:.2f}", name, resisted);
            CAPTURE(name, horizon);
            CHECK(resisted > 0.5);
            CHECK(resisted > 10 * averaged);
        }
        std::cout << '\n';
        CHECK(averaged < 1e-10);  // F- of an odd field on an even family is 1: a mode without energy
    }
}

TEST_CASE("modes: bonds do not see a reflection, fixed-corotated pays for it", "[verification]") {
    const Eigen::Matrix3d reflection = diagonal(-1, 1, 1);
    for (const char* name : {"pd_bond", "pd_lps", "pd_elastic"}) {
        CAPTURE(name);
        const auto law = law_of(name);
        Particles<double> points(*law, lattice(5, kSpacing), kVolume);
        points.deform(reflection);
        points.evaluate();
        CHECK(points.energy() <= 1e-20 * kModulus * kVolume);
        CHECK(points.largest_force() <= 1e-12 * kModulus * kSpacing * kSpacing);
    }
    const auto local = law_of("fixed_corotated", "poisson_ratio = 0.25");
    Particles<double> point(*local, {Vec3::Zero()}, kVolume);
    point.set_F(0, reflection);
    const double mu = 0.4 * kModulus, lambda = mu;  // W = mu |F - R|^2 + lambda (J - 1)^2/2, R the nearest rotation
    CHECK_THAT(point.energy() / kVolume, WithinRel(4 * mu + 2 * lambda, 1e-12));
}
