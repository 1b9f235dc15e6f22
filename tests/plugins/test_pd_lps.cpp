// REFERENCES.md B1 (Peridigm's gold), B2 (moduli, table of lattice errors), B3, B9, A7; METHOD.md section 3.
#include <fmt/format.h>

#include <numbers>

#include "support/catch.hpp"
#include "support/lattice_stiffness.hpp"
#include "support/message.hpp"
#include "support/model.hpp"
#include "support/shaken.hpp"

using namespace perimpm;
using Eigen::Matrix3d;

namespace {

constexpr double kSpacing = 0.01, kVolume = kSpacing * kSpacing * kSpacing, kModulus = 1e6;

template <class Real = double>
ModelPtr<ConstitutiveLaw, Real> pd_lps(const std::string& more, double spacing = kSpacing) {
    return make<ConstitutiveLaw, Real>("pd_lps", "youngs_modulus = 1e6\n" + more,
                                       {.density = 1000, .particle_spacing = spacing, .grid_spacing = 0});
}
Particles<double> cube(const ConstitutiveLaw<double>& law, int count) {
    return {law, lattice(count, kSpacing), kVolume};
}
/// Weights as Silling et al. and Peridigm have them.
const std::string kPlain = "surface = \"family\"\ninfluence = \"constant\"\n";
std::string ratio(double nu) { return "poisson_ratio = " + std::to_string(nu) + "\n"; }

/// B1: K = 130 GPa, mu = 78 GPa, rho = 7800 kg/m^3; mu = 0.6 K is nu = 1/4 and E = 1.5 K.
struct Gold {
    ModelPtr<ConstitutiveLaw, double> law;
    Particles<double> points;
    std::vector<Vec3> y, v;
    double mass;

    Gold(std::vector<Vec3> X, std::vector<Vec3> v0, double volume, const std::string& table)
        : law{make<ConstitutiveLaw, double>("pd_lps", "youngs_modulus = 1.95e11\npoisson_ratio = 0.25\n" + table,
                                            {.density = 7800, .particle_spacing = 1, .grid_spacing = 0})},
          points{*law, X, volume, 7800},
          y{X},
          v{std::move(v0)},
          mass{7800 * volume} {}
    void place() {
        for (std::size_t p = 0; p < y.size(); ++p) points.place(p, y[p]);
        points.evaluate();
    }
    /// Velocity Verlet.
    void run(int steps, double dt) {
        place();
        for (int k = 0; k < steps; ++k) {
            for (std::size_t p = 0; p < y.size(); ++p) y[p] += dt * (v[p] += dt / 2 * points.force(p) / mass);
            place();
            for (std::size_t p = 0; p < y.size(); ++p) v[p] += dt / 2 * points.force(p) / mass;
        }
    }
    double dilatation(std::size_t p) { return points.block().particle_state[1][0][p]; }
};
Vec3 along_x(double x) { return {x, 0, 0}; }

}  // namespace

TEST_CASE("pd_lps: two points, Peridigm's gold", "[constitutive]") {
    Gold gold({along_x(-1), along_x(1)}, {along_x(1), along_x(-1)}, 2, kPlain + "horizon_length = 2.0");
    gold.run(5, 1e-5);
    CHECK_THAT(gold.y[0][0] + 1, WithinRel(4.704698050625396e-5, 1e-11));
    CHECK_THAT(gold.v[0][0], WithinRel(0.8180661902453248, 1e-12));
    CHECK_THAT(gold.dilatation(0), WithinRel(-1.4114094151884693e-4, 1e-11));
    CHECK_THAT(std::abs(gold.points.force(0)[0]) / 2, WithinRel(55044967.1923503, 1e-11));
    CHECK_THAT(gold.points.energy(0, 1), WithinRel(2589.699498467454, 1e-11));
}

TEST_CASE("pd_lps: two points released from a displacement, Peridigm's gold", "[constitutive]") {
    Gold gold({along_x(-1), along_x(1)}, {along_x(0), along_x(0)}, 2, kPlain + "horizon_length = 2.0");
    gold.y = {along_x(-1 + 1e-5), along_x(1 - 1e-5)};
    gold.place();
    CHECK_THAT(std::abs(gold.points.force(0)[0]) / 2, WithinRel(1.17e7, 1e-11));
    gold.run(5, 1e-5);
    CHECK_THAT(std::abs(gold.y[0][0] + 1), WithinRel(8.180661902457e-6, 1e-10));
    CHECK_THAT(std::abs(gold.v[0][0]), WithinRel(0.070305831494, 1e-10));
}

