#include "support/catch.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

/// Override with one condition on the whole box or on a region.
std::string condition(const std::string& keys) { return "condition=[{ " + keys + " }]"; }
const std::string kLowHalf = R"(shape = { type = "box", min = [-1, -1, -1], max = [0.2, 1, 1] })";

}  // namespace

TEST_CASE("conditions: a region's particles are those inside its shape, body and material", "[step]") {
    const std::string two =
        R"(body=[{ material = "rubber", particle_spacing = 0.05, shape = { type = "box", min = [0, 0, 0], max = [0.4, 0.4, 0.4] } },
                 { material = "rubber", particle_spacing = 0.05, shape = { type = "box", min = [0, 1, 0], max = [0.4, 1.4, 0.4] } }])";
    const auto count = [&](const std::string& keys) {
        return box_world({two, condition("clamped = true, " + keys)})->conditions.list[0].id.size();
    };
    CHECK(count(kLowHalf) == 256);  // the other body lies above y = 1
    CHECK(count(R"(body = "body 1")") == 512);
    CHECK(count(R"(material = "rubber")") == 1024);
    CHECK(count(R"(body = "body 0", )" + kLowHalf) == 256);
}

TEST_CASE("conditions: loads are shared out by mass, volume or region", "[step]") {
    // 512 particles of (0.05 m)^3 and 0.125 kg: a force per volume f gives f / density, a total force F gives F / 64 kg.
    struct Case {
        const char* keys;
        double acceleration;
    };
    for (const Case& c :
         {Case{"acceleration = [3, 0, 0]", 3.0}, Case{"body_force = [3e3, 0, 0]", 3.0},
          Case{"force = [192, 0, 0]", 3.0}, Case{"acceleration = [3, 0, 0], times = [1, 2], factors = [0, 4]", 6.0}}) {
        CAPTURE(c.keys);
        const auto w = box_world({condition(c.keys)});
        apply_loads(*w, 1.5, 0.1);
        for (std::size_t p = 0; p < w->count; ++p) CHECK_THAT(w->v[0][p], WithinRel(0.1 * c.acceleration, 1e-12));
    }
}

TEST_CASE("conditions: factors are constant before the first time and after the last", "[step]") {
    const auto w = box_world({condition("velocity = [1, 0, 0], times = [1, 2, 4], factors = [2, 4, 0]")});
    for (const auto& [t, v] :
         {std::pair(0.0, 2.0), {1.0, 2.0}, {1.5, 3.0}, {2.0, 4.0}, {3.0, 2.0}, {4.0, 0.0}, {9.0, 0.0}}) {
        prescribe_velocities(*w, t);
        CHECK_THAT(w->v[0][7], WithinAbs(v, 1e-12));
    }
}

TEST_CASE("conditions: free components stay as they are, later conditions win", "[step]") {
    const auto w = box_world(
        {"body.0.initial_velocity=[7, 8, 9]",
         R"(condition=[{ velocity = [1, "free", 2] }, { velocity = ["free", "free", 5], )" + kLowHalf + " }]"});
    w->dt = 0.01;
    apply_loads(*w, 0, w->dt);
    prescribe_velocities(*w, 0);
    for (std::size_t p = 0; p < w->count; ++p) {
        CHECK(at(w->v, p) == Vec3(1, 8, w->x[0][p] < 0.2 ? 5 : 2));
        w->v[0][p] = 100, w->x[0][p] += 10;  // as if a grid had moved them
    }
    const Vec3 before = at(w->x, 3);
    move_held_particles(*w);
    CHECK_THAT(w->x[0][3] - before[0], WithinAbs(-10 + 0.01, 1e-12));
    CHECK(w->v[0][3] == 1);
}

TEST_CASE("conditions: a function sees positions at the start and the time", "[step]") {
    const auto w = box_world();
    ConditionSpec spec{.name = "driven", .shape = {}, .body = {}, .material = {}, .source = {}};
    add_condition(*w, spec, [](double t, std::size_t n, const double* X, double* values) {
        for (std::size_t i = 0; i < n; ++i)
            values[3 * i] = X[3 * i] * t, values[3 * i + 1] = std::nan(""), values[3 * i + 2] = 0;
    });
    const double x = w->x[0][5];
    w->x[0][5] = 0.33;
    w->v[1][5] = 4;
    prescribe_velocities(*w, 2);
    CHECK(at(w->v, 5) == Vec3(2 * x, 4, 0));
}
