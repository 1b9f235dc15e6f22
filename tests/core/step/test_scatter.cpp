#include "support/catch.hpp"
#include "support/world.hpp"

using namespace perimpm;

TEST_CASE("scatter: the grid holds the particles' mass and momentum, anew each time", "[step]") {
    for (const Overrides& law : {Overrides{}, Overrides{kBonds}})
        for (const char* transfer : {"apic", "flip", "pic"}) {
            CAPTURE(law.size(), transfer);
            Overrides overrides = law;
            overrides.insert(overrides.end(),
                             {"body.0.initial_velocity=[1, -2, 3]", std::string("transfer.type=\"") + transfer + '"'});
            const auto w = box_world(overrides);
            w->dt = 1e-3;
            for (int again = 0; again < 2; ++again) {
                scatter(*w);
                CHECK((node_sums(*w) - 64 * Eigen::Vector4d(1, -2, 3, 1)).norm() < 1e-9);
            }
        }
}

TEST_CASE("scatter: stress pushes momentum apart without making any", "[step]") {
    const auto w = box_world();
    for (std::size_t p = 0; p < w->count; ++p) w->materials[0].F[0][p] = 0.9;
    w->dt = 1e-3;
    scatter(*w);
    CHECK(node_sums(*w).head<3>().norm() < 1e-9);
    // tau_xx = 2 mu (F - 1) F + lambda J (J - 1) = -(8e4 + 4e4) 0.09 Pa everywhere; momentum along x through the middle
    // is dt times the force on half the cube, its weak form: sum over nodes of v_I x_I = dt integral tau_xx.
    double virial = 0;
    for (std::size_t g = 0; g < w->grid.size(); ++g)
        for (int n = 0; n < kNodesPerBlock; ++n)
            virial += w->grid.nodes(g)[4 * n] * 0.1 * (4 * w->grid.coordinate(g)[0] + n / 16);
    CHECK_THAT(virial, WithinRel(1e-3 * 0.064 * 12e4 * 0.09, 1e-9));
}
