#include <fstream>
#include <limits>

#include "perimpm/scene/tree.hpp"
#include "support/catch.hpp"
#include "support/environment.hpp"
#include "support/message.hpp"

using namespace perimpm;

namespace {

const char* const kText = R"(zeta = 1
[material.steel]
density = 7800.0
constitutive = { type = "law", list = [1, 2.5] }
[alpha]
flag = true
[[body]]
name = "a"
[[body]]
name = "b"
)";

std::string parse_error(const std::string& text) {
    return message_of([&] { parse_scene_text(text, "s.toml"); });
}

}  // namespace

TEST_CASE("tree: every value knows the line, column and dotted path of its key", "[scene]") {
    const Value scene = parse_scene_text(kText, "s.toml");
    const Value& steel = *scene.find("material")->find("steel");
    CHECK(scene.place.text() == "s.toml");
    CHECK(steel.place.text() == "s.toml:2:11");
    CHECK(steel.find("density")->place.text() == "s.toml:3:1");
    const Value& law = *steel.find("constitutive");
    CHECK(law.find("list")->place.text() == "s.toml:4:32");  // counted in kText
    CHECK(law.find("list")->place.path == "material.steel.constitutive.list");
    const auto& list = std::get<Value::List>(law.find("list")->data);
    CHECK(list[1].place.text() == "s.toml:4:43");
    CHECK(list[1].place.path == "material.steel.constitutive.list.1");
    const auto& bodies = std::get<Value::List>(scene.find("body")->data);
    CHECK(bodies[1].place.text() == "s.toml:9:1");
    CHECK(bodies[1].find("name")->place.path == "body.1.name");
}

TEST_CASE("tree: tables keep the order of appearance", "[scene]") {
    const Value scene = parse_scene_text(kText, "s.toml");
    std::string order;
    for (const auto& [key, value] : std::get<Value::Table>(scene.data)) order += key + " ";
    CHECK(order == "zeta material alpha body ");
}

TEST_CASE("tree: integers and numbers stay apart", "[scene]") {
    const Value scene = parse_scene_text("a = 1\nb = 1.0\nc = 9007199254740993", "s");
    CHECK(std::get<std::int64_t>(scene.find("a")->data) == 1);
    CHECK(std::get<double>(scene.find("b")->data) == 1.0);
    CHECK(std::get<std::int64_t>(scene.find("c")->data) == 9007199254740993);
    CHECK(scene.find("a")->kind() == "an integer");
    CHECK(scene.find("b")->kind() == "a number");
    CHECK(scene.find("d") == nullptr);
    CHECK(scene.find("a")->find("x") == nullptr);
}

TEST_CASE("tree: what TOML refuses is reported with its position", "[scene]") {
    CHECK(contains(parse_error("a = 1\na = 2"), "s.toml:2:"));
    CHECK(contains(parse_error("a = 1\nb = stiff"), "s.toml:2:5: error: "));
    CHECK(contains(parse_error("[grid\n"), "s.toml:1:"));
    CHECK(parse_error("a = 1979-05-27") ==
          "s.toml:1:1: error: dates and times have no use in a scene; a text needs quotes");
}

TEST_CASE("tree: a file that is not there or not a file is an error", "[scene]") {
    const TemporaryFolder folder;
    const std::string missing = folder.path / "missing.toml";
    CHECK(contains(message_of([&] { parse_scene_file(missing); }), missing + ": error: there is no such scene"));
    CHECK(contains(message_of([&] { parse_scene_file(folder.path); }), "this is a folder"));
    std::ofstream{missing} << "a = 1\n\nb = 2";
    CHECK(parse_scene_file(missing).find("b")->place.text() == missing + ":3:1");
}

TEST_CASE("tree: TOML text reads back as the same tree", "[scene]") {
    const Value scene = parse_scene_text(kText, "s.toml");
    CHECK(scene.find("material")->to_toml() ==
          R"({ steel = { density = 7800.0, constitutive = { type = "law", list = [1, 2.5] } } })");
    const Value odd =
        parse_scene_text("v = [\"q\\\"\\\\ \\u00e9\\n\", 1e300, -0.1, { \"a b\" = {}, \"\" = [] }, true]", "s");
    const std::string text = odd.find("v")->to_toml();
    CHECK(parse_scene_text("v = " + text, "s").find("v")->to_toml() == text);
    CHECK(contains(text, R"({ "a b" = {}, "" = [] })"));
}

TEST_CASE("tree: JSON text, which has no NaN", "[scene]") {
    CHECK(parse_scene_text(kText, "s").find("body")->to_json() == R"([{"name": "a"}, {"name": "b"}])");
    CHECK(Value{}.to_json() == "null");
    Value bad{std::numeric_limits<double>::quiet_NaN(), {}};
    bad.place.path = "grid.spacing";
    CHECK(message_of([&] { bad.to_json(); }) == "grid.spacing: error: JSON has no NaN and no infinity");
    CHECK(bad.to_toml() == "nan");
}

TEST_CASE("tree: a tree without a file takes dotted paths as places", "[scene]") {
    Value tree{Value::Table{{"body", {Value::List{{Value::Table{{"seed", {std::int64_t{1}, {}}}}, {}}}, {}}}}, {}};
    set_path(tree, "");
    CHECK(std::get<Value::List>(tree.find("body")->data)[0].find("seed")->place.text() == "body.0.seed");
}
