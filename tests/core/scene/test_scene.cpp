// PERIMPM_TEST_PLUGINS: folder with the plugins of tests/core/plugin/fixtures, by family.
#include <algorithm>
#include <fstream>

#include "perimpm/scene/scene.hpp"
#include "support/catch.hpp"
#include "support/environment.hpp"
#include "support/message.hpp"

using namespace perimpm;

namespace {

const char* const kMinimal = R"(format = 1
[simulation]
end_time = 1
[grid]
spacing = 0.1
[transfer]
type = "sample_kernel"
[material.rubber]
density = 1000
constitutive = { type = "sample_law", youngs_modulus = 2.5e5 }
[[body]]
material = "rubber"
shape = { type = "box", min = [0, 0, 0], max = [1, 1, 1] }
)";

using Overrides = std::vector<std::string>;

Scene read(const Overrides& overrides = {}, const std::string& text = kMinimal, const std::string& folder = ".") {
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", PERIMPM_TEST_PLUGINS};
    Value tree = parse_scene_text(text, "s.toml");
    for (const std::string& assignment : overrides) apply_override(tree, assignment);
    return read_scene(std::move(tree), folder);
}

std::string refusal(const Overrides& overrides, const std::string& text = kMinimal) {
    return message_of([&] { read(overrides, text); });
}

/// kMinimal with one part replaced.
std::string with(const std::string& part, const std::string& replacement) {
    std::string text = kMinimal;
    const std::size_t at = text.find(part);
    REQUIRE(at != std::string::npos);
    return text.replace(at, part.size(), replacement);
}

}  // namespace

TEST_CASE("scene: what is not given takes its default", "[scene]") {
    const Scene scene = read();
    CHECK(scene.simulation.end_time == 1.0);
    CHECK(scene.simulation.frame_rate == 24.0);
    CHECK_FALSE(scene.simulation.dt);
    CHECK(scene.simulation.safety == 0.8);
    CHECK_FALSE(scene.simulation.allow_unstable_dt);
    CHECK(scene.simulation.precision == Precision::single_);
    CHECK(scene.simulation.gravity == Vec3(0.0, -9.81, 0.0));
    CHECK(scene.grid.spacing == 0.1);
    CHECK_FALSE(scene.grid.bounded);
    REQUIRE(scene.materials.size() == 1);
    CHECK(scene.materials[0].criterion.params == nullptr);
    REQUIRE(scene.bodies.size() == 1);
    CHECK(scene.bodies[0].name == "body 0");
    CHECK(scene.bodies[0].particles_per_cell == 8.0);
    CHECK_FALSE(scene.bodies[0].particle_spacing);
    CHECK_FALSE(scene.bodies[0].poisson);
    CHECK(scene.bodies[0].seed == 1);
    CHECK(scene.output.fields == std::vector<std::string>{"x", "v", "id"});
    CHECK(scene.output.formats == std::vector<std::string>{"hdf5"});
    CHECK(scene.colliders.empty());
}

TEST_CASE("scene: what is given is read", "[scene]") {
    const Scene scene = read({
        "title=\"drop\"",
        "simulation.dt=1e-4",
        "simulation.precision=\"double\"",
        "simulation.gravity=[0, 0, -1.62]",
        "grid.domain={ min = [-1, 0, -1], max = [1, 2, 1], faces = { min_y = \"sticky\", max_z = \"open\" }, friction "
        "= 0.3 }",
        "transfer.order=1",
        "material.rubber.fracture={ type = \"sample_criterion\", bond = 2 }",
        "body.0.name=\"ball\"",
        "body.0.shape={ type = \"sphere\", center = [0, 1, 0], radius = 0.5 }",
        "body.0.particle_spacing=0.05",
        "body.0.sampling=\"poisson\"",
        "body.0.seed=7",
        "body.0.initial_velocity=[1, 0, 0]",
        "body.0.initial_angular_velocity=[0, 0, 3]",
        "collider=[{ shape = { type = \"box\", min = [0, 0, 0], max = [1, 1, 1] }, contact = \"slip\", "
        "friction = 0.4, velocity = [0, 1, 0], angular_velocity = [1, 0, 0], pivot = [0, 0, 1] }]",
        "output={ fields = [\"x\", \"F\"], formats = [] }",
    });
    CHECK(scene.title == "drop");
    CHECK(scene.simulation.dt == 1.0e-4);
    CHECK(scene.simulation.dt_place.text() == "simulation.dt");
    CHECK(scene.simulation.precision == Precision::double_);
    CHECK(scene.simulation.gravity == Vec3(0.0, 0.0, -1.62));
    CHECK(scene.grid.bounded);
    CHECK(scene.grid.domain.max() == Vec3(1.0, 2.0, 1.0));
    const Face faces[] = {Face::separate, Face::separate, Face::sticky, Face::separate, Face::separate, Face::open};
    CHECK(std::equal(std::begin(faces), std::end(faces), scene.grid.faces));
    CHECK(scene.grid.face_friction == 0.3);
    CHECK(scene.transfer.params->integer("order") == 1);
    CHECK(scene.materials[0].criterion.type == "sample_criterion");
    CHECK(scene.materials[0].criterion.params->integer("bond") == 2);
    CHECK(scene.bodies[0].name == "ball");
    CHECK(scene.bodies[0].particle_spacing == 0.05);
    CHECK(scene.bodies[0].poisson);
    CHECK(scene.bodies[0].seed == 7);
    CHECK(scene.bodies[0].velocity == Vec3(1.0, 0.0, 0.0));
    CHECK(scene.bodies[0].angular_velocity == Vec3(0.0, 0.0, 3.0));
    REQUIRE(scene.colliders.size() == 1);
    CHECK(scene.colliders[0].contact == Contact::slip);
    CHECK(scene.colliders[0].friction == 0.4);
    CHECK(scene.colliders[0].pivot == Vec3(0.0, 0.0, 1.0));
    CHECK(scene.output.formats.empty());
}

