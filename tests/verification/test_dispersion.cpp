// REFERENCES.md B4: dispersion of plane waves. A lattice whose points all move by u = a p cos(k.X), p a polarisation: the
// force on the point at the origin gives w^2 = -f.p / (M a), M its mass. Against independent sums over the lattice, V the
// points' volume, n = X/|X|:
//   (1) pd_bond     rho w^2 = sum V c (n.p)^2 (1 - cos k.X)/|X|,  c = 18 K / sum V |X|
//   (2) pd_lps      rho w^2 = (9 K - 15 mu)/m^2 (S.p)^2 + (30 mu/m) sum V (n.p)^2 (1 - cos k.X)
//                   S = sum V X sin k.X,  m = sum V |X|^2
//   (3) pd_elastic  rho w^2 = 2 lambda sum V w (n.p)^2 (1 - cos k.X)/|X|^2 + 2 mu sum V w (n.p)^2 (n.g)^2
//                   w = 5 w^/sum V w^,  F- - 1 = i p (x) g,  g = K^-1 sum V w X sin k.X,  K = sum V w X (x) X
// and against the continuum's phase speeds over the local ones, which the lattice approaches as h shrinks (B4's table).
#include <fmt/format.h>

#include <iostream>
#include <numbers>

#include "support/catch.hpp"
#include "support/model.hpp"
#include "support/particles.hpp"

using namespace perimpm;

namespace {

constexpr double kSpacing = 0.01, kVolume = kSpacing * kSpacing * kSpacing, kYoung = 1e6, kDensity = 1000;

struct Wave {
    Vec3 k, p;
};

/// All points that the force on the one at the origin depends on.
std::vector<Vec3> ball(double radius) {
    const int reach = static_cast<int>(radius / kSpacing) + 1;
    std::vector<Vec3> points;
    for (const Vec3& X : lattice(2 * reach + 1, kSpacing))
        if (X.norm() <= radius) points.push_back(X);
    return points;
}

/// A law on the lattice around the origin, where families within a horizon are whole.
class Lattice {
public:
    Lattice(const std::string& law, const std::string& table, double horizon)
        : law_{make<ConstitutiveLaw, double>(
              law,
              fmt::format("youngs_modulus = {}\nhorizon = {}\nsurface = \"none\"\n{}\n{}", kYoung, horizon,
                          law == "pd_bond" ? "" : "influence = \"constant\"", table),
              {.density = kDensity, .particle_spacing = kSpacing, .grid_spacing = 0})},
          points_{*law_, ball(2.001 * law_->needs().horizon), kVolume, kDensity} {
        const auto& X = points_.reference();
        origin_ = static_cast<std::size_t>(
            std::min_element(X.begin(), X.end(), [](const Vec3& a, const Vec3& b) { return a.norm() < b.norm(); }) -
            X.begin());
    }

    /// [1/s^2]
    double frequency2(const Wave& wave) {
        constexpr double a = 1e-4 * kSpacing;
        points_.move([&](const Vec3& X) -> Vec3 { return X + a * std::cos(wave.k.dot(X)) * wave.p; });
        points_.evaluate();
        const Vec3 f = points_.force(origin_);
        CHECK((f - f.dot(wave.p) * wave.p).norm() <= 1e-6 * f.norm());  // p is one of the wave's polarisations
        return -f.dot(wave.p) / (kDensity * kVolume * a);
    }

    /// sum over the family of the point at the origin of value(X) V.
    template <class Value>
    auto sum(Value value) const {
        using Sum = std::decay_t<decltype(value(Vec3::Zero().eval()))>;
        Sum total = value(Vec3::Zero().eval());
        total -= total;
        const double horizon = law_->needs().horizon;
        for (const Vec3& X : points_.reference())
            if (X.norm() > 0 && X.norm() <= horizon) total += kVolume * value(X);
        return total;
    }

private:
    ModelPtr<ConstitutiveLaw, double> law_;
    Particles<double> points_;
    std::size_t origin_;
};

double share(const Vec3& X, const Vec3& p) { return X.norm() > 0 ? std::pow(X.dot(p) / X.norm(), 2) : 0; }  // (n.p)^2
double swing(const Vec3& X, const Wave& wave) { return share(X, wave.p) * (1 - std::cos(wave.k.dot(X))); }

double bond_sum(const Lattice& at, const Wave& wave) {
    const double c = 18 * kYoung / 1.5 / at.sum([](const Vec3& X) { return X.norm(); });
    return at.sum([&](const Vec3& X) { return X.norm() > 0 ? c * swing(X, wave) / X.norm() : 0; }) / kDensity;  // (1)
}

double lps_sum(const Lattice& at, const Wave& wave, double nu) {
    const double K = kYoung / (3 * (1 - 2 * nu)), mu = kYoung / (2 * (1 + nu));
    const double m = at.sum([](const Vec3& X) { return X.squaredNorm(); });
    const double S = at.sum([&](const Vec3& X) { return X.dot(wave.p) * std::sin(wave.k.dot(X)); });
    const double shape = at.sum([&](const Vec3& X) { return swing(X, wave); });
    return ((9 * K - 15 * mu) / (m * m) * S * S + 30 * mu / m * shape) / kDensity;  // (2)
}

double elastic_sum(const Lattice& at, const Wave& wave, double ratio) {
    const double lambda = 1.2 * kYoung / (1 + 2 * ratio), w = 5 / at.sum([](const Vec3&) { return 1.0; });
    const double K = w * at.sum([](const Vec3& X) { return X.squaredNorm(); }) / 3;  // the lattice's is isotropic
    const Vec3 g = w / K * at.sum([&](const Vec3& X) -> Vec3 { return X * std::sin(wave.k.dot(X)); });
    const double springs = at.sum([&](const Vec3& X) { return X.norm() > 0 ? swing(X, wave) / X.squaredNorm() : 0; });
    const double averaged = at.sum([&](const Vec3& X) { return share(X, wave.p) * share(X, g.normalized()); });
    return 2 * lambda * w * (springs + ratio * averaged * g.squaredNorm()) / kDensity;  // (3)
}

/// Along an axis and a diagonal of faces, with lengths from 25 to 1.05 horizons.
std::vector<Wave> waves(double horizon) {
    const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
    const Vec3 diagonal = (x + y).normalized(), across = (x - y).normalized();
    std::vector<Wave> all;
    for (const double k : {0.25, 0.5, 1.0, 2.0, 3.0, 4.0, 6.0})
        for (const auto& [along, p] :
             {std::pair<Vec3, Vec3>{x, x}, {x, y}, {diagonal, diagonal}, {diagonal, across}, {diagonal, z}})
            all.push_back({k / (horizon * kSpacing) * along, p});
    return all;
}

struct Row {
    double k, bond_p, bond_s, lps_p, lps_s, stiff_p;  ///< k delta; pd_bond; pd_lps with nu = 1/4, with nu = 0.4
};
constexpr Row kContinuum[] = {
    {0.25, 0.99876, 0.99926, 0.99867, 0.99920, 0.99711}, {0.5, 0.99505, 0.99703, 0.99470, 0.99682, 0.98850},
    {1, 0.98035, 0.98819, 0.97894, 0.98735, 0.95504},    {2, 0.92361, 0.95387, 0.91816, 0.95059, 0.83571},
    {3, 0.83620, 0.90024, 0.82452, 0.89321, 0.68102},    {4, 0.72795, 0.83220, 0.70860, 0.82052, 0.53348},
    {6, 0.49856, 0.67724, 0.46376, 0.65581, 0.32811},
};  // B4

}  // namespace

