#include "scene/shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "perimpm/error.hpp"
#include "perimpm/scene/scene.hpp"
#include "scene/keys.hpp"
#include "scene/vectors.hpp"

namespace perimpm {
namespace {

namespace fs = std::filesystem;

struct Kind {
    const char* type;
    const std::span<const ParamSpec>& keys;
    void (*check)(const Reader&, const std::string& folder);
    ShapePtr (*build)(const Reader&, const std::string& folder, double voxel_size);
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
    r.fail("file", fmt::format("names '{}', which is not in the folder searched: {}", r.text("file"),
                               fs::absolute(mesh_path(r, folder)).lexically_normal().parent_path().string()));
}

ShapePtr build_mesh(const Reader& r, const std::string& folder, double voxel_size) {
    return make_mesh(mesh_path(r, folder), {r.number("scale"), vec3(r, "rotation"), vec3(r, "translation")},
                     voxel_size);
}

const Kind kKinds[] = {
    {"box", keys::kBox, check_box,
     [](const Reader& r, const std::string&, double) { return make_box(vec3(r, "min"), vec3(r, "max")); }},
    {"sphere", keys::kSphere, [](const Reader&, const std::string&) {},
     [](const Reader& r, const std::string&, double) { return make_sphere(vec3(r, "center"), r.number("radius")); }},
    {"cylinder", keys::kCylinder, check_cylinder,
     [](const Reader& r, const std::string&, double) {
         return make_cylinder(vec3(r, "start"), vec3(r, "end"), r.number("radius"));
     }},
    {"mesh", keys::kMesh, check_mesh, build_mesh},
    {"plane", keys::kPlane, check_plane,
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

}  // namespace

void check_shape(const Value& shape, const std::string& owner, const std::string& folder, bool for_body) {
    const std::string what = "shape of " + owner;
    const Kind& kind = kind_of(shape, what);
    if (for_body && std::string_view{kind.type} == "plane") {
        throw InputError{shape.find("type")->place.text(),
                         fmt::format("{}: a plane has no end and cannot be filled with particles\n  use a box, sphere, "
                                     "cylinder or mesh, or make the plane a [[collider]]",
                                     what)};
    }
    kind.check(read_shape(shape, kind, what), folder);
}

std::span<const ParamSpec> shape_keys(const Value& shape) { return kind_of(shape, "shape").keys; }

ShapePtr build_shape(const Value& shape, const std::string& folder, double voxel_size) {
    const Kind& kind = kind_of(shape, "shape");
    const Reader reader = read_shape(shape, kind, "shape");
    kind.check(reader, folder);
    return kind.build(reader, folder, voxel_size);
}

}  // namespace perimpm