TEST_CASE("scene: a plane does not turn, shapes that end do", "[scene]") {
    const auto collider = [](const std::string& shape, const std::string& omega) {
        return "collider=[{ shape = " + shape + ", angular_velocity = " + omega + " }]";
    };
    const std::string plane = R"({ type = "plane", point = [0, 0, 0], normal = [0, 1, 0] })";
    const std::string message = refusal({collider(plane, "[0, 0, 1e-3]")});
    CHECK(contains(message, "'angular_velocity' in collider 0 is for shapes that end"));
    CHECK(contains(message, "use a box"));
    CHECK(read({collider(plane, "[0, 0, 0]")}).colliders.size() == 1);
    const Scene scene = read({collider(R"({ type = "sphere", center = [0, 0, 0], radius = 1 })", "[0, 0, 1e-3]")});
    CHECK(scene.colliders[0].angular_velocity == Vec3(0.0, 0.0, 1e-3));
}

TEST_CASE("scene: more frames than frame numbers are refused", "[scene]") {
    CHECK(contains(refusal({"simulation.end_time=1", "simulation.frame_rate=1e12"}),
                   "'frame_rate' in simulation and 'end_time' make 1e+12 frames; at most 1e+09 are supported"));
    CHECK(read({"simulation.end_time=1", "simulation.frame_rate=1e9"}).simulation.frame_rate == 1e9);
}

TEST_CASE("scene: mirrors lie on half cells, periodic faces whole cells apart", "[scene]") {
    const auto faces = [](const std::string& min, const std::string& max, const std::string& words) {
        return refusal({"grid.spacing=0.1", "grid.domain={ min = [" + min + ", -1, -1], max = [" + max +
                                                ", 1, 1], faces = { " + words + " } }"});
    };
    CHECK(contains(faces("-0.98", "1", R"(min_x = "symmetry")"), "puts the symmetry face min_x at x = -0.98 m"));
    CHECK(contains(faces("-0.98", "1", R"(min_x = "symmetry")"), "nearest: -1 m"));
    CHECK(contains(faces("-1", "1.04", R"(max_x = "symmetry")"), "nearest: 1.05 m"));
    CHECK(contains(faces("-1", "1", R"(max_x = "periodic")"), "makes max_x periodic but not the face opposite"));
    const std::string both = R"(min_x = "periodic", max_x = "periodic")";
    CHECK(contains(faces("-1", "1.03", both), "20.3 cells long along x"));
    CHECK(contains(faces("-1", "1.03", both), "nearest: max x = 1 m"));
    CHECK(contains(faces("-1", "-0.96", both), "at least half a cell (0.05 m)"));
}

TEST_CASE("scene: one word names all six faces", "[scene]") {
    const Scene scene = read({"grid.domain={ min = [0, 0, 0], max = [1, 1, 1], faces = \"sticky\" }"});
    for (const Face face : scene.grid.faces) CHECK(face == Face::sticky);
    CHECK(contains(refusal({"grid.domain={ min = [0, 0, 0], max = [1, 1, 1], faces = \"stiky\" }"}),
                   "did you mean 'sticky'?"));
    CHECK(contains(refusal({"grid.domain={ min = [0, 0, 0], max = [1, 1, 1], faces = { top = \"slip\" } }"}),
                   "unknown key 'top' in grid.domain.faces"));
    CHECK(contains(refusal({"grid.domain={ min = [0, 0, 0], max = [1, 0, 1] }"}),
                   "grid.domain.max: error: 'max' in grid.domain must be above 'min' in every component"));
}

