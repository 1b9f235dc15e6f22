#include "scene/shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string_view>

#include "perimpm/error.hpp"
#include "perimpm/scene/scene.hpp"
#include "scene/checks.hpp"
#include "scene/keys.hpp"
#include "scene/nearby.hpp"
#include "scene/vectors.hpp"

namespace perimpm {
namespace {

namespace fs = std::filesystem;

struct Kind {
    const char* type;
    std::uint32_t dimension;  ///< 3: solids, 2: sheets, 1: strands
    const std::span<const ParamSpec>& keys;
    void (*check)(const Reader&, const std::string& folder);
    ShapePtr (*build)(const Reader&, const std::string& folder, double voxel_size);  ///< solids
};

std::string mesh_path(const Reader& r, const std::string& folder) { return fs::path{folder} / r.text("file"); }

void check_box(const Reader& r, const std::string&) { require_box(r); }

void check_cylinder(const Reader& r, const std::string&) {
    if (vec3(r, "start") == vec3(r, "end")) r.fail("end", "must differ from 'start'");
}

void check_plane(const Reader& r, const std::string&) {
    if (vec3(r, "normal").isZero(0.0)) r.fail("normal", "must not be zero");
}

void check_mesh(const Reader& r, const std::string& folder) {
    if (fs::is_regular_file(mesh_path(r, folder))) return;
    r.fail("file", fmt::format("names '{}', but there is no such file{}", r.text("file"),
                               nearby_files(mesh_path(r, folder), {".obj", ".ply", ".stl", ".gltf", ".glb"})));
}

std::vector<Vec3> corners(const Reader& r) {
    static constexpr ParamSpec kComponent{.key = "points", .unit = "m"};
    std::vector<Vec3> points;
    for (const Value& value : std::get<Value::List>(r.value("points")->data)) {
        const auto* list = std::get_if<Value::List>(&value.data);
        if (!list || list->size() != 3) r.fail("points", "must hold points [x, y, z] in m, got " + value.to_toml());
        Vec3& x = points.emplace_back();
        for (int c = 0; c < 3; ++c) x[c] = require_number((*list)[static_cast<std::size_t>(c)], kComponent, r.what());
    }
    return points;
}

void check_polyline(const Reader& r, const std::string&) {
    const std::vector<Vec3> points = corners(r);
    if (points.size() < 2) r.fail("points", fmt::format("must hold two points or more, got {}", points.size()));
    const auto twice = std::adjacent_find(points.begin(), points.end());
    if (twice != points.end())
        r.fail("points", fmt::format("must differ from one to the next: points {} and {} are the same",
                                     twice - points.begin(), twice - points.begin() + 1));
}

MeshPlacement placement(const Reader& r) { return {r.number("scale"), vec3(r, "rotation"), vec3(r, "translation")}; }

ShapePtr build_mesh(const Reader& r, const std::string& folder, double voxel_size) {
    return make_mesh(mesh_path(r, folder), placement(r), voxel_size);
}

const Kind kKinds[] = {
    {"box", 3, keys::kBox, check_box,
     [](const Reader& r, const std::string&, double) { return make_box(vec3(r, "min"), vec3(r, "max")); }},
    {"sphere", 3, keys::kSphere, [](const Reader&, const std::string&) {},
     [](const Reader& r, const std::string&, double) { return make_sphere(vec3(r, "center"), r.number("radius")); }},
    {"cylinder", 3, keys::kCylinder, check_cylinder,
     [](const Reader& r, const std::string&, double) {
         return make_cylinder(vec3(r, "start"), vec3(r, "end"), r.number("radius"));
     }},
    {"mesh", 3, keys::kMesh, check_mesh, build_mesh},
    {"rectangle", 2, keys::kRectangle, [](const Reader& r, const std::string&) { check_rectangle(r); }, nullptr},
    {"polyline", 1, keys::kPolyline, check_polyline, nullptr},
    {"plane", 3, keys::kPlane, check_plane,
     [](const Reader& r, const std::string&, double) { return make_half_space(vec3(r, "point"), vec3(r, "normal")); }},
};

const Kind& kind_of(const Value& shape, const std::string& what) {
    std::vector<std::string> types;
    for (const Kind& kind : kKinds) types.emplace_back(kind.type);
    const std::string type = read_type(shape, what, types);
    return *std::find_if(std::begin(kKinds), std::end(kKinds), [&](const Kind& kind) { return kind.type == type; });
}

Reader read_shape(const Value& shape, const Kind& kind, const std::string& what) {
    static constexpr const char* kType[] = {"type"};
    return Reader{shape, kind.keys, fmt::format("{} ('{}')", what, kind.type), kType};
}

void refuse_thin(const Value& shape, const Kind& kind, const std::string& what) {
    if (kind.build) return;
    throw InputError{
        shape.find("type")->place.text(),
        fmt::format("{}: a {} has no inside: it is for bodies\n  use a box, sphere, cylinder, mesh or plane", what,
                    kind.type)};
}

}  // namespace

void check_rectangle(const Reader& r) {
    const Vec3 u = vec3(r, "edge_u"), v = vec3(r, "edge_v");
    if (u.isZero(0.0)) r.fail("edge_u", "must not be zero");
    if (v.isZero(0.0)) r.fail("edge_v", "must not be zero");
    if (std::abs(u.dot(v)) > 1e-6 * u.norm() * v.norm()) r.fail("edge_v", "must be at right angles to 'edge_u'");
}

void check_shape(const Value& shape, const std::string& owner, const std::string& folder, bool for_body) {
    const std::string what = "shape of " + owner;
    const Kind& kind = kind_of(shape, what);
    if (for_body && std::string_view{kind.type} == "plane") {
        throw InputError{shape.find("type")->place.text(),
                         fmt::format("{}: a plane has no end and cannot be filled with particles\n  use a box, sphere, "
                                     "cylinder or mesh, or make the plane a [[collider]]",
                                     what)};
    }
    if (!for_body) refuse_thin(shape, kind, what);
    kind.check(read_shape(shape, kind, what), folder);
}

std::uint32_t shape_dimension(const Value& shape) { return kind_of(shape, "shape").dimension; }

std::span<const ParamSpec> shape_keys(const Value& shape) { return kind_of(shape, "shape").keys; }

ShapePtr build_shape(const Value& shape, const std::string& folder, double voxel_size) {
    const Kind& kind = kind_of(shape, "shape");
    refuse_thin(shape, kind, "shape");
    const Reader reader = read_shape(shape, kind, "shape");
    kind.check(reader, folder);
    return kind.build(reader, folder, voxel_size);
}

double layer_count(const BodySpec& body, double spacing) {
    const Kind& kind = kind_of(body.shape, "shape");
    const Reader r = read_shape(body.shape, kind, "shape");
    if (kind.dimension == 2) return vec3(r, "edge_u").norm() * vec3(r, "edge_v").norm() / (spacing * spacing);
    double length = 0;
    if (kind.dimension == 1) {
        const std::vector<Vec3> points = corners(r);
        for (std::size_t k = 1; k < points.size(); ++k) length += (points[k] - points[k - 1]).norm();
    }
    return length / spacing;
}

LayerSample sample_layer(const BodySpec& body, const std::string& folder, double spacing) {
    const Kind& kind = kind_of(body.shape, "shape");
    const Reader r = read_shape(body.shape, kind, "shape");
    kind.check(r, folder);
    if (body.dimension == 1) return sample_polyline(corners(r), spacing);
    if (kind.dimension == 2) return sample_rectangle(vec3(r, "corner"), vec3(r, "edge_u"), vec3(r, "edge_v"), spacing);
    return sample_mesh_surface(mesh_path(r, folder), placement(r), spacing, body.seed);
}

TriangleMesh read_triangles(const Value& shape, const std::string& folder) {
    const Reader r = read_shape(shape, kind_of(shape, "shape"), "shape");
    return read_mesh(mesh_path(r, folder), placement(r));
}

}  // namespace perimpm
