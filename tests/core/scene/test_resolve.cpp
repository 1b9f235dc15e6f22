#include <filesystem>
#include <fstream>

#include "perimpm/scene/scene.hpp"
#include "support/box_scene.hpp"
#include "support/catch.hpp"
#include "support/environment.hpp"
#include "support/scene.hpp"

using namespace perimpm;

namespace {

Value resolved(const Overrides& overrides = {}) { return resolved_scene(scene_from(kBox, overrides)); }

/// The value at a dotted path; lists by index.
const Value& part(const Value& tree, const std::string& path) {
    const std::string key = path.substr(0, path.find('.'));
    const Value* found = tree.is_list() ? &std::get<Value::List>(tree.data)[std::stoul(key)] : tree.find(key);
    INFO(path);
    REQUIRE(found);
    return key.size() == path.size() ? *found : part(*found, path.substr(key.size() + 1));
}

std::string text(const Value& tree, const std::string& path) { return std::get<std::string>(part(tree, path).data); }

/// What a table holds for a key that it was not given.
void check_default(const Value& table, const ParamSpec& spec) {
    CAPTURE(spec.key);
    const Value* value = table.find(spec.key);
    REQUIRE(value);
    if (spec.default_text && (spec.kind == ParamKind::vector || spec.kind == ParamKind::list))
        CHECK(value->to_toml() == parse_scene_text(std::string("v = ") + spec.default_text, "").find("v")->to_toml());
    else if (spec.default_text)
        CHECK(std::get<std::string>(value->data) == spec.default_text);
    else
        CHECK_THAT(std::stod(value->to_toml() == "true"    ? "1"
                             : value->to_toml() == "false" ? "0"
                                                           : value->to_toml()),
                   WithinAbs(spec.default_value, 0));
}

bool has_value(const ParamSpec& spec) { return spec.default_text || !std::isnan(spec.default_value); }

}  // namespace

TEST_CASE("resolve: every key that was not given has its declared default", "[scene]") {
    const Value given = scene_from(kBox).source;
    const Value tree = resolved({R"(collider=[{ shape = { type = "plane", point = [0, -9, 0], normal = [0, 1, 0] } }])",
                                 "grid.domain={ min = [-1, -1, -1], max = [1, 1, 1] }"});
    const std::pair<const char*, const char*> tables[] = {{"simulation", "simulation"}, {"domain", "grid.domain"},
                                                          {"body", "body.0"},           {"collider", "collider.0"},
                                                          {"output", "output"},         {"scene", ""}};
    int checked = 0;
    for (const auto& [topic, path] : tables)
        for (const SectionDoc& section : scene_reference()) {
            if (section.topic != topic) continue;
            const Value& table = *path ? part(tree, path) : tree;
            const bool is_given = section.topic == "simulation" || section.topic == "body";
            for (const ParamSpec& spec : section.keys) {
                if (!has_value(spec) || (is_given && part(given, path).find(spec.key))) continue;
                if (std::string(spec.key) == "particles_per_cell") continue;  // the spacing stands in its place
                check_default(table, spec);
                ++checked;
            }
        }
    CHECK(checked >= 15);
    CHECK(text(tree, "body.0.name") == "body 0");
    CHECK(text(tree, "collider.0.name") == "collider 0");
}

TEST_CASE("resolve: models have all of their parameters, the type first", "[scene]") {
    const Scene scene = scene_from(kBox);
    const Value tree = resolved_scene(scene);
    const std::pair<Family, const char*> models[] = {{Family::transfer, "transfer"},
                                                     {Family::constitutive, "material.rubber.constitutive"}};
    for (const auto& [family, path] : models) {
        const auto& table = std::get<Value::Table>(part(tree, path).data);
        CHECK(table[0].first == "type");
        const PluginDescriptor& plugin = *open_plugin(family, text(tree, std::string(path) + ".type")).descriptor;
        CHECK(table.size() == 1 + plugin.param_count);
        const Value& given = part(scene.source, path);
        for (std::uint32_t k = 0; k < plugin.param_count; ++k)
            if (!given.find(plugin.params[k].key)) check_default(part(tree, path), plugin.params[k]);
    }
}