TEST_CASE("scene: a model's parameters stay valid when the scene moves", "[scene]") {
    std::vector<Scene> scenes;
    for (int i = 0; i < 5; ++i) scenes.push_back(read({"material.rubber.constitutive.influence=\"linear\""}));
    const Reader& params = *scenes[0].materials[0].law.params;
    CHECK(params.number("youngs_modulus") == 2.5e5);
    CHECK(params.text("influence") == "linear");
    CHECK(params.values()[4].text == std::string{"linear"});
    CHECK(params.table().find("type") != nullptr);
}

TEST_CASE("scene: keys and values of models are judged by the plugin's table", "[scene]") {
    CHECK(refusal({}, with("youngs_modulus", "youngs_modlus")) ==
          "s.toml:10:39: error: unknown key 'youngs_modlus' in material.rubber.constitutive ('sample_law')\n"
          "  did you mean 'youngs_modulus'?   accepted: youngs_modulus [Pa], poisson_ratio, layers, viscous, "
          "influence, label, type");
    CHECK(refusal({"material.rubber.constitutive.youngs_modulus=-3"}) ==
          "material.rubber.constitutive.youngs_modulus: error: 'youngs_modulus' in material.rubber.constitutive "
          "('sample_law') must be above 0 Pa, got -3");
    CHECK(contains(refusal({"transfer.blend=0.5"}), "unknown key 'blend' in transfer ('sample_kernel')"));
    CHECK(refusal({"transfer.order=2"}) == "transfer.order: error: 'order' in transfer ('sample_kernel') must be odd");
    CHECK(contains(refusal({"material.rubber.fracture={}"}), "missing key 'type' in material.rubber.fracture"));
}

TEST_CASE("scene: an unknown model is an error at its place, with the closest one", "[scene]") {
    const std::string message = refusal({}, with("sample_law", "sample_lwa"));
    CHECK(contains(message, "s.toml:10:18: error: material.rubber.constitutive: no constitutive plugin 'sample_lwa'"));
    CHECK(contains(message, "did you mean 'sample_law'?"));
    CHECK(contains(refusal({"transfer.type=\"sample_law\""}), "no transfer plugin 'sample_law' is installed"));
}

TEST_CASE("scene: opens exactly the plugins that it names", "[scene]") {
    const auto before = opened_plugins();
    read();
    auto expected = before;
    for (const char* name : {"constitutive/sample_law", "transfer/sample_kernel"}) {
        if (std::find(expected.begin(), expected.end(), name) == expected.end()) expected.emplace_back(name);
    }
    std::sort(expected.begin(), expected.end());
    CHECK(opened_plugins() == expected);
}

TEST_CASE("scene: the format comes first", "[scene]") {
    CHECK(refusal({}, with("format = 1", "format = 2\nnovelty = 3")) ==
          "s.toml:1:1: error: this perimpm reads scenes of format 1, got format 2");
    CHECK(contains(refusal({}, with("format = 1", "")), "missing key 'format' in the scene"));
    CHECK(contains(refusal({"format=1.0"}), "'format' in the scene must be an integer"));
    CHECK(contains(refusal({"simulaton={}"}), "did you mean 'simulation'?"));
}

TEST_CASE("scene: bad times and steps are refused", "[scene]") {
    CHECK(refusal({"simulation.end_time=0"}) ==
          "simulation.end_time: error: 'end_time' in simulation must be above 0 s, got 0");
    CHECK(contains(refusal({"simulation.dt=0"}), "'dt' in simulation must be above 0 s, got 0"));
    CHECK(contains(refusal({"simulation.dt=\"fast\""}), "'dt' in simulation does not know 'fast'"));
    CHECK(contains(refusal({"simulation.safety=1.5"}), "must be above 0 and at most 1, got 1.5"));
    CHECK(contains(refusal({"simulation.precision=\"single\""}), "accepted: float, double"));
    CHECK(contains(refusal({"simulation.frame_rate=nan"}), "must be finite [1/s], got nan"));
}

TEST_CASE("scene: a grid spacing is required exactly when the transfer has a grid", "[scene]") {
    const std::string no_grid = with("[grid]\nspacing = 0.1\n", "");
    CHECK(contains(refusal({}, no_grid),
                   "missing key 'spacing' [m] in grid: the transfer 'sample_kernel' works on a grid"));
    CHECK(contains(refusal({"transfer.grid=false"}, no_grid),
                   "'particle_spacing' in body 0 is required [m]: without grid.spacing there are no cells to fill"));
    const Scene scene = read({"transfer.grid=false", "body.0.particle_spacing=0.1"}, no_grid);
    CHECK(scene.grid.spacing == 0.0);
    CHECK(contains(refusal({"grid.spacing=-1"}), "must be above 0 m, got -1"));
}

