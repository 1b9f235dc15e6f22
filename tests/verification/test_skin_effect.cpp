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
        for (const char* horizon : {"2.01", "2.2", "3.015"}) {
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

namespace {

/// C11 over 1.2 E of springs in the full lattice: 5 sum w n_1^4 / sum w.
template <class Weight>
double lattice_ratio(double horizon, Weight weight) {
    const int reach = static_cast<int>(horizon);
    double sum = 0, along = 0;
    for (int i = -reach; i <= reach; ++i)
        for (int j = -reach; j <= reach; ++j)
            for (int k = -reach; k <= reach; ++k) {
                const double X = std::sqrt(double(i * i + j * j + k * k));
                if (X == 0 || X >= horizon) continue;
                sum += weight(X);
                along += weight(X) * std::pow(i / X, 4);
            }
    return 5 * along / sum;
}

}  // namespace

TEST_CASE("skin effect: ghosts give thin bars the modulus that the lattice has inside", "[verification]") {
    for (const std::string law : {"pd_bond", "pd_elastic", "pd_lps"})
        for (const double horizon : {2.01, 2.2, 3.015}) {
            const double inside = lattice_ratio(horizon, [&](double X) {  // their weights, with linear influence
                return law == "pd_bond" ? X : (1 - X / horizon) * (law == "pd_lps" ? X * X : 1);
            });
            std::cout << fmt::format("{:11} horizon {:5}  lattice {:.4f}", law, horizon, inside);
            for (const int width : {5, 10}) {
                CAPTURE(law, horizon, width);
                const double ratio = force_ratio(law, fmt::format("horizon = {}\nsurface = \"ghost\"", horizon), width);
                std::cout << fmt::format("  ghost {:2} {:.4f}", width, ratio / inside);
                CHECK_THAT(ratio / inside, WithinAbs(1, width == 5 ? 0.05 : 0.02));
            }
            std::cout << '\n';
        }
}

namespace {

/// The bar of `counts` particles `h` apart, centred, with y = X + strain X_axis e_axis everywhere: the force [N] that its
/// halves beyond the plane X_axis = at exchange.
double reaction(const ConstitutiveLaw<double>& law, const std::array<int, 3>& counts, double h, int axis, double strain,
                double at) {
    std::vector<Vec3> X;
    for (int i = 0; i < counts[0]; ++i)
        for (int j = 0; j < counts[1]; ++j)
            for (int k = 0; k < counts[2]; ++k)
                X.push_back(h * (Vec3(i, j, k) - 0.5 * Vec3(counts[0] - 1, counts[1] - 1, counts[2] - 1)));
    Particles<double> bar(law, X, h * h * h);
    bar.move([&](const Vec3& x) -> Vec3 { return x + strain * x[axis] * Vec3::Unit(axis); });
    bar.evaluate();
    double sum = 0;
    for (std::size_t p = 0; p < X.size(); ++p) sum -= X[p][axis] > at ? bar.force(p)[axis] : 0;
    return sum;
}

}  // namespace

TEST_CASE("skin effect: reactions of prescribed bars, Peridigm's gold", "[verification]") {
    // B5: ElasticBondBased3D, K = 200 GPa, c = 18 K/(pi delta^4); local 1.8 K A strain = 3.6e8 N
    const auto bond = make<ConstitutiveLaw, double>(
        "pd_bond", "youngs_modulus = 300e9\nhorizon_length = 0.751\ncalibration = \"continuum\"",
        {.density = 1000, .particle_spacing = 0.25, .grid_spacing = 0});
    CHECK_THAT(reaction(*bond, {4, 24, 4}, 0.25, 1, 1e-3, 1.5), WithinRel(2.5125739090e8, 1e-10));
    CHECK_THAT(reaction(*bond, {4, 24, 4}, 0.25, 1, 1e-3, -1.5), WithinRel(2.5125739090e8, 1e-10));
    // LinearLPSBar, strain 0.1; local 1.6608e10 N; our law is geometrically nonlinear
    const double K = 160e10, mu = 79.3e10;
    const auto lps =
        make<ConstitutiveLaw, double>("pd_lps",
                                      fmt::format("surface = \"family\"\ninfluence = \"constant\"\nhorizon_length = "
                                                  "0.1502\nyoungs_modulus = {:.17g}\npoisson_ratio = {:.17g}",
                                                  9 * K * mu / (3 * K + mu), (3 * K - 2 * mu) / (6 * K + 2 * mu)),
                                      {.density = 1000, .particle_spacing = 0.05, .grid_spacing = 0});
    CHECK_THAT(reaction(*lps, {20, 5, 5}, 0.05, 0, 0.1, 0), WithinRel(2.1493854407e10, 1e-10));
    // the linearised gold: the same per strain as the strain vanishes
    CHECK_THAT(reaction(*lps, {20, 5, 5}, 0.05, 0, 1e-6, 0) * 1e5, WithinRel(2.0658625810e10, 1e-5));
}
