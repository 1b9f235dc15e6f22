#include <cmath>
#include <cstring>
#include <limits>

#include "perimpm/scene/reader.hpp"
#include "perimpm/scene/scene.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"

using namespace perimpm;

namespace {

constexpr ParamSpec kSpecs[] = {
    {.key = "youngs_modulus", .unit = "Pa", .range = above(0.0), .per_particle = true, .doc = "stiffness"},
    {.key = "poisson_ratio", .range = open(-1.0, 0.5), .default_value = 0.25, .doc = ""},
    {.key = "order", .kind = ParamKind::integer, .range = closed(1.0, 3.0), .default_value = 3.0, .doc = ""},
    {.key = "mode", .kind = ParamKind::choice, .default_text = "fast", .choices = "fast|exact", .doc = ""},
    {.key = "dt", .unit = "s", .range = above(0.0), .default_text = "auto", .choices = "auto", .doc = ""},
    {.key = "on", .kind = ParamKind::boolean, .default_value = 1.0, .doc = ""},
    {.key = "label", .kind = ParamKind::text, .optional = true, .doc = ""},
    {.key = "point", .kind = ParamKind::vector, .unit = "m", .optional = true, .doc = ""},
    {.key = "inner", .kind = ParamKind::table, .optional = true, .doc = ""},
    {.key = "items", .kind = ParamKind::list, .optional = true, .doc = ""},
    {.key = "share", .range = {.low = 0.0, .high = 1.0, .high_open = false}, .optional = true, .doc = ""},
    {.key = "count", .kind = ParamKind::integer, .optional = true, .doc = ""},
    {.key = "law", .kind = ParamKind::model, .optional = true, .doc = ""},
};

/// Error for a table that holds the required key and the given text.
std::string refusal(const std::string& text) {
    const Value table = parse_scene_text("youngs_modulus = 1.0\n" + text, "s.toml");
    return message_of([&] { Reader(table, kSpecs, "thing"); });
}

std::string modulus_refusal(const std::string& value) {
    const Value table = parse_scene_text("youngs_modulus = " + value, "s.toml");
    return message_of([&] { Reader(table, kSpecs, "thing"); });
}

}  // namespace

TEST_CASE("reader: given values and defaults", "[scene]") {
    const Value table = parse_scene_text(
        "youngs_modulus = 2\norder = 1\nmode = \"exact\"\ndt = 0.5\non = false\npoint = [1, 2.5, -3]\ninner = {}", "s");
    const Reader r{table, kSpecs, "thing"};
    CHECK(r.number("youngs_modulus") == 2.0);  // an integer is a number
    CHECK(r.number("poisson_ratio") == 0.25);
    CHECK_FALSE(r.given("poisson_ratio"));
    CHECK(r.integer("order") == 1);
    CHECK(r.text("mode") == "exact");
    CHECK(r.number("dt") == 0.5);
    CHECK(r.text("dt").empty());
    CHECK_FALSE(r.flag("on"));
    CHECK(r.text("label").empty());
    CHECK(r.vector("point") == std::array<double, 3>{1.0, 2.5, -3.0});
    CHECK(r.value("inner")->is_table());
    CHECK(r.value("items") == nullptr);
    CHECK(std::isnan(r.number("share")));
    CHECK_THROWS_AS(r.number("nothing"), std::logic_error);
}

TEST_CASE("reader: values come in the order of the declaration, texts as words", "[scene]") {
    const Value table = parse_scene_text("youngs_modulus = 2\ndt = \"auto\"", "s");
    const Reader r{table, kSpecs, "thing"};
    REQUIRE(r.values().size() == std::size(kSpecs));
    CHECK(r.values()[0].number == 2.0);
    CHECK(r.values()[0].given);
    CHECK(std::strcmp(r.values()[3].text, "fast") == 0);
    CHECK(std::strcmp(r.values()[4].text, "auto") == 0);
    CHECK(std::isnan(r.values()[4].number));
    CHECK(r.values()[5].number == 1.0);
    CHECK(r.values()[6].text == nullptr);
    CHECK(r.vector("point", {4.0, 5.0, 6.0}) == std::array<double, 3>{4.0, 5.0, 6.0});
}

TEST_CASE("reader: an unknown key gets the closest one and the list", "[scene]") {
    CHECK(contains(refusal("  poison_ratio = 0.3"),
                   "s.toml:2:3: error: unknown key 'poison_ratio' in thing\n  did you mean 'poisson_ratio'?   "
                   "accepted: youngs_modulus [Pa], poisson_ratio, order, "));
    const Value table = parse_scene_text("youngs_modulus = 1\ntype = \"x\"", "s");
    const char* const extra[] = {"type"};
    CHECK_NOTHROW(Reader(table, kSpecs, "thing", extra));
    const char* const declared[] = {"count"};  // listed once, although both let it through
    CHECK(contains(message_of([&] { Reader(table, kSpecs, "thing", declared); }) + "|", ", share, count, law|"));
    CHECK(contains(message_of([&] { Reader(table, kSpecs, "thing"); }), "unknown key 'type'"));
}