TEST_CASE("pd_lps: three points, Peridigm's gold", "[constitutive]") {
    const std::vector<Vec3> X = {along_x(-1), along_x(0), along_x(1)}, v = {along_x(1), along_x(0), along_x(-1)};
    Gold near(X, v, 1, kPlain + "horizon_length = 1.1");
    near.run(5, 1e-5);
    CHECK_THAT(near.y[0][0] + 1, WithinRel(4.560540381289581e-5, 1e-11));
    CHECK_THAT(near.v[0][0], WithinRel(0.7312081926246763, 1e-11));
    CHECK_THAT(near.dilatation(0), WithinRel(-1.3681621143879e-4, 1e-10));
    CHECK_THAT(near.points.energy(0, 1), WithinRel(1216.713921310228, 1e-10));
    // w = 1/|X|, every point bonded with every other
    Gold far(X, v, 1, "horizon_length = 2.1\ninfluence = \"inverse\"\nsurface = \"family\"");
    far.run(5, 1e-6);
    CHECK_THAT(far.y[0][0] + 1, WithinRel(4.995501063033806e-6, 1e-10));
    CHECK_THAT(far.v[0][0], WithinRel(0.9971887654256459, 1e-12));
    CHECK_THAT(far.points.energy(0, 1), WithinRel(14.598693059391, 1e-9));
}

TEST_CASE("pd_lps: a bond breaks where its stretch passes the limit, Peridigm's gold", "[constitutive]") {
    // Two points 1 m apart: m = V, theta = 3 e, no deviatoric part, so each pulls the other with 18 K V e.
    const double K = 130e9, V = 1.05, rho = 7800, E = 9 * K * 60e9 / (3 * K + 60e9),
                 nu = (3 * K - 120e9) / (6 * K + 120e9);
    const auto law =
        make<ConstitutiveLaw, double>("pd_lps",
                                      kPlain + "horizon_length = 1.02\nyoungs_modulus = " + std::to_string(E) +
                                          "\npoisson_ratio = " + std::to_string(nu),
                                      {.density = rho, .particle_spacing = 1, .grid_spacing = 0});
    Particles<double> pair(*law, {Vec3::Zero(), {0, 1, 0}}, V, rho);
    const auto peak = [&](double speed) {
        double u = 0, v = speed, largest = 0;
        constexpr double dt = 1e-8;
        for (int k = 0; k < 8000; ++k) {
            pair.place(0, {0, -u, 0}), pair.place(1, {0, 1 + u, 0});
            pair.evaluate();
            v += dt * pair.force(1)[1] / (rho * V);
            u += dt * v;
            largest = std::max(largest, 2 * u);
        }
        return largest;
    };
    CHECK_THAT(peak(244.939), WithinAbs(0.0199992, 5e-8));
    CHECK_THAT(peak(244.959), WithinAbs(0.0200008, 5e-8));
}

TEST_CASE("pd_lps: the bulk modulus is exact for any family, the isotropic average of shear as well",
          "[constitutive]") {
    for (const double nu : {-0.3, 0.0, 0.25, 0.4, 0.49})
        for (const char* more : {"", "influence = \"gaussian\"\n", "influence = \"linear\"\nhorizon = 2.01\n",
                                 "influence = \"cubic\"\n", "volume_correction = \"linear\"\n"}) {
            CAPTURE(nu, more);
            const auto law = pd_lps(ratio(nu) + more);
            auto particles = cube(*law, 9);
            for (const std::size_t p : {middle(9), std::size_t{0}}) {
                const Stiffness C = measure_stiffness(particles, p, kVolume);
                const IsotropicAverage average = isotropic_average(C);
                if (p != 0) CHECK_THAT(average.youngs_modulus(), WithinRel(kModulus, 1e-5));
                if (p != 0) CHECK_THAT(average.poisson_ratio(), WithinAbs(nu, 1e-5));
                // isotropic strain: e = eps x for every bond, theta = 3 eps, no deviatoric part
                CHECK_THAT((C.topLeftCorner<3, 3>().sum() / 9), WithinRel(kModulus / (3 * (1 - 2 * nu)), 1e-5));
            }
        }
}

TEST_CASE("pd_lps: shear has the published lattice errors", "[constitutive]") {
    struct Row {
        double horizon, xy, diagonal, partial_xy, partial_diagonal;
    };  // B2, columns "full: LPS" and "linear: LPS"
    for (const Row& row : {Row{2.0, 0.897, 1.154, 0.957, 1.064},
                           {3.0, 1.110, 0.835, 0.989, 1.017},
                           {3.015, 1.110, 0.835, 0.988, 1.018},
                           {4.0, 1.019, 0.971, 1.000, 1.000},
                           {5.0, 1.029, 0.956, 1.001, 0.999},
                           {6.0, 1.039, 0.942, 0.997, 1.005}}) {
        for (const bool partial : {false, true}) {
            CAPTURE(row.horizon, partial);
            // A hair beyond the rim, which rounding must not decide.
            const auto law = pd_lps(kPlain + "horizon = " + std::to_string(row.horizon + 1e-6) +
                                    (partial ? "\nvolume_correction = \"linear\"" : ""));
            auto particles = cube(*law, 13);
            const Stiffness C = measure_stiffness(particles, middle(13), kVolume);
            const double mu = 0.4 * kModulus;
            CHECK_THAT(C(5, 5) / mu, WithinAbs(partial ? row.partial_xy : row.xy, 6e-4));
            CHECK_THAT((C(0, 0) - C(0, 1)) / 2 / mu, WithinAbs(partial ? row.partial_diagonal : row.diagonal, 6e-4));
        }
    }
}

