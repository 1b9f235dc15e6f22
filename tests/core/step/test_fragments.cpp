// kBox cut in two, and beside another body.
#include <set>

#include "support/catch.hpp"
#include "support/world.hpp"

using namespace perimpm;

TEST_CASE("fragments: a body is one piece until its bonds break", "[step]") {
    CHECK(list_fragments(*box_world()).size() == 1);
    CHECK(list_fragments(*box_world({kBonds})).size() == 1);
    CHECK(list_fragments(*box_world({kBonds, kNeverBreaks})).size() == 1);
}

TEST_CASE("fragments: pieces have their mass, centre and velocity, and are named by their least particle", "[step]") {
    const auto w = box_world({kBonds, kCrack});
    for (std::size_t p = 0; p < w->count; ++p) w->v[1][p] = w->x[1][p] > 0.2 ? 2 : -1;
    const std::vector<Fragment> list = list_fragments(*w);
    REQUIRE(list.size() == 2);
    CHECK(list[0].id < list[1].id);
    std::uint32_t least[2] = {~0u, ~0u};
    for (std::size_t p = 0; p < w->count; ++p) {
        std::uint32_t& id = least[w->x[1][p] > 0.2];
        id = std::min(id, w->id[p]);
    }
    for (const Fragment& f : list) {
        const bool upper = f.center[1] > 0.2;
        CHECK(f.id == least[upper]);
        CHECK(f.particles == 256);
        CHECK_THAT(f.mass, WithinRel(32.0, 1e-12));
        CHECK_THAT(f.center[0], WithinRel(0.2, 1e-12));
        CHECK_THAT(f.center[1], WithinRel(upper ? 0.3 : 0.1, 1e-12));
        CHECK_THAT(f.velocity[1], WithinRel(upper ? 2.0 : -1.0, 1e-12));
    }
}

TEST_CASE("fragments: labels are those of the pieces, bodies of local laws included", "[step]") {
    const auto w = box_world(
        {kCrack, R"(material.glass={ density = 1000, constitutive = { type = "pd_bond", youngs_modulus = 1e5 } })",
         R"(body=[{ material = "glass", particle_spacing = 0.1, shape = { type = "box", min = [1, 0, 0], max = [1.4, 0.4, 0.4] } },)"
         R"({ material = "rubber", particle_spacing = 0.1, shape = { type = "box", min = [0, 0, 0], max = [0.2, 0.2, 0.2] } }])"});
    const std::vector<std::uint32_t> label = label_fragments(*w);
    std::set<std::uint32_t> glass, rubber;
    for (std::size_t p = 0; p < w->count; ++p) (w->x[0][p] > 0.9 ? glass : rubber).insert(label[p]);
    CHECK(glass.size() == 2);
    CHECK(rubber == std::set<std::uint32_t>{64});  // ids go by body
}
