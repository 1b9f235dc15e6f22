#include "perimpm/scene/tree.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"

using namespace perimpm;

namespace {

Value scene() {
    return parse_scene_text(R"([material.rubber]
density = 1000.0
constitutive = { type = "pd_elastic", youngs_modulus = 2.5e5, horizon = 2.01 }
[[body]]
particles_per_cell = 8
)",
                            "s.toml");
}

std::string after(const std::string& assignment) {
    Value tree = scene();
    apply_override(tree, assignment);
    return tree.to_toml();
}

std::string refusal(const std::string& assignment) {
    Value tree = scene();
    const std::string message = message_of([&] { apply_override(tree, assignment); });
    CHECK(tree.to_toml() == scene().to_toml());  // a refused override changes nothing
    return message;
}

}  // namespace

TEST_CASE("override: replaces a value and keeps its neighbours", "[scene]") {
    CHECK(contains(after("material.rubber.density=900"), "density = 900,"));
    CHECK(contains(after("material.rubber.density = 9e2"), "density = 900.0,"));
    CHECK(contains(after("material.rubber.density=900"), "horizon = 2.01"));
    CHECK(contains(after("body.0.particles_per_cell=27"), "body = [{ particles_per_cell = 27 }]"));
    CHECK(contains(after("body.0={ seed = 2 }"), "body = [{ seed = 2 }]"));
}

TEST_CASE("override: a table replaces the whole table", "[scene]") {
    const std::string text = after("material.rubber.constitutive={ type = \"fixed_corotated\", poisson_ratio = 0.25 }");
    CHECK(contains(text, R"(constitutive = { type = "fixed_corotated", poisson_ratio = 0.25 })"));
    CHECK_FALSE(contains(text, "horizon"));
}

TEST_CASE("override: tables on the way are made, list elements are not", "[scene]") {
    CHECK(contains(after("grid.domain.friction=0.5"), "grid = { domain = { friction = 0.5 } }"));
    CHECK(contains(after("title=\"a = b\""), "title = \"a = b\""));
    CHECK(contains(after("material.rubber.\"soft part\".density=1"), "\"soft part\" = { density = 1 }"));
    CHECK(refusal("body.1.seed=2") == "--set body.1.seed: error: index 1 is out of range: the list has 1 element");
    CHECK(contains(refusal("body.-1.seed=2"), "'-1' must be the index of a list element"));
    CHECK(contains(refusal("body.first.seed=2"), "'first' must be the index of a list element"));
    CHECK(refusal("material.rubber.density.unit=2") ==
          "--set material.rubber.density.unit: error: 'material.rubber.density' is a number; it has no entry 'unit'");
}

TEST_CASE("override: a key of a material that the scene lacks is an error", "[scene]") {
    CHECK(refusal("material.ruber.density=900") ==
          "--set material.ruber.density: error: the scene has no material 'ruber'\n"
          "  did you mean 'rubber'?   accepted: rubber");
    CHECK(contains(after("material.foam={ density = 900 }"), "foam = { density = 900 }"));  // given as a whole
    Value empty = parse_scene_text("format = 1", "s.toml");
    CHECK(contains(message_of([&] { apply_override(empty, "material.rubber.density=900"); }), "accepted: nothing"));
}

TEST_CASE("override: the place of what it sets is the dotted path", "[scene]") {
    Value tree = scene();
    apply_override(tree, "material.rubber.fracture={ type = \"x\", list = [1, 2] }");
    const Value& fracture = *tree.find("material")->find("rubber")->find("fracture");
    CHECK(fracture.find("type")->place.text() == "material.rubber.fracture.type");
    CHECK(std::get<Value::List>(fracture.find("list")->data)[1].place.text() == "material.rubber.fracture.list.1");
    CHECK(tree.find("material")->find("rubber")->find("density")->place.text() == "s.toml:2:1");
}

TEST_CASE("override: a value that is not TOML is shown with quotes proposed", "[scene]") {
    CHECK(refusal("transfer.type=apic") ==
          "--set transfer.type: error: 'apic' is not a TOML value\n"
          "  a text needs quotes: --set 'transfer.type=\"apic\"'");
    CHECK(contains(refusal("transfer.type="), "'' is not a TOML value"));
    CHECK(contains(refusal("title=1\nformat=2"), "is not a TOML value"));  // a second line would set another key
    CHECK(contains(refusal("material.rubber.constitutive={ type = pd }"), "is not a TOML value"));
}

TEST_CASE("override: an assignment without a name or a value is an error", "[scene]") {
    CHECK(contains(refusal("title"), "expected NAME=VALUE"));
    CHECK(contains(refusal("=1"), "not a dotted path"));
    CHECK(contains(refusal("a..b=1"), "not a dotted path"));
    CHECK(contains(refusal("a b=1"), "not a dotted path"));
}