TEST_CASE("pd_lps: families hold the neighbours of the lattice", "[constitutive]") {
    for (const auto& [horizon, count] : {std::pair{2.01, 32u}, {3.015, 122u}, {4.01, 256u}}) {  // B3
        const auto law = pd_lps("horizon = " + std::to_string(horizon));
        auto particles = cube(*law, 9);
        const auto& row = particles.bonds().row;
        CHECK(row[middle(9) + 1] - row[middle(9)] == count);
    }
}

TEST_CASE("pd_lps: moment-exact weights have the moduli in every direction, at faces as well", "[constitutive]") {
    const auto law = pd_lps(ratio(0.35) + "horizon = 2.01\ninfluence = \"constant\"\n");
    auto particles = cube(*law, 7);
    const double lambda = kModulus * 0.35 / (1.35 * 0.3), mu = kModulus / 2.7;
    const std::size_t inner = middle(7), face = inner - 3, edge = face - 3 * 7, corner = 0;
    for (const std::size_t p : {inner, face, edge, corner}) {
        const Stiffness C = measure_stiffness(particles, p, kVolume);
        CHECK_THAT((C.topLeftCorner<3, 3>().sum() / 9), WithinRel(lambda + 2 * mu / 3, 1e-5));
        if (p == edge || p == corner) continue;  // 17 and 10 bonds do not point in enough directions
        CHECK_THAT(C(0, 0), WithinRel(lambda + 2 * mu, 1e-5));
        CHECK_THAT(C(0, 1), WithinRel(lambda, 1e-5));
        CHECK_THAT(C(5, 5), WithinRel(mu, 1e-5));
        CHECK(std::abs(C(0, 5)) <= 1e-5 * mu);
    }
}

TEST_CASE("pd_lps: rigid motion makes no force", "[constitutive]") {
    for (const char* surface : {"none", "family", "moment"}) {
        const auto law = pd_lps(ratio(0.4) + "surface = \"" + surface + "\"");
        auto particles = cube(*law, 7);
        for (const double angle : {0.3, 1.7, 3.1}) {
            const Matrix3d R = rotation(angle, {1, -2, 3});
            particles.move([&](const Vec3& X) -> Vec3 { return R * X + Vec3(0.01, 0.0, -0.02); });
            particles.evaluate();
            CHECK(particles.largest_force() <= 2e-12 * kModulus / 0.6 * kSpacing * kSpacing);
        }
    }
}

TEST_CASE("pd_lps: forces are minus the energy's gradient and balance, broken bonds included", "[constitutive]") {
    for (const char* surface : {"none", "family", "moment"}) {
        CAPTURE(surface);
        const auto law = pd_lps(ratio(0.1) + "horizon = 2.01\nsurface = \"" + surface + "\"");
        auto particles = cube(*law, 5);
        Bonds& bonds = particles.bonds();
        for (std::uint32_t p = 0; p < particles.size(); p += 7)
            for (std::uint32_t s = bonds.row[p]; s < bonds.row[p + 1]; s += 3) {
                bonds.break_direction(p, s);
                bonds.break_direction(bonds.neighbour[s], bonds.opposite(p, s));
            }
        particles.renew();
        const std::vector<Vec3> y = shake(particles, kSpacing);
        check_momenta(particles, y, kSpacing);
        check_gradient(particles, y, kSpacing);
    }
}

TEST_CASE("pd_lps: a checkerboard is resisted", "[constitutive]") {
    // B9: rms force density over E (2 a/h)/delta above 0.5
    const auto law = pd_lps("");
    constexpr int n = 11;
    auto particles = cube(*law, n);
    const double a = 0.05 * kSpacing;
    particles.move([&](const Vec3& X) -> Vec3 {
        const long parity = std::lround(X.sum() / kSpacing);
        return X + Vec3(parity % 2 == 0 ? a : -a, 0, 0);
    });
    particles.evaluate();
    const double density = particles.force(middle(n)).norm() / kVolume;
    CHECK(density / (kModulus * 2 * a / kSpacing / (2.2 * kSpacing)) > 0.5);
}

