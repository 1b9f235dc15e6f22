#include <limits>

#include "perimpm/error.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

std::unique_ptr<World<double>> point(const Overrides& more = {}) {
    Overrides overrides{kBonds, kNoGrid, kPoint, "simulation.dt=0.01"};
    overrides.insert(overrides.end(), more.begin(), more.end());
    auto w = box_world(overrides);
    w->dt = 0.01;  // steps as no frame shortens them
    return w;
}

void step(World<double>& w) {
    integrate_particles(w);
    w.time += w.dt, ++w.steps;
}

}  // namespace

TEST_CASE("integrate particles: free fall is exact", "[step]") {
    const auto w = point({"simulation.gravity=[0, -10, 0]", "body.0.initial_velocity=[1, 2, 0]"});
    for (int n = 0; n < 50; ++n) step(*w);
    CHECK((at(w->v, 0) - Vec3(1, 2 - 10 * 0.5, 0)).norm() < 1e-12);
    CHECK((at(w->x, 0) - Vec3(0.025 + 0.5, 0.025 + 1 - 5 * 0.25, 0.025)).norm() < 1e-12);
}

TEST_CASE("integrate particles: forces of the step before are kept", "[step]") {
    const auto w = box_world({kBonds, kNoGrid});
    const auto calls = [&] {
        std::uint64_t count = 0;
        for (const PassTime& pass : w->timer.passes())
            if (pass.name == "bond forces") count = pass.calls;
        return count;
    };
    step(*w);
    CHECK(calls() == 2);
    step(*w);
    CHECK(calls() == 3);
    w->forces_known = false;
    step(*w);
    CHECK(calls() == 5);
}

TEST_CASE("integrate particles: positions and velocities that are not finite end the run, bonds or not", "[step]") {
    constexpr double kBad[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                               -std::numeric_limits<double>::infinity()};
    for (const double bad : kBad)
        for (std::size_t c = 0; c < 3; ++c)
            for (const bool speed : {false, true})
                for (const bool bonds : {false, true}) {
                    CAPTURE(bad, c, speed, bonds);
                    const auto w = bonds ? box_world({kBonds, kNoGrid}) : point();
                    step(*w);
                    (speed ? w->v : w->x)[c][0] = bad;
                    CHECK(contains(message_of<SimulationError>([&] { step(*w); }),
                                   "positions or velocities of material 'rubber' are no longer finite in step 2"));
                }
}