TEST_CASE("dispersion: every bond law has the frequencies of its lattice sum", "[verification]") {
    double worst = 0;
    const auto compare = [&](double measured, double expected) {
        CHECK_THAT(measured, WithinRel(expected, 1e-6));
        worst = std::max(worst, std::abs(measured / expected - 1));
    };
    for (const double horizon : {2.01, 3.015}) {
        CAPTURE(horizon);
        Lattice bond("pd_bond", "", horizon);
        for (const Wave& wave : waves(horizon)) compare(bond.frequency2(wave), bond_sum(bond, wave));
        for (const double nu : {0.1, 0.25, 0.4}) {
            Lattice lps("pd_lps", fmt::format("poisson_ratio = {}", nu), horizon);
            for (const Wave& wave : waves(horizon)) compare(lps.frequency2(wave), lps_sum(lps, wave, nu));
        }
        for (const double ratio : {0.0, 0.1, 1.0}) {
            Lattice elastic("pd_elastic", fmt::format("bending_ratio = {}", ratio), horizon);
            for (const Wave& wave : waves(horizon))
                compare(elastic.frequency2(wave), elastic_sum(elastic, wave, ratio));
        }
    }
    std::cout << fmt::format("dispersion: largest difference of w^2 from the lattice sum {:.1e}\n", worst);
}

TEST_CASE("dispersion: phase speeds approach the continuum's as h shrinks", "[verification]") {
    const double mu = kYoung / 2.5, local_p = std::sqrt(3 * mu / kDensity), local_s = std::sqrt(mu / kDensity);
    const double stiff_p = std::sqrt(kYoung * 0.6 / (1.4 * 0.2) / kDensity);  // nu = 0.4
    double before = 1;
    for (const double horizon : {3.0, 4.0, 6.0}) {
        const std::string partial = "volume_correction = \"linear\"\n";
        Lattice bond("pd_bond", partial, horizon), lps("pd_lps", partial, horizon),
            stiff("pd_lps", partial + "poisson_ratio = 0.4", horizon);
        double worst = 0;
        std::cout << fmt::format(
            "delta/h = {}: k delta; v/v0 on the lattice and in the continuum: pd_bond P, S; "
            "pd_lps P, S; pd_lps nu = 0.4 P\n",
            horizon);
        for (const Row& row : kContinuum) {
            const double k = row.k / (horizon * kSpacing);
            const auto speed = [&](Lattice& at, const Vec3& p, double local) {
                return std::sqrt(at.frequency2({k * Vec3::UnitX(), p})) / k / local;
            };
            const std::pair<double, double> pairs[] = {{speed(bond, Vec3::UnitX(), local_p), row.bond_p},
                                                       {speed(bond, Vec3::UnitY(), local_s), row.bond_s},
                                                       {speed(lps, Vec3::UnitX(), local_p), row.lps_p},
                                                       {speed(lps, Vec3::UnitY(), local_s), row.lps_s},
                                                       {speed(stiff, Vec3::UnitX(), stiff_p), row.stiff_p}};
            std::cout << fmt::format("{:5}", row.k);
            for (const auto& [measured, continuum] : pairs) {
                worst = std::max(worst, std::abs(measured - continuum));
                std::cout << fmt::format("  {:.4f} {:.4f}", measured, continuum);
            }
            std::cout << '\n';
        }
        std::cout << fmt::format("largest difference {:.4f}\n", worst);
        CHECK(worst < before);
        before = worst;
    }
    CHECK(before < 0.01);
}
