// kBox: c = sqrt((lambda + 2 mu)/rho) = sqrt(120) m/s, dx = 0.1 m.
#include <fmt/format.h>

#include <cmath>

#include "perimpm/error.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

const double kWaveSpeed = std::sqrt(120.0);
constexpr double kForever = 1e9;

double grid_bound(const World<double>& w, double speed) {
    return w.transfer_needs.courant * 0.1 / (kWaveSpeed + speed);
}

}  // namespace

TEST_CASE("time step: auto takes its share of the grid's bound", "[step]") {
    const auto w = box_world({"body.0.initial_velocity=[0, 3, 4]", "simulation.safety=0.5"});
    CHECK_THAT(time_step_bound(*w, w->wave_speed), WithinRel(grid_bound(*w, 5), 1e-12));
    CHECK_THAT(choose_time_step(*w, kForever), WithinRel(0.5 * grid_bound(*w, 5), 1e-12));
    CHECK(choose_time_step(*w, 1e-6) == 1e-6);
}

TEST_CASE("time step: equal steps fill the time to the next frame", "[step]") {
    const auto w = box_world();
    const double longest = choose_time_step(*w, kForever);
    CHECK_THAT(choose_time_step(*w, 2.5 * longest), WithinRel(2.5 * longest / 3, 1e-12));
    CHECK_THAT(choose_time_step(*w, 2 * longest), WithinRel(longest, 1e-12));
    const auto fixed = box_world({"simulation.dt=1e-4"});
    CHECK_THAT(choose_time_step(*fixed, 1.5e-4), WithinRel(0.75e-4, 1e-12));
}

TEST_CASE("time step: the faster of particles and colliders counts", "[step]") {
    CHECK(fastest_motion(*box_world({kRisingFloor, "body.0.initial_velocity=[0, 3, 0]"})) == 5);
    CHECK(fastest_motion(*box_world({kRisingFloor, "body.0.initial_velocity=[0, 7, 0]"})) == 7);
    const auto w = box_world({kRisingFloor});
    CHECK_THAT(time_step_bound(*w, w->wave_speed), WithinRel(grid_bound(*w, 5), 1e-12));
}

TEST_CASE("time step: without a grid it is what the laws' bonds allow, less the farther they are stretched", "[step]") {
    const auto w = box_world({kBonds, kNoGrid, "simulation.safety=1"});
    Material<double>& m = w->materials[0];
    const StableStep law = m.law->stable_step(make_block(*w, m, 0, m.size));
    CHECK(law.any_stretch < 0.7 * law.small_strains);
    CHECK(choose_time_step(*w, kForever) == law.small_strains);
    for (std::size_t p = 0; p < w->count; ++p) w->x[1][p] *= 1.25;
    accept_positions(*w);
    CHECK_THAT(w->extension, WithinRel(0.2, 1e-12));
    const double squared = 0.8 / std::pow(law.small_strains, 2) + 0.2 / std::pow(law.any_stretch, 2);
    CHECK_THAT(time_step_bound(*w, 12345.0), WithinRel(1 / std::sqrt(squared), 1e-12));
    const double before = w->extension;
    w->extension = 0;
    compute_bond_forces(*w);
    CHECK_THAT(w->extension, WithinRel(before, 1e-12));
    w->extension = 0.3;  // bonds that have been farther apart
    compute_bond_forces(*w);
    CHECK(w->extension == 0.3);
}

TEST_CASE(
    "time step: where a criterion watches bonds without a grid, and on the way to equilibrium, any stretch counts",
    "[step]") {
    const auto free = box_world({kBonds, kNoGrid}), watched = box_world({kBonds, kNeverBreaks, kNoGrid});
    Material<double>& m = free->materials[0];
    const double any = m.law->stable_step(make_block(*free, m, 0, m.size)).any_stretch;
    CHECK(time_step_bound(*free, 0.0) > 1.4 * any);
    CHECK_THAT(time_step_bound(*watched, 0.0), WithinRel(any, 1e-12));
    free->relaxing = true;
    CHECK_THAT(time_step_bound(*free, 0.0), WithinRel(any, 1e-12));
}

TEST_CASE("time step: a fixed one that bonds have outgrown says how far they are stretched, and gives way in relax",
          "[step]") {
    const auto probe = box_world({kBonds, kNoGrid});
    const double dt = 0.95 * time_step_bound(*probe, 0.0);
    const auto w = box_world({kBonds, kNoGrid, fmt::format("simulation.dt={:.17g}", dt)});
    CHECK(choose_time_step(*w, kForever) == dt);
    w->relaxing = true;
    CHECK(choose_time_step(*w, kForever) < 0.7 * dt);
    w->relaxing = false, w->steps = 3, w->extension = 0.2;
    CHECK(contains(message_of<SimulationError>([&] { choose_time_step(*w, kForever); }),
                   "bonds, stretched by up to 25 %; "));
}

TEST_CASE("time step: a fixed one above the bound is refused at its place, unless it is allowed", "[step]") {
    const auto w = box_world({"simulation.dt=1e-4"});
    CHECK(choose_time_step(*w, kForever) == 1e-4);
    CHECK(choose_time_step(*w, 1e-5) == 1e-5);
    const std::string message = message_of([] { box_world({"simulation.dt=0.1"}); });
    CHECK(contains(message, "dt = 0.1 s is above the stable step"));
    CHECK(contains(message, "simulation.dt"));
    CHECK(choose_time_step(*box_world({"simulation.dt=0.1", "simulation.allow_unstable_dt=true"}), kForever) == 0.1);
    w->steps = 7, w->wave_speed = 1e6;  // the run itself made it unstable
    CHECK(contains(message_of<SimulationError>([&] { choose_time_step(*w, kForever); }), "step 8: dt = 0.0001 s"));
}

TEST_CASE("time step: no bound at all asks for a step", "[step]") {
    CHECK(contains(message_of([] { box_world({kBonds, kNoGrid, kPoint}); }), "give dt in seconds"));
    CHECK(choose_time_step(*box_world({kBonds, kNoGrid, kPoint, "simulation.dt=0.01"}), kForever) == 0.01);
}

TEST_CASE("time step: the wave speed is measured anew every tenth step", "[step]") {
    const auto w = box_world();
    for (std::uint64_t steps = 1; steps <= 20; ++steps) {
        w->wave_speed = 1, w->steps = steps;
        choose_time_step(*w, kForever);
        CHECK_THAT(w->wave_speed, WithinRel(steps % 10 == 0 ? kWaveSpeed : 1.0, 1e-12));
    }
}
