#include "scene/cracks.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "perimpm/error.hpp"
#include "scene/keys.hpp"
#include "scene/named.hpp"
#include "scene/shapes.hpp"
#include "scene/vectors.hpp"

namespace perimpm {
namespace {

struct Kind {
    const char* type;
    const std::span<const ParamSpec>& keys;
    Patch (*read)(const Reader&);  ///< null: triangles, whose file is read when the crack opens
};

Vec3 direction(const Reader& r, const char* key) {
    const Vec3 v = vec3(r, key);
    if (v.isZero(0.0)) r.fail(key, "must not be zero");
    return v;
}

const Kind kKinds[] = {
    {"rectangle", keys::kRectangle,
     [](const Reader& r) {
         check_rectangle(r);
         const Vec3 u = vec3(r, "edge_u"), v = vec3(r, "edge_v");
         return Patch{.origin = vec3(r, "corner"), .normal = u.cross(v), .edge_u = u, .edge_v = v};
     }},
    {"disc", keys::kDisc,
     [](const Reader& r) {
         return Patch{.origin = vec3(r, "center"), .normal = direction(r, "normal"), .radius = r.number("radius")};
     }},
    {"plane", keys::kPlane,
     [](const Reader& r) { return Patch{.origin = vec3(r, "point"), .normal = direction(r, "normal")}; }},
    {"mesh", keys::kMesh, nullptr},
};

const Kind& kind_of(const Value& shape, const std::string& what) {
    std::vector<std::string> types;
    for (const Kind& kind : kKinds) types.emplace_back(kind.type);
    const std::string type = read_type(shape, what, types);
    return *std::find_if(std::begin(kKinds), std::end(kKinds), [&](const Kind& kind) { return kind.type == type; });
}

CrackSpec read_crack(const Value& table, std::size_t index, const Scene& scene) {
    static constexpr const char* kType[] = {"type"};
    const std::string default_name = fmt::format("crack {}", index);
    const Reader r{table, keys::kCrack, default_name};
    const std::string what = "shape of " + default_name;
    const Value& shape = *r.value("shape");
    const Kind& kind = kind_of(shape, what);
    std::optional<Patch> patch;
    if (kind.read)
        patch = kind.read(Reader{shape, kind.keys, fmt::format("{} ('{}')", what, kind.type), kType});
    else
        check_shape(shape, default_name, scene.folder, false);
    return {.name = r.given("name") ? r.text("name") : default_name,
            .patch = patch,
            .body = named_index(r, "body", scene.bodies),
            .source = table};
}

}  // namespace

std::span<const ParamSpec> patch_keys(const Value& shape) { return kind_of(shape, "shape").keys; }

std::vector<CrackSpec> read_cracks(const Reader& tree, const Scene& scene) {
    std::vector<CrackSpec> cracks;
    if (const Value* list = tree.value("crack"))
        for (const Value& table : std::get<Value::List>(list->data))
            cracks.push_back(read_crack(table, cracks.size(), scene));
    return cracks;
}

}  // namespace perimpm