TEST_CASE("resolve: what was given stays as it was given", "[scene]") {
    const Value tree = resolved({"simulation.safety=0.5", R"(output={ fields = ["v", "x"] })", "body.0.name=\"block\"",
                                 "body.0.initial_velocity=[1, 2, 3]"});
    CHECK(std::get<double>(part(tree, "simulation.safety").data) == 0.5);
    CHECK(part(tree, "output.fields").to_toml() == parse_scene_text("v = [\"v\", \"x\"]", "").find("v")->to_toml());
    CHECK(text(tree, "body.0.name") == "block");
    CHECK(part(tree, "body.0.initial_velocity").to_toml() == "[1, 2, 3]");
}

TEST_CASE("resolve: of two keys that exclude each other only the one in force is there", "[scene]") {
    CHECK_FALSE(part(resolved(), "body.0").find("particles_per_cell"));
    const std::string shape = "shape = { type = \"box\", min = [0, 0, 0], max = [0.4, 0.4, 0.4] }";
    const Value by_number = resolved({"body=[{ material = \"rubber\", particles_per_cell = 4, " + shape + " }]"});
    CHECK(part(by_number, "body.0.particles_per_cell").to_toml() == "4");
    CHECK_FALSE(part(by_number, "body.0").find("particle_spacing"));
}

TEST_CASE("resolve: a default that a model refuses beside the given keys stays out", "[scene]") {
    // pd_bond takes its default `surface` only with the lattice calibration
    CHECK(text(resolved({kBonds}), "material.rubber.constitutive.surface") == "moment");
    const Value continuum = resolved(
        {R"(material.rubber.constitutive={ type = "pd_bond", youngs_modulus = 1e5, calibration = "continuum" })"});
    CHECK_FALSE(part(continuum, "material.rubber.constitutive").find("surface"));
    CHECK(part(continuum, "material.rubber.constitutive").find("volume_correction"));
}

TEST_CASE("resolve: a material without a body is left alone", "[scene]") {
    const Value tree =
        resolved({R"(material.spare={ density = 1, constitutive = { type = "pd_bond", youngs_modulus = 1e5 } })"});
    CHECK_FALSE(part(tree, "material.spare.constitutive").find("horizon"));
    CHECK(part(resolved({kBonds}), "material.rubber.constitutive").find("horizon"));
}

TEST_CASE("resolve: faces given by name are all there", "[scene]") {
    const Value tree = resolved({"grid.domain={ min = [-1, -1, -1], max = [1, 1, 1], faces = { min_y = \"slip\" } }"});
    CHECK(text(tree, "grid.domain.faces.min_y") == "slip");
    for (const char* face : {"min_x", "max_x", "max_y", "min_z", "max_z"})
        CHECK(text(tree, std::string("grid.domain.faces.") + face) == "separate");
}

TEST_CASE("resolve: mesh files are named from the root", "[scene]") {
    const TemporaryFolder folder;
    std::ofstream(folder.path / "tet.obj")
        << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    std::filesystem::create_directory(folder.path / "scenes");
    Value tree = parse_scene_text(kBox, "s.toml");
    apply_override(tree, R"(body.0.shape={ type = "mesh", file = "../tet.obj" })");
    const Value whole = resolved_scene(read_scene(std::move(tree), folder.path / "scenes"));
    CHECK(text(whole, "body.0.shape.file") == (folder.path / "tet.obj").string());
    CHECK(part(whole, "body.0.shape.scale").to_toml() == parse_scene_text("v = 1.0", "").find("v")->to_toml());
}

TEST_CASE("resolve: a resolved scene reads back to itself", "[scene]") {
    for (const Overrides& overrides :
         {Overrides{}, Overrides{kBonds, kNoGrid, kNeverBreaks}, Overrides{kElastic, kFloor}}) {
        const Value once = resolved(overrides);
        const Value twice = resolved_scene(read_scene(once, "elsewhere"));
        CHECK(twice.to_json() == once.to_json());
    }
}

TEST_CASE("resolve: a law inside a law has its defaults, too", "[scene]") {
    const Value tree = resolved({R"(material.rubber.constitutive={ type = "pd_correspondence",)"
                                 R"( law = { type = "neo_hookean", youngs_modulus = 1e5 } })"});
    const std::string law = "material.rubber.constitutive.law.";
    CHECK(text(tree, law + "type") == "neo_hookean");
    CHECK(std::get<double>(part(tree, law + "poisson_ratio").data) == 0.25);
}
