#include "perimpm/error.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

/// A stand-in for the step: every particle is drawn to x = 1 m by a spring of rate w^2 = 100 / s^2, per mass.
void swing(World<double>& w) {
    w.dt = 1e-3;
    for (std::size_t p = 0; p < w.count; ++p) {
        w.v[0][p] += w.dt * 100 * (1 - w.x[0][p]);
        w.x[0][p] += w.dt * w.v[0][p];
    }
    w.time += w.dt;
}

}  // namespace

TEST_CASE("relax: ends where forces balance, at rest, at the same time", "[step]") {
    const auto w = box_world({kPoint, "body.0.initial_velocity=[3, 0, 0]"});
    const Relaxation found = relax<double>(*w, 1e-6, 100000, [&] { swing(*w); });
    CHECK(found.residual <= 1e-6);
    // 100 / s^2 times what is left of the way is the acceleration; the first one is the largest: at 0.025 m.
    CHECK(std::abs(1 - w->x[0][0]) < 1e-6 * 0.975);
    CHECK(at(w->v, 0).norm() == 0);
    CHECK(w->time == 0);
    CHECK_FALSE(w->relaxing);
    // Half a swing to each maximum of the energy is a quarter of a period: pi / 2 / 10 per s = 157 steps.
    CHECK(found.steps < 3000);
}

TEST_CASE("relax: too few steps are an error that says how far it came", "[step]") {
    const auto w = box_world({kPoint});
    CHECK_THROWS_AS(relax<double>(*w, 1e-6, 100, [&] { swing(*w); }), SimulationError);
    CHECK_FALSE(w->relaxing);
}