TEST_CASE("reader: a missing key is reported with its unit and meaning", "[scene]") {
    Value table = parse_scene_text("order = 1", "s.toml");
    CHECK(message_of([&] { Reader(table, kSpecs, "thing"); }) ==
          "s.toml: error: missing key 'youngs_modulus' [Pa] in thing: stiffness");
    table.data = 1.5;
    CHECK(message_of([&] { Reader(table, kSpecs, "thing"); }) == "s.toml: error: thing must be a table, got a number");
}

TEST_CASE("reader: wrong kinds are refused with what was found", "[scene]") {
    CHECK(modulus_refusal("\"stiff\"") ==
          "s.toml:1:1: error: 'youngs_modulus' in thing must be a number or a ramp "
          "{ from, to, start, end } [Pa], got a text (\"stiff\")");
    CHECK(contains(refusal("poisson_ratio = {}"), "'poisson_ratio' in thing must be a number, got a table"));
    CHECK(contains(refusal("order = 1.5"), "'order' in thing must be an integer, got a number (1.5)"));
    CHECK(contains(refusal("order = 2.0"), "must be an integer, got a number (2.0)"));
    CHECK(contains(refusal("on = 1"), "'on' in thing must be true or false, got an integer (1)"));
    CHECK(contains(refusal("mode = 1"), "'mode' in thing must be one of \"fast\", \"exact\", got an integer (1)"));
    CHECK(contains(refusal("dt = true"), "'dt' in thing must be a number [s] or \"auto\", got a boolean (true)"));
    CHECK(contains(refusal("dt = \"1e-4\""),
                   "'dt' in thing must be a number [s] or \"auto\", got a text (\"1e-4\")\n  write it without quotes"));
    CHECK(contains(refusal("label = 3"), "'label' in thing must be a text, got an integer (3)"));
    CHECK(contains(refusal("point = 3"), "'point' in thing must be a list of 3 numbers [m], got an integer (3)"));
    CHECK(contains(refusal("inner = []"), "'inner' in thing must be a table, got a list"));
    CHECK(contains(refusal("items = {}"), "'items' in thing must be a list, got a table"));
}

TEST_CASE("reader: words are matched exactly, with the closest one", "[scene]") {
    CHECK(contains(refusal("mode = \"exakt\""),
                   "s.toml:2:1: error: 'mode' in thing does not know 'exakt'\n  did you mean "
                   "'exact'?   accepted: fast, exact"));
    CHECK(contains(refusal("dt = \"automatic\""), "'dt' in thing does not know 'automatic'"));
}

TEST_CASE("reader: ranges are judged with their ends and their unit", "[scene]") {
    CHECK(modulus_refusal("-3") == "s.toml:1:1: error: 'youngs_modulus' in thing must be above 0 Pa, got -3");
    CHECK(contains(modulus_refusal("0.0"), "must be above 0 Pa, got 0"));
    CHECK(contains(refusal("poisson_ratio = 0.5"), "must be above -1 and below 0.5, got 0.5"));
    CHECK(contains(refusal("order = 0"), "must be at least 1 and at most 3, got 0"));
    CHECK(contains(refusal("order = 4"), "must be at least 1 and at most 3, got 4"));
    CHECK(refusal("order = 3") == "(no error)");
    CHECK(refusal("share = 1.0") == "(no error)");
    CHECK(contains(refusal("share = 0"), "must be above 0 and at most 1, got 0"));
    CHECK(contains(refusal("share = 1.0000001"), "got 1.0000001"));
}

TEST_CASE("reader: an integer must survive its way through a double", "[scene]") {
    CHECK(refusal("count = 9007199254740992") == "(no error)");  // 2^53
    CHECK(contains(refusal("count = 9007199254740993"), "'count' in thing must lie within 2^53 of zero"));
    CHECK(contains(refusal("count = -9223372036854775808"), "must lie within 2^53"));
}

TEST_CASE("reader: NaN and infinity are refused everywhere", "[scene]") {
    CHECK(contains(modulus_refusal("nan"), "'youngs_modulus' in thing must be finite [Pa], got nan"));
    CHECK(contains(modulus_refusal("inf"), "must be finite [Pa], got inf"));
    CHECK(
        contains(refusal("point = [0, -inf, 0]"), "s.toml:2:13: error: 'point' in thing must be finite [m], got -inf"));
    CHECK(contains(modulus_refusal("{ from = nan, to = 1, start = [0, 0, 0], end = [1, 0, 0] }"), "'from'"));
}

TEST_CASE("reader: vectors have three numbers", "[scene]") {
    CHECK(contains(refusal("point = [1, 2]"), "'point' in thing must be a list of 3 numbers [m], got 2"));
    CHECK(contains(refusal("point = [1, 2, 3, 4]"), "got 4"));
    CHECK(contains(refusal("point = [1, 2, \"z\"]"), "got a text (\"z\")"));
}

