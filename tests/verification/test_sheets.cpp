// Sheets in plane stress and strands as bars: their small-strain stiffness against closed forms, and how they bend.
// Derivations: SpringLattice in perimpm/peridynamics/family.hpp, header of plugins/constitutive/pd_lps.cpp.
#include <fmt/format.h>

#include <iostream>
#include <numbers>

#include "perimpm/step/stiffness.hpp"
#include "support/catch.hpp"
#include "support/lattice_stiffness.hpp"
#include "support/message.hpp"
#include "support/model.hpp"
#include "support/scene.hpp"

using namespace perimpm;

namespace {

constexpr double kYoung = 3e6, kSpacing = 0.02, kThickness = 1e-3, kSection = 2e-6;
const std::string
    kSheet =
        "shape = { type = \"rectangle\", corner = [1, 2, 3], edge_u = [0.3, 0, 0.4], edge_v = [-0.32, 0.18, 0.24] }\n"
        "thickness = 1e-3",
    kPlain = "surface = \"family\"\ninfluence = \"constant\"\nhorizon = 3.015\n",
    kStrand = "shape = { type = \"polyline\", points = [[1, 2, 3], [1.2, 2.4, 3.4]] }\ncross_section = 2e-6";

MeasuredStiffness measured(const std::string& law, const std::string& body) {
    return measure_stiffness(scene_from(fmt::format(R"(format = 1
[simulation]
end_time = 1
[transfer]
type = "particle"
[material.m]
density = 1000
constitutive = {{ {}, youngs_modulus = 3e6 }}
[[body]]
material = "m"
particle_spacing = 0.02
{}
)",
                                                    law, body)))
        .at(0);
}

ModelContext context(std::uint32_t dimension) {
    return {.density = 1000,
            .particle_spacing = kSpacing,
            .grid_spacing = 0,
            .dimension = dimension,
            .across = dimension == 2 ? kThickness : kSection};
}

/// A square lattice about the origin, or a row.
std::vector<Vec3> layer(int reach, std::uint32_t dimension) {
    std::vector<Vec3> X;
    for (int i = -reach; i <= reach; ++i)
        for (int j = -reach; j <= reach; ++j)
            if (dimension == 2 || j == 0) X.push_back(kSpacing * Vec3(i + 0.5, j, 0));
    return X;
}

}  // namespace

TEST_CASE("sheets: E and nu in plane stress on average over directions, whatever the law and its plane",
          "[verification]") {
    struct Row {
        const char* law;
        double nu;
    };
    for (const Row& row :
         {Row{R"(type = "pd_bond")", 1.0 / 3}, Row{R"(type = "pd_bond", surface = "none", horizon = 2.01)", 1.0 / 3},
          Row{R"(type = "pd_elastic", bending_ratio = 0)", 1.0 / 3},
          Row{R"(type = "pd_elastic", bending_ratio = 2, influence = "linear")", 1.0 / 3},
          Row{R"(type = "pd_elastic", surface = "none", formulation = "paper", poisson_ratio = 0.3333)", 1.0 / 3},
          Row{R"(type = "pd_lps", poisson_ratio = 0.3)", 0.3}, Row{R"(type = "pd_lps", poisson_ratio = 0.45)", 0.45},
          Row{R"(type = "pd_lps", poisson_ratio = 0.0, surface = "none")", 0.0}}) {
        CAPTURE(row.law);
        const MeasuredStiffness s = measured(row.law, kSheet);
        CHECK(s.dimension == 2);
        CHECK(s.bulk_particles > 100);
        CHECK_THAT(s.bulk.youngs_modulus, WithinRel(kYoung, 1e-6));
        CHECK_THAT(s.bulk.poisson_ratio, WithinAbs(row.nu, 1e-6));
        CHECK(s.youngs_modulus == kYoung);
        CHECK_THAT(s.poisson_ratio, WithinAbs(row.nu, 1e-12));
        CHECK_THAT(s.wave_speed, WithinRel(std::sqrt(kYoung / (1 - row.nu * row.nu) / 1000), 1e-6));
    }
}

