#include "perimpm/scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "perimpm/error.hpp"
#include "scene/bodies.hpp"
#include "scene/conditions.hpp"
#include "scene/cracks.hpp"
#include "scene/keys.hpp"
#include "scene/models.hpp"
#include "scene/vectors.hpp"

namespace perimpm {
namespace {

const Value kEmptyTable{Value::Table{}, {}};

const Value& section(const Reader& scene, const char* key) {
    const Value* value = scene.value(key);
    return value ? *value : kEmptyTable;
}

/// Comes before everything else, so that a file that is no scene is not judged key by key, nor a scene of a later format
/// by this format's keys.
void require_known_format(const Value& tree) {
    const Value* format = tree.find("format");
    if (!format) {
        throw InputError{tree.place.text(),
                         "missing key 'format' in the scene: the version of the scene format\n  write format = 1 above "
                         "the first [table] of the scene"};
    }
    const auto* number = format ? std::get_if<std::int64_t>(&format->data) : nullptr;
    if (number && *number != 1) {
        throw InputError{format->place.text(),
                         fmt::format("this perimpm reads scenes of format 1, got format {}", *number)};
    }
}

struct Section {
    const char* path;
    const std::span<const ParamSpec>& keys;
};
const Section kSections[] = {
    {"simulation", keys::kSimulation},  {"grid", keys::kGrid},     {"grid.domain", keys::kDomain},
    {"material.NAME", keys::kMaterial}, {"body.N", keys::kBody},   {"collider.N", keys::kCollider},
    {"condition.N", keys::kCondition},  {"crack.N", keys::kCrack}, {"output", keys::kOutput}};

bool declares(std::span<const ParamSpec> specs, const std::string& key) {
    return std::ranges::any_of(specs, [&](const ParamSpec& spec) { return key == spec.key; });
}

/// A key of exactly one section that stands above all of them is answered with its place.
void refuse_misplaced_keys(const Value& tree) {
    std::vector<std::string> accepted;
    for (const ParamSpec& spec : keys::kScene) accepted.emplace_back(spec.key);
    for (const auto& [key, value] : std::get<Value::Table>(tree.data)) {
        if (declares(keys::kScene, key)) continue;
        const auto owns = [&key = key](const Section& section) { return declares(section.keys, key); };
        if (std::ranges::count_if(kSections, owns) != 1) continue;
        const std::string path = fmt::format("{}.{}", std::ranges::find_if(kSections, owns)->path, key);
        throw InputError{value.place.text(),
                         fmt::format("unknown key '{}' in the scene\n  {}", key, suggestion(path, {path}, accepted))};
    }
}

constexpr double kMostFrames = 1e9;  ///< their numbers have 32 bits

SimulationSpec read_simulation(const Value& table) {
    const Reader r{table, keys::kSimulation, "simulation"};
    if (const double frames = r.number("end_time") * r.number("frame_rate"); frames > kMostFrames) {
        r.fail("frame_rate",
               fmt::format("and 'end_time' make {:g} frames; at most {:g} are supported", frames, kMostFrames));
    }
    const bool is_auto = r.text("dt") == "auto";
    const Value* dt = r.value("dt");
    return {
        .end_time = r.number("end_time"),
        .frame_rate = r.number("frame_rate"),
        .dt = is_auto ? std::nullopt : std::optional{r.number("dt")},
        .safety = r.number("safety"),
        .allow_unstable_dt = r.flag("allow_unstable_dt"),
        .precision = r.text("precision") == "float" ? Precision::single_ : Precision::double_,
        .gravity = vec3(r, "gravity", {0.0, -9.81, 0.0}),
        .damping = r.number("damping"),
        .dt_place = dt ? dt->place : table.place,
    };
}

Face face_of(const std::string& word) {
    static const std::pair<const char*, Face> kFaces[] = {{"sticky", Face::sticky},     {"slip", Face::slip},
                                                          {"separate", Face::separate}, {"open", Face::open},
                                                          {"symmetry", Face::symmetry}, {"periodic", Face::periodic}};
    return std::find_if(std::begin(kFaces), std::end(kFaces), [&](const auto& f) { return word == f.first; })->second;
}

void read_faces(const Reader& domain, GridSpec& grid) {
    const Value* given = domain.value("faces");
    if (!given || !given->is_table()) {
        std::fill(std::begin(grid.faces), std::end(grid.faces), face_of(domain.text("faces")));
        return;
    }
    const Reader faces{*given, keys::kFaces, "grid.domain.faces"};
    for (std::size_t i = 0; i < std::size(grid.faces); ++i) grid.faces[i] = face_of(faces.text(keys::kFaces[i].key));
}

/// Mirrors need nodes that are images of nodes, periodic borders a whole number of cells between them.
void check_faces(const Reader& domain, const GridSpec& grid) {
    const double dx = grid.spacing;
    for (int f = 0; f < 6; ++f) {
        const int axis = f / 2;
        const char* end = f % 2 ? "max" : "min";
        const double at = (f % 2 ? grid.domain.max() : grid.domain.min())[axis] / dx;
        if (grid.faces[f] == Face::symmetry && !on_half_cell(at))
            domain.fail(end,
                        fmt::format("puts the symmetry face {0}_{1} at {1} = {2:g} m: it must lie on a node or midway "
                                    "between two (spacing {3:g} m)\n  nearest: {4:.9g} m",
                                    end, "xyz"[axis], at * dx, dx, std::round(2 * at) / 2 * dx));
        if (grid.faces[f] != Face::periodic) continue;
        if (grid.faces[f ^ 1] != Face::periodic)
            domain.fail("faces",
                        fmt::format("makes {}_{} periodic but not the face opposite: both or none", end, "xyz"[axis]));
        const double cells = grid.domain.sizes()[axis] / dx;
        if (std::abs(cells - std::round(cells)) > 1e-6 || cells < 0.5)
            domain.fail(
                "max",
                fmt::format("makes the domain {0:g} cells long along {1}: between periodic faces it must "
                            "be a whole number\n  nearest: max {1} = {2:.9g} m",
                            cells, "xyz"[axis], grid.domain.min()[axis] + std::max(1.0, std::round(cells)) * dx));
    }
}

/// Faces nearer to each other than nodes could tell apart.
void refuse_thin_domain(const Reader& domain, const GridSpec& grid) {
    for (int c = 0; c < 3; ++c)
        if (grid.domain.sizes()[c] < 0.49 * grid.spacing)
            domain.fail("max",
                        fmt::format("makes the domain {:g} m thick along {}: at least half a cell ({:g} m) is needed",
                                    grid.domain.sizes()[c], "xyz"[c], 0.5 * grid.spacing));
}

GridSpec read_grid(const Value& table) {
    const Reader r{table, keys::kGrid, "grid"};
    GridSpec grid{.spacing = r.given("spacing") ? r.number("spacing") : 0.0,
                  .bounded = r.given("domain"),
                  .domain = {},
                  .faces = {},
                  .face_friction = 0.0};
    if (!grid.bounded) return grid;
    const Reader domain{*r.value("domain"), keys::kDomain, "grid.domain"};
    grid.domain = require_box(domain);
    grid.face_friction = domain.number("friction");
    read_faces(domain, grid);
    if (grid.spacing > 0) refuse_thin_domain(domain, grid), check_faces(domain, grid);
    return grid;
}

std::vector<MaterialSpec> read_materials(const Value& table) {
    std::vector<MaterialSpec> materials;
    for (const auto& [name, value] : std::get<Value::Table>(table.data)) {
        const std::string what = "material." + name;
        const Reader r{value, keys::kMaterial, what};
        MaterialSpec& material = materials.emplace_back();
        material.name = name;
        material.density = r.number("density");
        material.law = read_model(*r.value("constitutive"), Family::constitutive, what + ".constitutive");
        const std::string crack_surface = r.text("crack_surface");
        material.crack_surface = crack_surface == "grid"       ? CrackSurface::grid
                                 : crack_surface == "fragment" ? CrackSurface::fragment
                                                               : CrackSurface::particle;
        const Value* given = value.find("crack_surface");
        material.crack_surface_place = given ? given->place : value.place;
        if (r.given("pieces")) {
            if (!r.given("fracture"))
                r.fail("pieces", "says where bonds break, but without 'fracture' none does: add a criterion");
            material.pieces = static_cast<std::uint32_t>(r.integer("pieces"));
        }
        material.pieces_seed = static_cast<std::uint64_t>(r.integer("pieces_seed"));
        if (!r.given("fracture")) continue;
        material.criterion = read_model(*r.value("fracture"), Family::fracture, what + ".fracture");
    }
    return materials;
}

std::vector<std::string> read_words(const Reader& r, const char* key, std::vector<std::string> fallback) {
    const Value* value = r.value(key);
    if (!value) return fallback;
    std::vector<std::string> words;
    for (const Value& element : std::get<Value::List>(value->data)) {
        const auto* word = std::get_if<std::string>(&element.data);
        if (!word)
            throw InputError{element.place.text(),
                             fmt::format("'{}' in {} must hold texts, got {}", key, r.what(), element.kind())};
        if (std::find(words.begin(), words.end(), *word) != words.end()) {
            throw InputError{element.place.text(), fmt::format("'{}' in {} names '{}' twice", key, r.what(), *word)};
        }
        words.push_back(*word);
    }
    return words;
}

OutputSpec read_output(const Value& table) {
    static const std::vector<std::string> kFormats = {"hdf5"};
    const Reader r{table, keys::kOutput, "output"};
    OutputSpec output{read_words(r, "fields", {"x", "v", "id"}), read_words(r, "formats", kFormats)};
    for (const std::string& format : output.formats) {
        if (std::find(kFormats.begin(), kFormats.end(), format) != kFormats.end()) continue;
        r.fail("formats", fmt::format("does not know '{}'\n  {}", format, suggestion(format, kFormats)));
    }
    const bool has_positions = std::find(output.fields.begin(), output.fields.end(), "x") != output.fields.end();
    if (!output.formats.empty() && !has_positions) r.fail("fields", "must hold \"x\": frames need positions");
    return output;
}

}  // namespace

Scene read_scene(Value tree, const std::string& folder) {
    set_path(tree, "");
    require_known_format(tree);
    refuse_misplaced_keys(tree);
    const Reader r{tree, keys::kScene, "the scene"};
    Scene scene;
    scene.title = r.text("title");
    scene.folder = folder;
    scene.simulation = read_simulation(section(r, "simulation"));
    scene.grid = read_grid(section(r, "grid"));
    scene.output = read_output(section(r, "output"));
    bool needs_grid = false;
    scene.transfer = read_transfer(section(r, "transfer"), scene.grid.spacing, needs_grid);
    if (needs_grid && scene.grid.spacing == 0.0) {
        throw InputError{
            (r.given("grid") ? section(r, "grid") : tree).place.text(),
            fmt::format("missing key 'spacing' [m] in grid: the transfer '{}' works on a grid", scene.transfer.type)};
    }
    scene.materials = read_materials(section(r, "material"));
    scene.bodies = read_bodies(r, scene);
    scene.colliders = read_colliders(r, folder);
    scene.conditions = read_conditions(r, scene);
    scene.cracks = read_cracks(r, scene);
    scene.source = std::move(tree);
    return scene;
}

}  // namespace perimpm
