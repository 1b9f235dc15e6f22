#include <cmath>
#include <limits>

#include "perimpm/error.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

const Vec3 kVelocity(1, -2, 3);

/// A grid whose nodes all move at kVelocity.
std::unique_ptr<World<double>> moving_grid(const Overrides& overrides = {}) {
    auto w = box_world(overrides);
    w->dt = 1e-3;
    scatter(*w);
    w->motion = {.step = 5, .dt = 1e-3};
    for (std::size_t g = 0; g < w->grid.size(); ++g)
        for (int n = 0; n < kNodesPerBlock; ++n)
            for (int c = 0; c < 3; ++c) w->grid.nodes(g)[4 * n + c] = kVelocity[c];
    return w;
}

}  // namespace

TEST_CASE("gather: particles take a uniform velocity and move with it", "[step]") {
    for (const Overrides& law : {Overrides{}, Overrides{kBonds}}) {
        const auto w = moving_grid(law);
        std::vector<Vec3> before;
        for (std::size_t p = 0; p < w->count; ++p) before.push_back(at(w->x, p));
        gather(*w);
        for (std::size_t p = 0; p < w->count; ++p) {
            CHECK((at(w->v, p) - kVelocity).norm() < 1e-12);
            CHECK((at(w->x, p) - before[p] - 1e-3 * kVelocity).norm() < 1e-12);
            for (std::size_t c = 0; c < 9; ++c) CHECK(std::abs(w->C[c][p]) < 1e-9);
        }
        CHECK_THAT(w->gathered_speed, WithinRel(std::sqrt(14.0), 1e-12));
        CHECK_THAT(w->drift, WithinRel(1e-3 * std::sqrt(14.0), 1e-12));
    }
}

TEST_CASE("gather: a velocity that is not finite ends the run", "[step]") {
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        const auto w = moving_grid();
        std::size_t g = 0;
        while (!(w->grid.nodes(g)[4 * 21 + 3] > 0)) ++g;  // a block whose node (1, 1, 1) particles see
        w->grid.nodes(g)[4 * 21] = bad;
        CHECK(contains(message_of<SimulationError>([&] { gather(*w); }), "no longer finite in step 5"));
    }
}

TEST_CASE("gather: rounding that carries a slow particle farther than dt v counts as drift", "[step]") {
    const auto w = box_world<float>({R"(body.0.shape={ type = "box", min = [2.5, 0, 0], max = [2.55, 0.05, 0.05] })"});
    REQUIRE(w->count == 1);
    w->dt = w->motion.dt = 1e-3;
    const float start = w->x[0][0], ulp = std::nextafter(start, 3.0f) - start;
    for (int step = 0; step < 100; ++step) {  // 0.52 ulp of x, which rounds up to a whole one
        scatter(*w);
        for (std::size_t g = 0; g < w->grid.size(); ++g)
            for (int n = 0; n < kNodesPerBlock; ++n) {
                std::fill_n(w->grid.nodes(g) + 4 * n, 3, 0.0f);
                w->grid.nodes(g)[4 * n] = 520 * ulp;
            }
        gather(*w);
    }
    const auto moved = static_cast<double>(w->x[0][0] - start);
    CHECK(moved > 0.9 * 100 * static_cast<double>(ulp));
    CHECK(w->drift >= moved);
}

TEST_CASE("gather: a step after one that failed sorts first and names the particle", "[step]") {
    Simulation simulation(scene_from(kBox), 1);
    simulation.step();
    auto* v = static_cast<double*>(simulation.field("v").data);
    v[7] = std::numeric_limits<double>::quiet_NaN();
    CHECK_FALSE(message_of<SimulationError>([&] { simulation.step(); }).empty());
    CHECK(contains(message_of<SimulationError>([&] { simulation.step(); }), "particle"));
}
