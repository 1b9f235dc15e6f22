#include "support/catch.hpp"
#include "support/world.hpp"

using namespace perimpm;

TEST_CASE("scatter: the grid holds the particles' mass and momentum, anew each time", "[step]") {
    const std::string fine = "body.0.particle_spacing=0.02";  // more in a block than go together
    for (const Overrides& law : {Overrides{}, Overrides{kBonds}, Overrides{fine}, Overrides{kBonds, fine}})
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

TEST_CASE("scatter: a bond law that writes stress pushes as the local law does", "[step]") {
    const auto local = box_world(), bonds = box_world({kStresses});
    Eigen::Matrix3d F;
    F << 1.02, 0.01, 0, -0.02, 0.99, 0.03, 0, 0.01, 1.01;
    for (World<double>* w : {local.get(), bonds.get()}) {
        Material<double>& m = w->materials[0];
        CHECK((m.force.empty() && m.stress.empty() == !m.has_bonds()));
        for (std::size_t p = 0; p < w->count; ++p) {
            const Vec3 y = F * at(w->x, p);
            for (int c = 0; c < 3; ++c) w->x[static_cast<std::size_t>(c)][p] = y[c];
            for (std::size_t c = 0; !m.F.empty() && c < 9; ++c)
                m.F[c][p] = F(static_cast<int>(c / 3), static_cast<int>(c % 3));
        }
        sort_particles(*w);
        w->dt = 1e-3;
        compute_bond_forces(*w), scatter(*w);
    }
    REQUIRE(local->grid.size() == bonds->grid.size());
    double largest = 0;
    for (std::size_t g = 0; g < local->grid.size(); ++g)
        for (std::size_t k = 0; k < kBlockValues; ++k) {
            largest = std::max(largest, std::abs(local->grid.nodes(g)[k]));
            CHECK_THAT(bonds->grid.nodes(g)[k], WithinAbs(local->grid.nodes(g)[k], 1e-11));
        }
    CHECK(largest > 0.1);
}