TEST_CASE("sheets: the bulk modulus of the linear peridynamic solid is exact, its shear the lattice's",
          "[verification]") {
    // As in space (B2): theta of uniform expansion is exact, K = E/(2 (1 - nu)) in plane stress.
    const double nu = 0.3;
    const auto law =
        make<ConstitutiveLaw, double>("pd_lps", "youngs_modulus = 3e6\npoisson_ratio = 0.3\n" + kPlain, context(2));
    const double V = kSpacing * kSpacing * kThickness;
    Particles<double> sheet(*law, layer(4, 2), V);
    const std::size_t middle = 4 * 9 + 4;
    const Stiffness C = measure_stiffness(sheet, middle, V);
    CHECK_THAT((C(0, 0) + C(0, 1)) / 2, WithinRel(kYoung / (2 * (1 - nu)), 1e-6));
    CHECK(C.block<1, 3>(2, 2).norm() <= 1e-6 * C(0, 0));  // nothing resists across
    // deviator: 8 mu/m sum w x^2 n n n n over the family, constant w
    const double mu = kYoung / (2 * (1 + nu));
    double m = 0;
    for (std::uint32_t s = sheet.bonds().row[middle]; s < sheet.bonds().row[middle + 1]; ++s)
        m += (sheet.reference()[sheet.bonds().neighbour[s]] - sheet.reference()[middle]).squaredNorm();
    const Stiffness springs = lattice_stiffness(sheet, middle, [&](double x) { return 8 * mu * x * x / m; });
    CHECK_THAT(C(5, 5), WithinRel(springs(5, 5), 1e-6));
    CHECK_THAT(C(0, 0) - C(0, 1), WithinRel(springs(0, 0) - springs(0, 1), 1e-6));
}

TEST_CASE("sheets: micromodulus of infinitely many particles in a plane and along a line", "[verification]") {
    // REFERENCES (b): c = 9 E/(pi delta^3 t); along a line 2 E/(A delta^2). Energy c s^2 |X|/4 per bond and end, V each.
    for (const std::uint32_t d : {2u, 1u}) {
        CAPTURE(d);
        const auto law = make<ConstitutiveLaw, double>(
            "pd_bond", "youngs_modulus = 3e6\nhorizon = 3.015\ncalibration = \"continuum\"", context(d));
        const double V = d == 2 ? kSpacing * kSpacing * kThickness : kSpacing * kSection, delta = 3.015 * kSpacing;
        const double c = d == 2 ? 9 * kYoung / (std::numbers::pi * std::pow(delta, 3) * kThickness)
                                : 2 * kYoung / (kSection * delta * delta);
        Particles<double> body(*law, layer(4, d), V);
        const std::size_t middle = d == 2 ? 40 : 4;
        const Stiffness expected = lattice_stiffness(body, middle, [&](double x) { return c * x * V / 2; });
        CHECK((measure_stiffness(body, middle, V) - expected).norm() <= 1e-6 * expected.norm());
    }
}

TEST_CASE("strands: they are bars of stiffness E A, whatever the law and direction", "[verification]") {
    for (const char* law : {R"(type = "pd_bond")", R"(type = "pd_bond", surface = "none")", R"(type = "pd_elastic")",
                            R"(type = "pd_elastic", influence = "gaussian", surface = "none")", R"(type = "pd_lps")"}) {
        CAPTURE(law);
        const MeasuredStiffness s = measured(law, kStrand);
        CHECK(s.dimension == 1);
        CHECK_THAT(s.bulk.youngs_modulus, WithinRel(kYoung, 1e-6));
        CHECK_THAT(s.bulk.softest, WithinRel(kYoung, 1e-6));
        CHECK_THAT(s.wave_speed, WithinRel(std::sqrt(kYoung / 1000), 1e-6));
        if (!std::string(law).ends_with("lps\"") && !std::string(law).ends_with("elastic\"")) continue;
        CHECK_THAT(s.worst.youngs_modulus, WithinRel(kYoung, 1e-6));  // ends as well
    }
}

TEST_CASE("strands: a stretched one pulls with E A times its strain", "[verification]") {
    for (const char* name : {"pd_bond", "pd_elastic", "pd_lps"}) {
        CAPTURE(name);
        const auto law = make<ConstitutiveLaw, double>(name, "youngs_modulus = 3e6\nsurface = \"none\"", context(1));
        Particles<double> strand(*law, layer(9, 1), kSpacing * kSection);
        constexpr double strain = 1e-6;
        strand.move([](const Vec3& at) -> Vec3 { return at * (1 + strain); });
        strand.evaluate();
        double right = 0;
        for (std::size_t p = 0; p < strand.size(); ++p) right += strand.reference()[p][0] > 0 ? strand.force(p)[0] : 0;
        CHECK_THAT(-right, WithinRel(kYoung * kSection * strain, 1e-5));
    }
}

