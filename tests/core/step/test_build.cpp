#include <algorithm>

#include "support/catch.hpp"
#include "support/environment.hpp"
#include "support/message.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

std::string refusal(const Overrides& overrides) {
    return message_of([&] { box_world(overrides); });
}

}  // namespace

TEST_CASE("build: a spinning body starts as the rigid motion that it is", "[step]") {
    const auto w = box_world({"body.0.initial_velocity=[1, 0, 0]", "body.0.initial_angular_velocity=[0, 0, 2]"});
    REQUIRE(w->count == 512);
    for (std::size_t p = 0; p < w->count; ++p) {
        const Vec3 x = at(w->x, p) - Vec3::Constant(0.2);
        CHECK((at(w->v, p) - Vec3(1 - 2 * x[1], 2 * x[0], 0)).norm() < 1e-12);
        for (std::size_t c = 0; c < 9; ++c) CHECK(w->C[c][p] == (c == 1 ? -2 : c == 3 ? 2 : 0));
        for (std::size_t c = 0; c < 9; ++c) CHECK(w->materials[0].F[c][p] == (c % 4 == 0 ? 1 : 0));
        CHECK_THAT(w->mass[p], WithinRel(0.125, 1e-12));
        CHECK_THAT(w->volume[p], WithinRel(1.25e-4, 1e-12));
    }
    CHECK_THAT(w->max_speed, WithinRel((Vec3(1, 0, 0) + 2 * 0.175 * Vec3(1, 1, 0)).norm(), 1e-12));
}

TEST_CASE("build: only what the models ask for is allocated", "[step]") {
    const auto local = box_world();
    CHECK(local->materials[0].bonds.size() == 0);
    CHECK(local->materials[0].force.empty());
    const auto bonds = box_world({kBonds});
    CHECK(bonds->materials[0].F.empty());
    CHECK(bonds->materials[0].bonds.broken.empty());
    CHECK(bonds->materials[0].order.size() == 512);
    const auto no_grid = box_world({kBonds, kNeverBreaks, kNoGrid});
    CHECK_FALSE(no_grid->materials[0].bonds.broken.empty());
    CHECK(no_grid->C.empty());
    CHECK(no_grid->materials[0].order.empty());
    CHECK(no_grid->grid.bytes() == 0);
}

TEST_CASE("build: materials without a body are left out, those with one stand in scene order", "[step]") {
    const auto w =
        box_world({R"(material.air={ density = 1, constitutive = { type = "fixed_corotated", youngs_modulus = 1 } })"});
    REQUIRE(w->materials.size() == 1);
    CHECK(w->materials[0].name == "rubber");
}

TEST_CASE("build: a parameter given as a ramp has one value per particle", "[step]") {
    const auto w = box_world(
        {"material.rubber.constitutive.youngs_modulus={ from = 1e5, to = 5e5, start = [0, 0, 0], end = [0.4, 0, 0] }"});
    const auto& [spec, values] = w->materials[0].varying[0];
    REQUIRE(values.size() == 512);
    for (std::size_t p = 0; p < w->count; ++p) CHECK_THAT(values[p], WithinRel(1e5 + 1e6 * w->x[0][p], 1e-12));
}

TEST_CASE("build: models that do not fit together are refused", "[step]") {
    CHECK(
        contains(refusal({kNoGrid}), "law 'fixed_corotated' needs a deformation gradient, which transfer 'particle'"));
    CHECK(contains(refusal({kNeverBreaks}), "criterion 'critical_stretch' breaks bonds, but law 'fixed_corotated'"));
    CHECK(contains(refusal({kBonds, kNoGrid, "grid.domain={ min = [-1, -1, -1], max = [1, 1, 1] }"}),
                   "transfer 'particle' has no grid for the faces of grid.domain"));
    CHECK(contains(
        refusal({kBonds,
                 R"(body=[{ material = "rubber", particle_spacing = 0.05, shape = { type = "box", min = [0, 0, 0],)"
                 R"( max = [0.2, 0.2, 0.2] } }, { material = "rubber", particle_spacing = 0.1,)"
                 R"( shape = { type = "box", min = [1, 0, 0], max = [1.2, 0.2, 0.2] } }])"}),
        "use one material per spacing"));
    CHECK(contains(refusal({R"(material.rubber.constitutive={ type = "pd_elastic", youngs_modulus = 1, mu = 3 })"}),
                   "'mu'"));
}

TEST_CASE("build: a plugin whose declaration makes no sense is called faulty", "[step]") {
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", PERIMPM_TEST_PLUGINS};
    CHECK(contains(refusal({kBonds, R"(transfer={ type = "sample_kernel", grid = false })"}),
                   "plugin 'sample_kernel' is faulty: without a grid it must be a ParticleIntegrator"));
    CHECK(contains(refusal({R"(transfer={ type = "sample_kernel" })"}),
                   "plugin 'sample_kernel' is faulty: a grid transfer"));
    CHECK(
        contains(refusal({kBonds, R"(material.rubber.fracture={ type = "sample_criterion", bond = 0, interval = 0 })"}),
                 "plugin 'sample_criterion' is faulty: a criterion is asked every 1 or more steps"));
}

TEST_CASE("build: a body beyond the reach of the grid is refused by name", "[step]") {
    // 32768 cells of 0.1 m in single precision, 4 (2^17 - 2) in double
    const auto box_at = [](double x) {
        return "body.0.shape={ type = \"box\", min = [0, 0, " + std::to_string(x) + "], max = [0.2, 0.2, " +
               std::to_string(x + 0.2) + "] }";
    };
    const auto single_refusal = [&](double x) {
        return message_of([&] { box_world<float>({"simulation.precision=\"float\"", box_at(x)}); });
    };
    const std::string single = single_refusal(3277.0);
    CHECK(contains(single, "body 'body 0' reaches 3277.0"));
    CHECK(contains(single, "within 3276.8 m of the origin"));
    CHECK(contains(single, "or use precision = \"double\""));
    CHECK(contains(single_refusal(-3277.0), "body 'body 0' reaches"));
    CHECK(box_world({box_at(3277.0)})->count == 64);
    CHECK(contains(refusal({box_at(52428.0)}), "within 52428 m of the origin"));
    CHECK(box_world<float>({"simulation.precision=\"float\"", kBonds, kNoGrid, box_at(3277.0)})->count == 64);
}
