#include "support/catch.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

/// Calls check(place, velocity) for every node with mass after scatter and grid update with dt = 1 ms.
template <class Check>
void for_each_node(const Overrides& overrides, Check check) {
    const auto w = box_world(overrides);
    w->dt = 1e-3;
    scatter(*w);
    update_grid(*w);
    for (std::size_t g = 0; g < w->grid.size(); ++g)
        for (int n = 0; n < kNodesPerBlock; ++n) {
            const double* node = w->grid.nodes(g) + 4 * n;
            const std::int32_t* block = w->grid.coordinate(g);
            if (node[3] > 0)
                check(
                    Vec3(0.1 * (4 * block[0] + n / 16), 0.1 * (4 * block[1] + n / 4 % 4), 0.1 * (4 * block[2] + n % 4)),
                    Vec3(node[0], node[1], node[2]));
        }
}

const std::string kMoving = "body.0.initial_velocity=[1, -2, 3]";
std::string domain(const std::string& faces) {
    return "grid.domain={ min = [-1, 0, -1], max = [1, 1, 1], " + faces + " }";
}

}  // namespace

TEST_CASE("grid update: momentum becomes velocity, gravity adds dt g", "[step]") {
    for (const char* transfer : {"apic", "flip", "pic"})
        for_each_node({kMoving, "simulation.gravity=[0, -10, 5]", std::string("transfer.type=\"") + transfer + '"'},
                      [](const Vec3&, const Vec3& v) { CHECK((v - Vec3(1, -2.01, 3.005)).norm() < 1e-9); });
}

TEST_CASE("grid update: faces stop nodes on and behind them", "[step]") {
    struct Case {
        const char* face;
        Vec3 below;
    };
    // Friction 0.5 on a separate face: the approach of 2 m/s costs 1 m/s of the speed along, sqrt(1 + 9) m/s.
    const double left = 1 - 1 / std::sqrt(10.0);
    const Case cases[] = {{"faces = \"slip\", friction = 0.5", Vec3(left, 0, 3 * left)},
                          {"faces = \"separate\"", Vec3(1, 0, 3)},
                          {"faces = \"separate\", friction = 0.5", Vec3(left, 0, 3 * left)},
                          {"faces = \"open\"", Vec3(1, -2, 3)}};
    for (const Case& c : cases) {
        CAPTURE(c.face);
        for_each_node({kMoving, domain(c.face)}, [&](const Vec3& x, const Vec3& v) {
            CHECK((v - (x[1] < 0.01 ? c.below : Vec3(1, -2, 3))).norm() < 1e-9);
        });
    }
}

TEST_CASE("grid update: nodes inside a collider take what contact leaves of their velocity", "[step]") {
    // The floor rises at 5 m/s and has come 5 mm far: nodes at y = 0 are inside, those at 0.1 m are not.
    for_each_node({kMoving, kRisingFloor},
                  [](const Vec3& x, const Vec3& v) { CHECK((v - Vec3(1, x[1] < 0.01 ? 5 : -2, 3)).norm() < 1e-9); });
}