TEST_CASE("scene: bodies are named by index and name in errors", "[scene]") {
    CHECK(contains(refusal({"body.0.name=\"ball\"", "body.0.sed=1"}),
                   "body.0.sed: error: unknown key 'sed' in body 0 ('ball')"));
    CHECK(refusal({"body.0.material=\"ruber\""}) ==
          "body.0.material: error: 'material' in body 0 names 'ruber', which is no [material.NAME]\n"
          "  did you mean 'rubber'?   accepted: rubber");
    CHECK(contains(refusal({"body.0.particles_per_cell=8", "body.0.particle_spacing=0.1"}),
                   "'particle_spacing' in body 0 excludes 'particles_per_cell'"));
    CHECK(contains(refusal({"body.0.particles_per_cell=0"}), "must be above 0, got 0"));
    CHECK(contains(refusal({"body.0.seed=1.5"}), "'seed' in body 0 must be an integer"));
    CHECK(contains(refusal({"body=[]"}), "nothing to simulate: the scene has no [[body]]"));
    CHECK(contains(refusal({"body={ material = \"rubber\" }"}), "'body' in the scene must be a list, got a table"));
    CHECK(contains(refusal({"body=[1]"}), "body.0: error: body 0 must be a table, got an integer"));
}

TEST_CASE("scene: names are unique among bodies and among colliders", "[scene]") {
    const std::string body =
        R"({ name = "a", material = "rubber", shape = { type = "sphere", center = [0, 0, 0], radius = 1 } })";
    CHECK(refusal({"body=[" + body + ", " + body + "]"}) ==
          "body.1.name: error: body 0 and body 1 have the same name 'a'");
    const std::string collider = R"({ name = "a", shape = { type = "plane", point = [0, 0, 0], normal = [0, 1, 0] } })";
    CHECK(refusal({"collider=[" + collider + ", " + collider + "]"}) ==
          "collider.1.name: error: collider 0 and collider 1 have the same name 'a'");
    CHECK(read({"body.0.name=\"a\"", "collider=[" + collider + "]"}).colliders.size() == 1);
}

TEST_CASE("scene: a material that no body uses is allowed", "[scene]") {
    const Scene scene =
        read({"material.spare={ density = 1, constitutive = { type = \"sample_law\", youngs_modulus = 1 } }"});
    REQUIRE(scene.materials.size() == 2);
    CHECK(scene.materials[1].name == "spare");
    CHECK(scene.bodies[0].material == 0);
}

TEST_CASE("scene: output is checked", "[scene]") {
    CHECK(contains(refusal({"output.formats=[\"vbd\"]"}), "'formats' in output does not know 'vbd'\n  accepted: hdf5"));
    CHECK(contains(refusal({"output.fields=[\"x\", \"x\"]"}),
                   "output.fields.1: error: 'fields' in output names 'x' twice"));
    CHECK(contains(refusal({"output.fields=[1]"}), "'fields' in output must hold texts, got an integer"));
    CHECK(contains(refusal({"output.fields=[\"v\"]"}), "'fields' in output must hold \"x\""));
}

TEST_CASE("scene: a tree without positions reports dotted paths", "[scene]") {
    Value tree{Value::Table{{"format", {std::int64_t{1}, {}}}, {"titel", {std::string{"x"}, {}}}}, {}};
    CHECK(contains(message_of([&] { read_scene(tree, "."); }), "titel: error: unknown key 'titel' in the scene"));
}

TEST_CASE("scene: the reference has a meaning for every key and the defaults that are read", "[scene]") {
    const Scene scene = read();
    for (const SectionDoc& section : scene_reference()) {
        CHECK_FALSE(section.doc.empty());
        for (const ParamSpec& key : section.keys) {
            CHECK_FALSE(std::string{key.doc}.empty());
            const auto shown = [&](const char* name) { return std::string{key.key} == name; };
            if (section.name == "[simulation]" && shown("gravity"))
                CHECK(std::string{key.default_text} == "[0, -9.81, 0]");
            if (section.name == "[output]" && shown("fields"))
                CHECK(std::string{key.default_text} == "[\"x\", \"v\", \"id\"]");
            if (section.name == "[output]" && shown("formats")) CHECK(std::string{key.default_text} == "[\"hdf5\"]");
        }
    }
}
