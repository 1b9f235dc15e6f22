#include "support/box_scene.hpp"
#include "support/catch.hpp"
#include "support/scene.hpp"

using namespace perimpm;

namespace {

ConditionSpec only(const std::string& keys) {
    return scene_from(kBox, {"condition=[{ " + keys + " }]"}).conditions.at(0);
}

}  // namespace

TEST_CASE("conditions: each key sets its quantity", "[scene]") {
    CHECK(only("velocity = [1, 2, 3]").value == Vec3(1, 2, 3));
    CHECK(only("clamped = true").drive == Drive::velocity);
    CHECK(only("clamped = true").value == Vec3::Zero());
    CHECK(only("acceleration = [1, 2, 3]").drive == Drive::acceleration);
    CHECK(only("body_force = [1, 2, 3]").drive == Drive::body_force);
    CHECK(only("force = [1, 2, 3]").drive == Drive::force);
    const ConditionSpec c = only(
        R"(name = "pull", velocity = ["free", 2, "free"], body = "body 0", material = "rubber", times = [0, 1], factors = [3, 4])");
    CHECK(c.name == "pull");
    CHECK((c.free[0] && !c.free[1] && c.free[2]));
    CHECK((c.body == 0u && c.material == 0u && !c.shape));
    CHECK((c.times == std::vector<double>{0, 1} && c.factors == std::vector<double>{3, 4}));
}

TEST_CASE("conditions: a function takes the place of a value", "[scene]") {
    const Scene scene = scene_from(kBox, {});
    const Value table = parse_scene_text("body = \"body 0\"", "condition");
    CHECK(read_condition(table, 4, scene, Drive::acceleration).name == "condition 4");
    CHECK(read_condition(table, 4, scene, Drive::acceleration).drive == Drive::acceleration);
}

TEST_CASE("conditions: the resolved scene reads back", "[scene]") {
    const Scene scene = scene_from(
        kBox,
        {R"(condition=[{ clamped = true }, { force = [1, 0, 0], shape = { type = "sphere", center = [0, 0, 0], radius = 1 } }])"});
    const Scene again = read_scene(resolved_scene(scene), ".");
    REQUIRE(again.conditions.size() == 2);
    CHECK(again.conditions[0].name == "condition 0");
    CHECK_FALSE(again.conditions[0].shape);
    CHECK(again.conditions[1].drive == Drive::force);
    CHECK(again.conditions[1].shape);
}
