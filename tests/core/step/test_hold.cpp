#include "support/catch.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

/// One grid step of the box, its part below x = 0.2 m held at (1, free, 0); calls check(x, velocity of the node).
template <class Check>
void for_each_node(const char* transfer, const std::string& law, Check check) {
    Overrides overrides{
        std::string("transfer.type=\"") + transfer + '"', "body.0.initial_velocity=[7, 8, 9]",
        R"(condition=[{ velocity = [1, "free", 0], shape = { type = "plane", point = [0.2, 0, 0], normal = [1, 0, 0] } }])"};
    if (!law.empty()) overrides.push_back(law);
    const auto w = box_world(overrides);
    w->dt = 1e-6;
    compute_bond_forces(*w);
    apply_loads(*w, 0, w->dt);
    prescribe_velocities(*w, 0);
    scatter_held(*w);
    scatter(*w);
    update_grid(*w);
    hold_nodes(*w);
    for (std::size_t g = 0; g < w->grid.size(); ++g)
        for (int n = 0; n < kNodesPerBlock; ++n) {
            const double* node = w->grid.nodes(g) + 4 * n;
            if (node[3] > 0) check(0.1 * (4 * w->grid.coordinate(g)[0] + n / 16), Vec3(node[0], node[1], node[2]));
        }
}

}  // namespace

TEST_CASE("hold: nodes in the region and on its border move as prescribed", "[step]") {
    for (const char* transfer : {"apic", "flip", "pic"})
        for (const std::string& law : {std::string(), kBonds}) {
            CAPTURE(transfer, law);
            for_each_node(transfer, law, [](double x, const Vec3& v) {
                CHECK_THAT(v[1], WithinAbs(8, 1e-9));  // free
                if (x < 0.21) CHECK((v - Vec3(1, 8, 0)).norm() < 1e-9);
                // Of the node at 0.3 m, particles at 0.175 m carry (1/4)^2 / 2 = 1/32 of one particle's full column: free
                if (x > 0.29) CHECK(v[0] > 6);
                if (x > 0.39) CHECK((v - Vec3(7, 8, 9)).norm() < 1e-9);
            });
        }
}
