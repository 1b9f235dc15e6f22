// PERIMPM_TEST_PLUGINS: folder with the plugins of tests/core/plugin/fixtures, by family.
#include <cmath>
#include <fstream>

#include "perimpm/scene/scene.hpp"
#include "support/catch.hpp"
#include "support/environment.hpp"
#include "support/message.hpp"

using namespace perimpm;

namespace {

Value shape(const std::string& text) { return *parse_scene_text("shape = " + text, "s.toml").find("shape"); }

ShapePtr build(const std::string& text) { return build_shape(shape(text), ".", 0.1); }

std::string refusal(const std::string& text, const std::string& owner = "body", const std::string& folder = ".") {
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", PERIMPM_TEST_PLUGINS};
    Value scene = parse_scene_text(R"(format = 1
simulation.end_time = 1
grid.spacing = 0.1
transfer.type = "sample_kernel"
material.m = { density = 1, constitutive = { type = "sample_law", youngs_modulus = 1 } }
body = [{ material = "m", shape = { type = "sphere", center = [0, 0, 0], radius = 1 } }]
collider = [{ shape = { type = "sphere", center = [0, 0, 0], radius = 1 } }]
)",
                                   "s.toml");
    apply_override(scene, owner + ".0.shape=" + text);
    return message_of([&] { read_scene(scene, folder); });
}

}  // namespace

TEST_CASE("shapes: each type is built from its keys", "[scene]") {
    // Signed distances derived by hand for each solid.
    CHECK(std::abs(build("{ type = 'box', min = [0, 0, 0], max = [2, 2, 2] }")->signed_distance({3, 1, 1}) - 1) <
          1e-12);
    CHECK(std::abs(build("{ type = 'sphere', center = [1, 0, 0], radius = 0.5 }")->signed_distance({3, 0, 0}) - 1.5) <
          1e-12);
    CHECK(std::abs(build("{ type = 'plane', point = [0, 1, 0], normal = [0, 2, 0] }")->signed_distance({7, 4, 0}) - 3) <
          1e-12);
    const ShapePtr rod = build("{ type = 'cylinder', start = [0, 0, 0], end = [0, 4, 0], radius = 1 }");
    CHECK(std::abs(rod->signed_distance({3, 2, 0}) - 2) < 1e-12);
    CHECK(std::abs(rod->signed_distance({0, 2, 0}) + 1) < 1e-12);
}

TEST_CASE("shapes: an unknown type, a missing key and a bad value are errors of their owner", "[scene]") {
    CHECK(
        refusal("{ type = 'spere', radius = 1 }") ==
        "body.0.shape.type: error: unknown type 'spere' in shape of body 0\n  did you mean 'sphere'?   accepted: box, "
        "sphere, cylinder, mesh, rectangle, polyline, plane");
    CHECK(
        contains(refusal("{ type = 'sphere', radius = 1 }"), "missing key 'center' [m] in shape of body 0 ('sphere')"));
    CHECK(contains(refusal("{ type = 'sphere', center = [0, 0, 0], radius = 0 }"), "must be above 0 m, got 0"));
    CHECK(contains(refusal("{ type = 'sphere', center = [0, 0], radius = 1 }"),
                   "must be a list of 3 numbers [m], got 2"));
    CHECK(contains(refusal("{ type = 'box', min = [0, 0, 0], max = [1, 1, 0] }", "collider"),
                   "collider.0.shape.max: error: 'max' in shape of collider 0 ('box') must be above 'min'"));
    CHECK(contains(refusal("{ type = 'cylinder', start = [1, 0, 0], end = [1, 0, 0], radius = 1 }"),
                   "must differ from 'start'"));
    CHECK(contains(refusal("'sphere'"), "'shape' in body 0 must be a table, got a text"));
}

TEST_CASE("shapes: a plane is for colliders only", "[scene]") {
    CHECK(refusal("{ type = 'plane', point = [0, 0, 0], normal = [0, 1, 0] }", "collider") == "(no error)");
    CHECK(
        contains(refusal("{ type = 'plane', point = [0, 0, 0], normal = [0, 0, 0] }", "collider"), "must not be zero"));
    CHECK(
        contains(refusal("{ type = 'plane', point = [0, 0, 0], normal = [0, 1, 0] }"),
                 "body.0.shape.type: error: shape of body 0: a plane has no end and cannot be filled with particles"));
}

TEST_CASE("shapes: what has no inside is for bodies only", "[scene]") {
    const std::string rectangle = "{ type = 'rectangle', corner = [0, 0, 0], edge_u = [1, 0, 0], edge_v = [0, 0, 2] }",
                      polyline = "{ type = 'polyline', points = [[0, 0, 0], [1, 2, 3]] }";
    for (const std::string& thin : {rectangle, polyline}) {
        CHECK(contains(refusal(thin, "collider"), "has no inside: it is for bodies\n  use a box"));
        CHECK(contains(message_of([&] { build(thin); }), "has no inside"));
    }
    CHECK(contains(refusal(rectangle), "missing key 'thickness' [m] in body 0"));
    CHECK(contains(refusal(polyline), "missing key 'cross_section' [m^2] in body 0"));
}

TEST_CASE("shapes: a mesh file is looked for early, beside the scene", "[scene]") {
    const TemporaryFolder folder;
    const std::string mesh = "{ type = 'mesh', file = 'assets/cube.obj', rotation = [0, 90, 0] }";
    CHECK(refusal(mesh, "body", folder.path) ==
          "body.0.shape.file: error: 'file' in shape of body 0 ('mesh') names 'assets/cube.obj', but there is no "
          "such file\n  there is no folder '" +
              (folder.path / "assets").string() + "'");
    std::filesystem::create_directory(folder.path / "assets");
    std::ofstream{folder.path / "assets/cube.obj"} << "# no faces; the content is judged when the mesh is built\n";
    CHECK(refusal(mesh, "body", folder.path) == "(no error)");
    CHECK(contains(refusal("{ type = 'mesh', file = 'assets' }", "body", folder.path),
                   "there is no such file\n  no .obj, .ply, .stl, .gltf, .glb file is in"));
    CHECK(contains(refusal("{ type = 'mesh', file = 'assets/cub.obj' }", "body", folder.path),
                   "did you mean 'cube.obj'?   in " + (folder.path / "assets").string() + ": cube.obj"));
    CHECK(contains(refusal("{ type = 'mesh', file = 'assets/cube.obj', scale = 0 }", "body", folder.path),
                   "must be above 0, got 0"));
}
