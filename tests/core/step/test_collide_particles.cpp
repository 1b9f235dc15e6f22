#include "support/catch.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

/// One particle 5 mm below the floor, after contact within a step of 1 ms.
std::unique_ptr<World<double>> sunken(const Overrides& more) {
    Overrides overrides{kPoint, kFloor, "simulation.dt=1e-3", "body.0.initial_velocity=[1, -2, 3]"};
    overrides.insert(overrides.end(), more.begin(), more.end());
    auto w = box_world(overrides);
    w->x[1][0] = -0.005;
    w->motion.dt = 1e-3;
    collide_particles(*w);
    return w;
}

}  // namespace

TEST_CASE("collide particles: a particle inside loses its approach", "[step]") {
    for (const char* transfer : {"apic", "pic", "flip"}) {
        CAPTURE(transfer);
        const auto w = sunken({std::string("transfer.type=\"") + transfer + '"'});
        CHECK((at(w->v, 0) - Vec3(1, 0, 3)).norm() < 1e-12);
        // Whoever moves with its own velocity has moved by then: the change of 2 m/s moves it back.
        const double moved = std::string(transfer) == "flip" ? 0 : 2e-3;
        CHECK_THAT(w->x[1][0], WithinAbs(-0.005 + moved, 1e-15));
        CHECK_THAT(w->drift, WithinAbs(2e-3, 1e-15));
    }
    const auto w = sunken({kBonds, kNoGrid});  // moves after contact
    CHECK((at(w->v, 0) - Vec3(1, 0, 3)).norm() < 1e-12);
    CHECK(w->x[1][0] == -0.005);
}

TEST_CASE("collide particles: one that leaves, or is outside, is let alone", "[step]") {
    const auto leaving = sunken({"body.0.initial_velocity=[1, 2, 3]"});
    CHECK(at(leaving->v, 0) == Vec3(1, 2, 3));
    const auto above = sunken({});
    above->x[1][0] = 0.005, above->v[1][0] = -2;
    collide_particles(*above);
    CHECK(at(above->v, 0) == Vec3(1, -2, 3));
    CHECK(above->x[1][0] == 0.005);
}
