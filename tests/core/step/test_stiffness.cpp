// REFERENCES.md B2: the table of lattice errors, for the bodies of a scene.
#include "perimpm/math/stiffness.hpp"
#include "perimpm/step/stiffness.hpp"
#include "support/box_scene.hpp"
#include "support/catch.hpp"
#include "support/lattice_stiffness.hpp"
#include "support/model.hpp"
#include "support/scene.hpp"

using namespace perimpm;

namespace {

MeasuredStiffness measured(const std::string& law, const Overrides& more = {}) {
    Overrides overrides{"material.rubber.constitutive={ " + law + ", youngs_modulus = 1e5 }",
                        "simulation.precision=\"float\""};
    overrides.insert(overrides.end(), more.begin(), more.end());
    return measure_stiffness(scene_from(kBox, overrides), 2).at(0);
}

const std::string kPlain = R"(surface = "family", influence = "constant", horizon = 3.015)";

}  // namespace

TEST_CASE("measure_stiffness: the bulk is the lattice sum of B2, along the axes and the diagonals", "[step]") {
    const double K0 = 1e5 / 1.5, mu0 = 0.4e5;
    const auto young = [](double K, double mu) { return 9 * K * mu / (3 * K + mu); };
    struct Row {
        const char* law;
        double K, mu_xy, mu_diag;  // over those asked, from the table
    };
    for (const Row& row :
         {Row{R"(type = "pd_bond", calibration = "continuum", horizon = 3.015)", 1.099, 1.194, 0.957},
          Row{R"(type = "pd_bond", calibration = "continuum", horizon = 2.000001)", 0.971, 0.882, 1.106},
          Row{R"(type = "pd_lps", surface = "none", influence = "constant", horizon = 3.015)", 1, 1.110, 0.835}}) {
        CAPTURE(row.law);
        const MeasuredStiffness s = measured(row.law, {"body.0.shape.max=[0.45, 0.45, 0.45]"});
        const double edge = young(row.K * K0, row.mu_diag * mu0), diagonal = young(row.K * K0, row.mu_xy * mu0);
        CHECK_THAT(s.bulk.softest, WithinRel(std::min(edge, diagonal), 6e-4));  // the table has three decimals
        CHECK_THAT(s.bulk.stiffest, WithinRel(std::max(edge, diagonal), 6e-4));
        const double mu = (2 * row.mu_diag + 3 * row.mu_xy) / 5 * mu0;  // Voigt's average of cubic tensors
        CHECK_THAT(s.bulk.youngs_modulus, WithinRel(young(row.K * K0, mu), 6e-4));
        CHECK(s.youngs_modulus == 1e5);
        CHECK(s.bulk_particles ==
              (std::string(row.law).find("3.015") != std::string::npos ? 27 : 1));  // of two horizons of it
        CHECK(s.bulk_particles + s.surface_particles == 729);
        CHECK(s.unstable_particles == 0);
    }
}

TEST_CASE("measure_stiffness: the calibrated lattice has the modulus on average and its own anisotropy", "[step]") {
    const MeasuredStiffness s = measured(R"(type = "pd_elastic", bending_ratio = 1.0, )" + kPlain);
    const auto law =
        make<ConstitutiveLaw, double>("pd_elastic", "youngs_modulus = 1e5\nhorizon = 3.015\ninfluence = \"constant\"",
                                      {.density = 1000, .particle_spacing = 0.05, .grid_spacing = 0});
    Particles<double> particles(*law, lattice(7, 0.05), 1.25e-4);
    const double families =
        static_cast<double>(particles.bonds().row[middle(7) + 1] - particles.bonds().row[middle(7)]);
    // S = sum w V M = 6 E shared by 122 equal bonds
    const DirectionalModulus modulus(lattice_stiffness(particles, middle(7), [&](double) { return 6e5 / families; }));
    CHECK_THAT(s.bulk.youngs_modulus, WithinRel(1e5, 1e-6));
    CHECK_THAT(s.bulk.poisson_ratio, WithinAbs(0.25, 1e-6));
    CHECK_THAT(s.bulk.softest, WithinRel(modulus(Vec3::UnitX()), 1e-6));
    CHECK_THAT(s.bulk.stiffest, WithinRel(modulus(Vec3(1, 1, 1).normalized()), 1e-6));
    CHECK_THAT(s.wave_speed, WithinRel(std::sqrt(1.2e5 / 1000), 1e-6));
}

TEST_CASE("measure_stiffness: the worst surface particle is a corner, or where weights are moment-exact nobody is off",
          "[step]") {
    const MeasuredStiffness none = measured(R"(type = "pd_bond", surface = "none", horizon = 2.01)");
    // a corner's family: 32 bonds cut down to (1 0 0) 3x, (1 1 0) 3x, (1 1 1), (2 0 0) 3x; sum |X| V counts
    const double whole = 6 * 1 + 12 * std::sqrt(2.0) + 8 * std::sqrt(3.0) + 6 * 2;
    const double corner = 3 * 1 + 3 * std::sqrt(2.0) + std::sqrt(3.0) + 3 * 2;
    CHECK_THAT(none.worst.youngs_modulus, WithinRel(1e5 * corner / whole, 1e-6));
    for (int c = 0; c < 3; ++c) CHECK_THAT(std::abs(none.worst_position[c] - 0.2), WithinAbs(0.175, 1e-9));
    const MeasuredStiffness moment = measured(R"(type = "pd_elastic", surface = "moment", horizon = 3.015)");
    CHECK_THAT(moment.bulk.softest, WithinRel(1e5, 1e-5));
    CHECK_THAT(moment.bulk.stiffest, WithinRel(1e5, 1e-5));
}

TEST_CASE("measure_stiffness: local laws have what they are asked for, by their energy", "[step]") {
    const std::string moduli = ", youngs_modulus = 1e5, poisson_ratio = 0.25", inner = R"({ type = "fixed_corotated")";
    for (const std::string& law :
         {inner + moduli, R"({ type = "neo_hookean")" + moduli, R"({ type = "von_mises", yield_stress = 1e3)" + moduli,
          R"({ type = "tensile_damage", tensile_strength = 1e3, fracture_energy = 10.0, law = )" + inner + moduli +
              " }"}) {
        CAPTURE(law);
        const MeasuredStiffness s =
            measure_stiffness(scene_from(kBox, {"material.rubber.constitutive=" + law + " }"}), 1).at(0);
        CHECK(s.material == "rubber");
        CHECK(s.bulk_particles == 512);
        CHECK(s.surface_particles == 0);
        CHECK_THAT(s.bulk.softest, WithinRel(1e5, 1e-6));
        CHECK_THAT(s.bulk.stiffest, WithinRel(1e5, 1e-6));
        CHECK_THAT(s.bulk.poisson_ratio, WithinRel(0.25, 1e-6));
        CHECK_THAT(s.wave_speed, WithinRel(std::sqrt(1.2e5 / 1000), 1e-6));
    }
}

TEST_CASE("measure_stiffness: bodies without a whole family have no bulk, particles without bonds no stiffness",
          "[step]") {
    const MeasuredStiffness row = measured(R"(type = "pd_bond")", {kPoint});
    CHECK(row.bulk_particles == 0);
    CHECK(std::isnan(row.bulk.youngs_modulus));
    CHECK(row.surface_particles == 1);
    CHECK(std::isnan(row.worst.softest));
}
