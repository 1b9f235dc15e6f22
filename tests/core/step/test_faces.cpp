#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

std::string domain(const std::string& faces) {
    return "grid.domain={ min = [0, -1, -1], max = [1, 1, 1], faces = { " + faces + " } }";
}
const std::string kNearFace = R"(body.0.shape={ type = "box", min = [0, 0, 0], max = [0.2, 0.4, 0.4] })";

/// Velocity and mass of the node at (i, j, k) dx.
Eigen::Vector4d node_at(World<double>& w, int i, int j, int k) {
    for (std::size_t g = 0; g < w.grid.size(); ++g) {
        const std::int32_t* c = w.grid.coordinate(g);
        const int n[3] = {i - 4 * c[0], j - 4 * c[1], k - 4 * c[2]};
        if (std::min({n[0], n[1], n[2]}) < 0 || std::max({n[0], n[1], n[2]}) > 3) continue;
        return Eigen::Map<const Eigen::Vector4d>(w.grid.nodes(g) + 4 * (16 * n[0] + 4 * n[1] + n[2]));
    }
    return Eigen::Vector4d::Zero();
}

void step_grid(World<double>& w) {
    w.dt = 1e-3;
    scatter(w);
    fold_images(w);
    update_grid(w);
    unfold_images(w);
}

}  // namespace

TEST_CASE("faces: the grid before a mirror moves as that of a body and its mirror image", "[step]") {
    // The whole: the half-body and its image, moving apart at 1 m/s with 2 m/s along the face. Nodes as far as 0.1 m
    // from the plane are touched by both.
    const std::string motion = "body.0.initial_velocity=[1, 2, 0]";
    const std::string twin =
        R"(body=[{ material = "rubber", particle_spacing = 0.05, shape = { type = "box", min = [0, 0, 0], max = [0.2, 0.4, 0.4] }, initial_velocity = [1, 2, 0] },
                 { material = "rubber", particle_spacing = 0.05, shape = { type = "box", min = [-0.2, 0, 0], max = [0, 0.4, 0.4] }, initial_velocity = [-1, 2, 0] }])";
    for (const char* transfer : {"apic", "flip", "pic"})
        for (const char* order : {"1", "2", "3"}) {
            CAPTURE(transfer, order);
            const Overrides common{std::string("transfer.type=\"") + transfer + '"',
                                   std::string("transfer.order=") + order};
            Overrides half = common, whole = common;
            half.insert(
                half.end(),
                {kNearFace, motion,
                 domain(
                     R"(min_x = "symmetry", max_x = "open", min_y = "open", max_y = "open", min_z = "open", max_z = "open")")});
            whole.push_back(twin);
            const auto mirrored = box_world(half), full = box_world(whole);
            step_grid(*mirrored);
            step_grid(*full);
            for (int i = -2; i <= 4; ++i) {
                const Eigen::Vector4d a = node_at(*mirrored, i, 2, 2), b = node_at(*full, i, 2, 2);
                if (b[3] > 0 && (i >= 0 || a[3] > 0)) CHECK((a - b).head<3>().norm() < 1e-12);
                if (i > 0) CHECK(std::abs(a[3] - b[3]) < 1e-12);
            }
        }
}

TEST_CASE("faces: which faces are mirrors, and where", "[step]") {
    const auto images = [](const std::string& overrides) { return find_images(scene_from(kBox, {overrides}).grid); };
    const std::string open = R"(, max_x = "open", min_y = "open", max_y = "open", min_z = "open", max_z = "open")";
    CHECK(images(domain(R"(min_x = "symmetry")" + open)).axis[0].low.mirrors);
    CHECK(images(domain(R"(min_x = "slip")" + open)).axis[0].low.flip == 1);
    CHECK(images(domain(R"(min_x = "sticky")" + open)).axis[0].low.flip == 7);
    CHECK_FALSE(images(domain(R"(min_x = "separate")" + open)).any());
    CHECK_FALSE(images(R"(grid.domain={ min = [0, 0, 0], max = [1, 1, 1], faces = "slip", friction = 0.1 })").any());
    CHECK(images(R"(grid.domain={ min = [0.05, 0, 0], max = [1, 1, 1], faces = "slip" })").axis[0].low.at == 1);
    const Scene off = scene_from(kBox, {R"(grid.domain={ min = [-0.03, -1, -1], max = [1, 1, 1], faces = "slip" })"});
    CHECK_FALSE(find_images(off.grid).axis[0].low.mirrors);
    const std::vector<std::string> messages = inexact_faces(off.grid, find_images(off.grid));
    REQUIRE(messages.size() == 1);
    CHECK(messages[0].find("face min_x (slip)") == 0);
    CHECK(messages[0].find("put it at -0.05 m") != std::string::npos);
}

TEST_CASE("faces: particles wrap around a periodic axis", "[step]") {
    const auto w = box_world({domain(R"(min_x = "periodic", max_x = "periodic")")});
    const double start = w->x[0][0];
    for (const double turns : {3.0, -2.0}) {
        w->x[0][0] = start + turns;
        wrap_particles(*w);
        CHECK_THAT(w->x[0][0], WithinAbs(start, 1e-12));
    }
}
