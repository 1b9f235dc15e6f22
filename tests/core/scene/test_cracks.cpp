#include "perimpm/error.hpp"
#include "perimpm/scene/scene.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

Scene scene(const std::string& crack) { return scene_from(kBox, {kBonds, "crack=[" + crack + "]"}); }
std::string refusal(const std::string& crack) {
    return message_of([&] { scene(crack); });
}

}  // namespace

TEST_CASE("scene: cracks are rectangles, discs and planes", "[scene]") {
    const Scene s = scene_from(
        kBox,
        {kBonds,
         R"(crack=[{ shape = { type = "rectangle", corner = [0, 0, 0], edge_u = [2, 0, 0], edge_v = [0, 0, 1] } },)"
         R"({ name = "penny", body = "body 0", shape = { type = "disc", center = [0, 1, 0], normal = [0, 2, 0], radius = 0.5 } },)"
         R"({ shape = { type = "plane", point = [0, 0, 3], normal = [0, 0, 1] } }])"});
    REQUIRE(s.cracks.size() == 3);
    CHECK(s.cracks[0].name == "crack 0");
    CHECK(s.cracks[1].name == "penny");
    CHECK(s.cracks[1].body == 0u);
    const Patch& rectangle = s.cracks[0].patch.value();
    CHECK(rectangle.crosses({1, -1, 0.5}, {1, 1, 0.5}));
    CHECK(rectangle.crosses({1, 1, 0.5}, {1, -1, 0.5}));
    CHECK(rectangle.crosses({0, -1, 0.5}, {2, 1, 0.5}));
    CHECK_FALSE(rectangle.crosses({3, -1, 0.5}, {3, 1, 0.5}));
    CHECK_FALSE(rectangle.crosses({1, -1, 1.5}, {1, 1, 1.5}));
    CHECK_FALSE(rectangle.crosses({1, 0.5, 0.5}, {1, 1, 0.5}));
    const Patch& disc = s.cracks[1].patch.value();
    CHECK(disc.crosses({0.3, 0, 0.3}, {0.3, 2, 0.3}));
    CHECK_FALSE(disc.crosses({0.4, 0, 0.4}, {0.4, 2, 0.4}));
    CHECK(s.cracks[2].patch.value().crosses({100, 0, 2}, {100, 0, 4}));
}

TEST_CASE("scene: a point on a crack counts to one side only", "[scene]") {
    const Patch plane{.origin = Vec3::Zero(), .normal = Vec3::UnitX()};
    CHECK(plane.crosses({-1, 0, 0}, {0, 0, 0}));
    CHECK_FALSE(plane.crosses({1, 0, 0}, {0, 0, 0}));
}

TEST_CASE("scene: cracks that make no sense are refused", "[scene]") {
    CHECK(contains(refusal(R"({ shape = { type = "disk", center = [0, 0, 0], normal = [0, 1, 0], radius = 1 } })"),
                   "did you mean 'disc'?"));
    CHECK(contains(refusal(R"({ shape = { type = "disc", center = [0, 0, 0], normal = [0, 0, 0], radius = 1 } })"),
                   "'normal'"));
    CHECK(contains(
        refusal(R"({ shape = { type = "rectangle", corner = [0, 0, 0], edge_u = [1, 0, 0], edge_v = [1, 1, 0] } })"),
        "right angles"));
    CHECK(contains(refusal(R"({ body = "bod", shape = { type = "plane", point = [0, 0, 0], normal = [0, 1, 0] } })"),
                   "body 0"));
    CHECK(contains(refusal(R"({ })"), "missing key 'shape'"));
    CHECK(contains(refusal(R"({ shape = { type = "mesh", file = "no.obj" } })"),
                   "names 'no.obj', but there is no such file"));
}
