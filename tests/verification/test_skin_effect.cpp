// REFERENCES.md B5: thin bars in prescribed uniaxial strain, force through the middle over that of the local law.
#include <fmt/format.h>

#include <iostream>
#include <numbers>

#include "support/catch.hpp"
#include "support/model.hpp"
#include "support/particles.hpp"

using namespace perimpm;

namespace {

constexpr double kSpacing = 0.01, kVolume = kSpacing * kSpacing * kSpacing, kModulus = 1e6;

/// Homogeneous strain: what the halves of a bar of `width` x `width` particles exchange, over 1.2 E strain A (nu = 1/4).
double force_ratio(const std::string& law_name, const std::string& table, int width) {
    const auto law =
        make<ConstitutiveLaw, double>(law_name, "youngs_modulus = 1e6\n" + table,
                                      {.density = 1000, .particle_spacing = kSpacing, .grid_spacing = 2 * kSpacing});
    std::vector<Vec3> X;
    for (int i = -8; i < 8; ++i)
        for (int j = 0; j < width; ++j)
            for (int k = 0; k < width; ++k) X.push_back(kSpacing * Vec3(i + 0.5, j, k));
    Particles<double> bar(*law, X, kVolume);
    constexpr double strain = 1e-6;
    bar.move([](const Vec3& at) -> Vec3 { return at + Vec3(strain * at[0], 0, 0); });
    bar.evaluate();
    double right = 0;
    for (std::size_t p = 0; p < X.size(); ++p) right += X[p][0] > 0 ? bar.force(p)[0] : 0;
    return -right / (1.2 * kModulus * strain * std::pow(width * kSpacing, 2));
}

/// The same for one spring c s per bond, c = 18 K / sum |X| V over the full lattice or 18 K / (pi delta^4): the bonds that
/// cross the middle, counted by their offset on the lattice.
double counted_ratio(double horizon, int width, bool continuum) {
    const int reach = static_cast<int>(horizon);
    double sum = 0, crossing = 0;
    for (int i = -reach; i <= reach; ++i)
        for (int j = -reach; j <= reach; ++j)
            for (int k = -reach; k <= reach; ++k) {
                const double X = std::sqrt(double(i * i + j * j + k * k));
                if (X == 0 || X > horizon) continue;
                sum += X;
                const double bonds =
                    std::max(i, 0) * std::max(width - std::abs(j), 0) * std::max(width - std::abs(k), 0);
                crossing += bonds * std::pow(i / X, 3);
            }
    const double c = 18 / 1.5 / (continuum ? std::numbers::pi * std::pow(horizon, 4) : sum);
    return c * crossing / (1.2 * width * width);
}

}  // namespace

TEST_CASE("skin effect: springs without treatment lose what the count of bonds says", "[verification]") {
    for (const double horizon : {2.01, 3.015})
        for (const int width : {5, 10}) {
            CAPTURE(horizon, width);
            const std::string table = fmt::format("surface = \"none\"\nhorizon = {}\n", horizon);
            CHECK_THAT(force_ratio("pd_bond", table, width), WithinRel(counted_ratio(horizon, width, false), 1e-5));
            const double continuum = force_ratio("pd_bond", table + "calibration = \"continuum\"", width);
            CHECK_THAT(continuum, WithinRel(counted_ratio(horizon, width, true), 1e-5));
            // B5, for widths of 1.66 and 3.32 horizons and the continuum's c
            if (horizon > 3) CHECK_THAT(continuum, WithinAbs(width == 5 ? 0.762 : 0.900, 0.015));
        }
}

TEST_CASE("skin effect: moment-exact weights make bond laws exact at surfaces", "[verification]") {
    const char* const laws[] = {"pd_bond", "pd_elastic", "pd_lps"};
    for (const std::string law : laws)
        for (const char* horizon : {"2.01", "2.25", "3.015"}) {
            std::cout << fmt::format("{:11} horizon {:5}", law, horizon);
            for (const std::string surface : {"none", "family", "moment"})
                for (const int width : {5, 10}) {
                    CAPTURE(law, horizon, surface, width);
                    const double ratio =
                        force_ratio(law, fmt::format("horizon = {}\nsurface = \"{}\"", horizon, surface), width);
                    std::cout << fmt::format("  {} {:2} {:.4f}", surface, width, ratio);
                    if (surface == "moment") CHECK_THAT(ratio, WithinAbs(1, width == 5 ? 0.05 : 0.02));
                }
            std::cout << '\n';
        }
}