TEST_CASE("reader: a per-particle number may be a ramp", "[scene]") {
    const Value table =
        parse_scene_text("youngs_modulus = { from = 2.0, to = 4, start = [0, 0, 0], end = [1, 0, 0] }", "s.toml");
    const Reader r{table, kSpecs, "thing"};
    CHECK(r.values()[0].number == 2.0);
    CHECK(r.value("youngs_modulus")->is_table());
    const std::optional<Ramp> ramp = r.ramp("youngs_modulus");
    REQUIRE(ramp);
    CHECK(ramp->from == 2.0);
    CHECK(ramp->to == 4.0);
    CHECK(ramp->end == std::array<double, 3>{1.0, 0.0, 0.0});
    CHECK_FALSE(r.ramp("poisson_ratio"));
}

TEST_CASE("reader: both ends of a ramp respect the range", "[scene]") {
    CHECK(contains(modulus_refusal("{ from = 1, to = -2, start = [0, 0, 0], end = [1, 0, 0] }"),
                   "'to' in thing.youngs_modulus must be above 0 Pa, got -2"));
    CHECK(contains(modulus_refusal("{ from = 0, to = 2, start = [0, 0, 0], end = [1, 0, 0] }"), "'from' in"));
    CHECK(contains(modulus_refusal("{ from = 1, to = 2, start = [0, 0, 0] }"), "missing key 'end' [m]"));
    CHECK(contains(modulus_refusal("{ from = 1, to = 2, begin = [0, 0, 0] }"), "unknown key 'begin'"));
    CHECK(contains(modulus_refusal("{ from = 1, to = 2, start = [1, 0, 0], end = [1, 0, 0] }"),
                   "must differ from 'start'"));
}

TEST_CASE("reader: fail names the key at its place", "[scene]") {
    const Value table = parse_scene_text("youngs_modulus = 1\norder = 2", "s.toml");
    const Reader r{table, kSpecs, "thing"};
    CHECK(message_of([&] { r.fail("order", "must be odd"); }) == "s.toml:2:1: error: 'order' in thing must be odd");
    CHECK(message_of([&] { r.fail("dt", "is needed"); }) == "s.toml: error: 'dt' in thing is needed");
}

TEST_CASE("reader: read_type lists what is accepted", "[scene]") {
    const auto refusal_of = [](const std::string& text) {
        return message_of([&] { read_type(parse_scene_text(text, "s.toml"), "shape", {"box", "sphere"}); });
    };
    CHECK(read_type(parse_scene_text("type = \"box\"", "s"), "shape", {"box"}) == "box");
    CHECK(read_type(parse_scene_text("type = \"any\"", "s"), "shape", {}) == "any");
    CHECK(refusal_of("type = \"spere\"") ==
          "s.toml:1:1: error: unknown type 'spere' in shape\n  did you mean 'sphere'?   accepted: box, sphere");
    CHECK(refusal_of("radius = 1") == "s.toml: error: missing key 'type' in shape\n  accepted: box, sphere");
    CHECK(refusal_of("type = 1") == "s.toml:1:1: error: 'type' in shape must be a text, got an integer");
}

TEST_CASE("reader: a model inside a model is checked as its own table is", "[scene]") {
    const Value table =
        parse_scene_text("youngs_modulus = 2\nlaw = { type = \"fixed_corotated\", youngs_modulus = 3e5 }", "s.toml");
    const Reader r{table, kSpecs, "thing"};
    REQUIRE(r.model("law"));
    CHECK(r.model("law")->type == "fixed_corotated");
    CHECK(r.model("law")->params->number("youngs_modulus") == 3e5);
    const ModelChoice& choice = *r.values()[std::size(kSpecs) - 1].model;
    CHECK(std::string(choice.type) == "fixed_corotated");
    CHECK(choice.values[0].number == 3e5);
    CHECK(message_of([&] { r.fail("law.youngs_modulus", "is bad"); }) ==
          "s.toml:2:35: error: 'youngs_modulus' in thing.law ('fixed_corotated') is bad");
    CHECK(Reader(parse_scene_text("youngs_modulus = 2", "s"), kSpecs, "thing").model("law") == nullptr);
    CHECK(contains(refusal("law = \"fixed_corotated\""), "write law = { type = \"fixed_corotated\", ... }"));
    CHECK(contains(refusal("law = { youngs_modulus = 1.0 }"), "missing key 'type' in thing.law"));
    CHECK(contains(refusal("law = { type = \"fixed_corotate\" }"), "fixed_corotated"));
    CHECK(contains(refusal("law = { type = \"fixed_corotated\", youngs_module = 1.0 }"),
                   "did you mean 'youngs_modulus'?"));
    const std::string ramp = "{ from = 1, to = 2, start = [0, 0, 0], end = [1, 0, 0] }";
    CHECK(contains(refusal("law = { type = \"fixed_corotated\", youngs_modulus = " + ramp + " }"),
                   "cannot vary per particle inside another model"));
}