TEMPLATE_TEST_CASE("pd_lps: few bonds or none leave no NaN", "[constitutive]", float, double) {
    for (const char* surface : {"surface = \"family\"", "surface = \"moment\""}) {
        const auto law = pd_lps<TestType>(surface);
        check_few_bonds(*law, kSpacing, kVolume);
    }
}

TEST_CASE("pd_lps: yielding families, Peridigm's gold of the 8-point cube", "[constitutive]") {
    // C2: psi_0 = 25 sigma_y^2/(8 pi delta^5); lower layer at -200, upper at +200
    const double K = 67549, mu = 25902.2, psi = 25 * 351.79 * 351.79 / (8 * std::numbers::pi * std::pow(1.75, 5));
    const auto text = [](double v) { return fmt::format("{:.17g}\n", v); };
    const auto law = make<ConstitutiveLaw, double>(
        "pd_lps",
        kPlain + "horizon_length = 1.75\nyoungs_modulus = " + text(9 * K * mu / (3 * K + mu)) +
            "poisson_ratio = " + text((3 * K - 2 * mu) / (6 * K + 2 * mu)) + "yield_psi = " + text(psi),
        {.density = 2.7e-3, .particle_spacing = 0.5, .grid_spacing = 0});
    std::vector<Vec3> y, v;
    for (int k = 0; k < 8; ++k) {
        y.emplace_back(0.5 * (k & 1), 0.25 * (k & 2), 0.125 * (k & 4));
        v.emplace_back(0, 0, k & 4 ? 200 : -200);
    }
    Particles<double> points(*law, y, 0.125, 2.7e-3);
    const double m = 2.7e-3 * 0.125, dt = 1e-6;
    const auto place = [&] {
        for (std::size_t p = 0; p < 8; ++p) points.place(p, y[p]);
        points.evaluate();
    };
    struct Row {
        int step;
        double u, v, theta;
    };
    int step = 0;
    for (const Row& row : {Row{1000, -0.1082921786, -2.77534638, 1.5091438566e-3},
                           {5000, -0.2211566561, 60.33714385, -1.2482069690e-2},
                           {10000, -0.2240217358, 26.42323778, -9.0757304582e-3},
                           {35000, -0.2253276012, 6.39648583, -7.4812015625e-4}}) {
        for (; step < row.step; ++step) {
            for (std::size_t p = 0; p < 8; ++p) y[p] += dt * (v[p] += dt / 2 * points.force(p) / m);
            place();
            for (std::size_t p = 0; p < 8; ++p) v[p] += dt / 2 * points.force(p) / m;
        }
        CAPTURE(row.step);
        CHECK_THAT(y[0][2], WithinAbs(row.u, 1e-9));
        CHECK_THAT(v[0][2], WithinAbs(row.v, 1e-6));
        CHECK_THAT((points.block().particle_state[1][0][0]), WithinAbs(row.theta, 1e-10));
    }
}

TEST_CASE("pd_lps: small families of metals yield in single precision as in double", "[constitutive]") {
    constexpr double h = 4e-4;
    const std::string copper =
        "youngs_modulus = 117e9\npoisson_ratio = 0.35\nyield_stress = 400e6\nhorizon = 2.01\nyield = ";
    const ModelContext context{.density = 8930, .particle_spacing = h, .grid_spacing = 0};
    for (const char* rule : {"\"family\"", "\"bond\""}) {
        CAPTURE(rule);
        const auto coarse = make<ConstitutiveLaw, float>("pd_lps", copper + rule, context);
        const auto fine = make<ConstitutiveLaw, double>("pd_lps", copper + rule, context);
        Particles<float> a(*coarse, lattice(5, h), h * h * h);
        Particles<double> b(*fine, lattice(5, h), h * h * h);
        const auto squeeze = [](const Vec3& X) -> Vec3 { return {0.98 * X[0], 1.01 * X[1], 1.01 * X[2]}; };
        a.move(squeeze), b.move(squeeze);
        a.evaluate(), b.evaluate();
        for (std::size_t p = 0; p < a.size(); ++p) CHECK((a.force(p) - b.force(p)).norm() <= 1e-3 * b.largest_force());
    }
}

TEST_CASE("pd_lps: horizons in spacings or metres", "[constitutive]") {
    CHECK(pd_lps("horizon = 2.5")->needs().horizon == pd_lps("horizon_length = 0.025")->needs().horizon);
    CHECK_THROWS_AS(pd_lps("horizon = 2.5\nhorizon_length = 0.025"), InvalidParameter);
    CHECK_THROWS_AS(pd_lps("horizon_length = 0.01"), InvalidParameter);
}