// A sheet on a cylinder of curvature k, its mid-surface unstretched: |Y| - |X| = -k^2 x^4/(24 |X|), and F- is short along x by
// k^2 <x^4>/(6 <x^2>), <> the family's mean. To leading order, with M the modulus of the springs or averaged bonds,
//   springs        W = (lambda/2) k^4 sum w V (x^4/(24 |X|^2))^2
//   averaged bonds W = mu k^4 sum w V (c x^2/|X|^2)^2,  c = <x^4>/(6 <x^2>)
// so neither has a bending stiffness at small curvature, W ~ k^2: they stiffen as k^4. For continuous families of constant w
// mu stores (3/8)/144 over (35/128)(1/3)/1152 = 33 times as much as an equal lambda.
TEST_CASE("sheets: springs and averaged bonds resist bending with the fourth power of curvature", "[verification]") {
    struct Row {
        const char* table;
        double lambda, mu;
    };
    for (const Row& row : {Row{"mu = 0.0\nlambda = 1e6", 1e6, 0}, Row{"mu = 1e6\nlambda = 0.0", 0, 1e6}}) {
        CAPTURE(row.table);
        const auto law =
            make<ConstitutiveLaw, double>("pd_elastic", "calibration = \"paper\"\n" + kPlain + row.table, context(2));
        const double V = kSpacing * kSpacing * kThickness;
        Particles<double> sheet(*law, layer(4, 2), V);
        const std::size_t middle = 40;
        double weights = 0, x2 = 0, x4 = 0, springs = 0, bonds = 0;
        for (const bool second : {false, true})
            for (std::uint32_t s = sheet.bonds().row[middle]; s < sheet.bonds().row[middle + 1]; ++s) {
                const Vec3 X = sheet.reference()[sheet.bonds().neighbour[s]] - sheet.reference()[middle];
                const double x = X[0];
                if (!second) {
                    weights += 1, x2 += x * x, x4 += std::pow(x, 4);
                    continue;
                }
                const double w = 8.0 / 3 / weights;
                springs += w * std::pow(std::pow(x, 4) / (24 * X.squaredNorm()), 2);
                bonds += w * std::pow(x4 / (6 * x2) * x * x / X.squaredNorm(), 2);
            }
        double last = 0;
        for (const double curvature : {0.5, 1.0}) {
            const double center = sheet.reference()[middle][0];
            sheet.move([&](const Vec3& at) {
                const double angle = curvature * (at[0] - center);
                return Vec3(std::sin(angle) / curvature, at[1], (1 - std::cos(angle)) / curvature);
            });
            const double W = sheet.energy(middle, 1) / V;
            const double expected = std::pow(curvature, 4) * (row.lambda / 2 * springs + row.mu * bonds);
            CHECK_THAT(W, WithinRel(expected, 2e-3));  // next order: (k delta)^2/10
            if (last > 0) CHECK_THAT(W / last, WithinRel(16.0, 5e-3));
            last = W;
        }
        std::cout << fmt::format("bending energy of {}: {:.4g} Pa at curvature times horizon {:.3g}\n",
                                 row.mu > 0 ? "averaged bonds" : "springs", last, 3.015 * kSpacing);
    }
}

TEST_CASE("sheets: what thin bodies do not have is refused by name", "[verification]") {
    const auto refusal = [](const std::string& law, const std::string& body) {
        return message_of([&] { measured(law, body); });
    };
    CHECK(contains(refusal(R"(type = "pd_elastic", poisson_ratio = 0.25)", kSheet), "must be 1/3 in a sheet"));
    CHECK(contains(refusal(R"(type = "pd_elastic", poisson_ratio = 0.25)", kStrand), "has no meaning in a strand"));
    CHECK(contains(refusal(R"(type = "pd_lps", poisson_ratio = 0.3)", kStrand), "has no meaning in a strand"));
    CHECK(contains(refusal(R"(type = "deviatoric_plastic", yield_stress = 1e4)", kSheet), "is for solids"));
    CHECK(contains(refusal(R"(type = "pd_lps", yield_stress = 1e4)", kSheet), "is for solids"));
    CHECK_NOTHROW(measured(R"(type = "deviatoric_plastic")", kSheet));
    for (const char* law : {R"(type = "fixed_corotated")", R"(type = "neo_hookean")"}) {
        const std::string message = refusal(law, kSheet);
        CHECK(contains(message, "is a sheet, one layer of particles"));
        CHECK(contains(message, "use a bond law"));
    }
}
