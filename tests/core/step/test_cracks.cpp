// kBox cut in two: halves of 4 x 8 x 8 particles at h = 0.05 m.
#include <fmt/format.h>

#include <fstream>
#include <numbers>
#include <set>

#include "core/geometry/mesh_files.hpp"
#include "perimpm/error.hpp"
#include "support/catch.hpp"
#include "support/environment.hpp"
#include "support/message.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

/// A scene's crack along the triangles of `obj`, whose file stays as long as this.
struct MeshCrack {
    TemporaryFolder folder;
    std::string override_text;

    explicit MeshCrack(const std::string& obj) {
        const std::filesystem::path file = folder.path / "crack.obj";
        std::ofstream(file) << obj;
        override_text = fmt::format("crack=[{{ shape = {{ type = \"mesh\", file = \"{}\" }} }}]", file.string());
    }
};

}  // namespace

TEST_CASE("cracks: bonds that cross are broken, both ways, and no others", "[step]") {
    const auto w = box_world({kBonds, kCrack});
    const Material<double>& m = w->materials[0];
    std::size_t broken = 0;
    for (std::uint32_t p = 0; p < m.size; ++p)
        for (std::uint32_t slot = m.bonds.row[p]; slot < m.bonds.row[p + 1]; ++slot) {
            const bool above = m.reference[4 * p + 1] > 0.2, other = m.reference[4 * m.bonds.neighbour[slot] + 1] > 0.2;
            CHECK(m.bonds.is_broken(slot) == (above != other));
            broken += above != other;
        }
    REQUIRE(broken > 0);
    std::size_t counted = 0;
    for (std::uint32_t p = 0; p < m.size; ++p) {
        counted += m.bonds.damage[p];
        CHECK_THAT(m.bonds.share[p], WithinRel(static_cast<float>(m.bonds.damage[p]) /
                                                   static_cast<float>(m.bonds.row[p + 1] - m.bonds.row[p]),
                                               1e-6f));
    }
    CHECK(counted == broken);
}

TEST_CASE("cracks: a scene without cracks and criterion has no flags", "[step]") {
    const auto w = box_world({kBonds});
    CHECK(w->materials[0].bonds.broken.empty());
    CHECK(w->materials[0].bonds.damage.empty());
    CHECK_FALSE(w->has_crack_surfaces);
}

TEST_CASE("cracks: reference quantities are those of the cut families", "[step]") {
    // Averaging needs K of the live bonds: a half's particle at the cut has the K of a free surface.
    const Overrides law = {R"(material.rubber.constitutive={ type = "pd_elastic", youngs_modulus = 1e5 })"};
    Overrides cut = law;
    cut.push_back(kCrack);
    const auto whole = box_world(law), halves = box_world(cut);
    const auto stiffness = [](World<double>& w, double y) {
        for (std::size_t p = 0; p < w.count; ++p)
            if ((at(w.x, p) - Vec3(0.175, y, 0.175)).norm() < 1e-9)
                for (const auto& s : w.materials[0].particle_state)
                    if (std::string(s.spec.name) == "shape_inverse") return s.values[3][p];
        return 0.0;
    };
    const double surface = stiffness(*whole, 0.025);
    REQUIRE(surface > 1.2 * stiffness(*whole, 0.175));
    CHECK_THAT(stiffness(*halves, 0.175), WithinRel(surface, 1e-9));
    CHECK_THAT(stiffness(*halves, 0.225), WithinRel(surface, 1e-9));
}

TEST_CASE("cracks: two triangles cut what their rectangle cuts", "[step]") {
    // Between two layers of particles, part of the way; oblique, with all its edges within the box.
    const struct {
        Vec3 corner, u, v;
    } rectangles[] = {{{-1, 0.2, -1}, {1.13, 0, 0}, {0, 0, 2}},
                      {{0.31, 0.01, 0.02}, {0.186, 0.102, 0}, {-0.17, 0.31, 0.11}}};
    for (const auto& [corner, u, v] : rectangles) {
        const auto numbers = [](const Vec3& x) { return fmt::format("[{}, {}, {}]", x[0], x[1], x[2]); };
        const MeshCrack crack(
            mesh_files::obj_text({{corner, corner + u, corner + u + v, corner + v}, {{0, 1, 2}, {0, 2, 3}}}));
        const auto flat =
            box_world({kBonds, fmt::format("crack=[{{ shape = {{ type = \"rectangle\", corner = {}, edge_u = "
                                           "{}, edge_v = {} }} }}]",
                                           numbers(corner), numbers(u), numbers(v))});
        const auto meshed = box_world({kBonds, crack.override_text});
        const Bonds &one = flat->materials[0].bonds, &other = meshed->materials[0].bonds;
        std::size_t broken = 0;
        for (std::uint32_t slot = 0; slot < one.size(); ++slot) {
            CHECK(one.is_broken(slot) == other.is_broken(slot));
            broken += one.is_broken(slot);
        }
        CHECK(broken > 20);
    }
}

TEST_CASE("cracks: a dome cuts a ball's half out of a block", "[step]") {
    // Half a ball of radius 0.12 m, between two shells of particles, about the middle of the block's lower side, in flat pieces.
    constexpr int kRings = 12, kSectors = 24;
    mesh_files::Mesh dome;
    for (int ring = 0; ring <= kRings; ++ring)
        for (int sector = 0; sector < kSectors; ++sector) {
            const double down = std::numbers::pi / 2 * 1.1 * ring / kRings,
                         round = 2 * std::numbers::pi * sector / kSectors;
            dome.points.emplace_back(0.2 + 0.12 * std::sin(down) * std::cos(round), 0.12 * std::cos(down),
                                     0.2 + 0.12 * std::sin(down) * std::sin(round));
            const int next = (sector + 1) % kSectors, at = ring * kSectors;
            if (ring == kRings) continue;
            if (ring > 0) dome.triangles.push_back({at + sector, at + next, at + kSectors + sector});
            dome.triangles.push_back({at + next, at + kSectors + next, at + kSectors + sector});
        }
    const MeshCrack crack(mesh_files::obj_text(dome));
    const auto w = box_world({kBonds, crack.override_text});
    const auto label = label_fragments(*w);
    CHECK(std::set<std::uint32_t>(label.begin(), label.end()).size() == 2);
    std::set<std::uint32_t> inside, outside;
    for (std::size_t p = 0; p < w->count; ++p)
        ((at(w->x, p) - Vec3(0.2, 0, 0.2)).norm() < 0.12 ? inside : outside).insert(label[p]);
    CHECK(inside.size() == 1);
    CHECK(outside.size() == 1);
}

TEST_CASE("cracks: a mesh without triangles is an error that names it", "[step]") {
    const MeshCrack crack("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    CHECK(contains(message_of([&] { box_world({kBonds, crack.override_text}); }), "crack.obj"));
}

TEST_CASE("cracks: one that crosses nothing is an error", "[step]") {
    const std::string away =
        R"(crack=[{ shape = { type = "disc", center = [5, 0, 0], normal = [1, 0, 0], radius = 1 } }])";
    CHECK(contains(message_of([&] { box_world({kBonds, away}); }), "crack 0 crosses no bond"));
    CHECK(contains(message_of([&] { box_world({kCrack}); }), "crack 0 crosses no bond"));  // a local law
}
