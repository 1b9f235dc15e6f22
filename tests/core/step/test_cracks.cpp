// kBox cut in two: halves of 4 x 8 x 8 particles at h = 0.05 m.
#include "perimpm/error.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/world.hpp"

using namespace perimpm;

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

TEST_CASE("cracks: one that crosses nothing is an error", "[step]") {
    const std::string away =
        R"(crack=[{ shape = { type = "disc", center = [5, 0, 0], normal = [1, 0, 0], radius = 1 } }])";
    CHECK(contains(message_of([&] { box_world({kBonds, away}); }), "crack 0 crosses no bond"));
    CHECK(contains(message_of([&] { box_world({kCrack}); }), "crack 0 crosses no bond"));  // a local law
}
