#include "scene/bodies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "perimpm/error.hpp"
#include "scene/keys.hpp"
#include "scene/shapes.hpp"
#include "scene/vectors.hpp"

namespace perimpm {
namespace {

/// "body 0 ('ball')", or "body 0" when the table has no proper name.
std::string describe(const Value& table, const std::string& default_name) {
    const Value* name = table.find("name");
    const auto* text = name ? std::get_if<std::string>(&name->data) : nullptr;
    return text ? fmt::format("{} ('{}')", default_name, *text) : default_name;
}

/// `what`: "body" or "collider".
template <class Spec>
void require_unique_names(const std::vector<Spec>& specs, const char* what) {
    for (std::size_t i = 0; i < specs.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            if (specs[i].name != specs[j].name) continue;
            const Value* name = specs[i].source.find("name");
            throw InputError{(name ? *name : specs[i].source).place.text(),
                             fmt::format("{0} {1} and {0} {2} have the same name '{3}'", what, j, i, specs[i].name)};
        }
    }
}

const Value::List& elements(const Reader& tree, const char* key) {
    static const Value::List kNone;
    const Value* list = tree.value(key);
    return list ? std::get<Value::List>(list->data) : kNone;
}

std::uint32_t material_index(const Reader& r, const std::vector<MaterialSpec>& materials) {
    const std::string name = r.text("material");
    std::vector<std::string> names;
    for (const MaterialSpec& material : materials) names.push_back(material.name);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) {
        r.fail("material", fmt::format("names '{}', which is no [material.NAME]\n  {}", name, suggestion(name, names)));
    }
    return static_cast<std::uint32_t>(found - names.begin());
}

std::optional<double> read_particle_spacing(const Reader& r, const GridSpec& grid) {
    if (r.given("particle_spacing")) {
        if (r.given("particles_per_cell"))
            r.fail("particle_spacing", "excludes 'particles_per_cell'; give one of them");
        return r.number("particle_spacing");
    }
    if (grid.spacing == 0.0)
        r.fail("particle_spacing", "is required [m]: without grid.spacing there are no cells to fill");
    return std::nullopt;
}

/// What a body's particles fill, by its shape and by the keys that make it thin.
std::uint32_t read_dimension(const Reader& r) {
    const std::string type = std::get<std::string>(r.value("shape")->find("type")->data);
    std::uint32_t dimension = shape_dimension(*r.value("shape"));
    if (type == "mesh" && r.given("thickness")) dimension = 2;
    if (r.given("thickness") && dimension != 2)
        r.fail("thickness",
               fmt::format("is for sheets: shape \"rectangle\", or the surface of a \"mesh\", not \"{}\"", type));
    if (r.given("cross_section") && dimension != 1)
        r.fail("cross_section", fmt::format("is for strands: shape \"polyline\", not \"{}\"", type));
    for (const auto& [key, unit, thin] : {std::tuple{"thickness", "m", 2u}, std::tuple{"cross_section", "m^2", 1u}})
        if (dimension == thin && !r.given(key))
            throw InputError{
                r.table().place.text(),
                fmt::format("missing key '{}' [{}] in {}: its shape \"{}\" has no volume", key, unit, r.what(), type)};
    const bool poisson = r.text("sampling") == "poisson";
    if (dimension == 2 && type == "mesh" && !poisson)
        r.fail("sampling", "must be \"poisson\" for the surface of a mesh, which no lattice fits");
    if (dimension < 3 && type != "mesh" && poisson)
        r.fail(
            "sampling",
            fmt::format("must be \"lattice\" for the shape \"{}\"; a mesh with a thickness takes \"poisson\"", type));
    return dimension;
}

BodySpec read_body(const Value& table, std::size_t index, const Scene& scene) {
    const std::string default_name = fmt::format("body {}", index);
    const std::string what = describe(table, default_name);
    const Reader r{table, keys::kBody, what};
    check_shape(*r.value("shape"), what, scene.folder, true);
    if (r.text("sampling") == "poisson" && r.number("jitter") > 0)
        r.fail("jitter", "moves points of a lattice: Poisson points are irregular by themselves");
    const std::uint32_t dimension = read_dimension(r);
    if (dimension < 3 && r.number("jitter") > 0)
        r.fail("jitter", "moves points of solid bodies, not of sheets and strands");
    return {
        .name = r.given("name") ? r.text("name") : default_name,
        .material = material_index(r, scene.materials),
        .shape = *r.value("shape"),
        .particle_spacing = read_particle_spacing(r, scene.grid),
        .particles_per_cell = r.number("particles_per_cell"),
        .poisson = r.text("sampling") == "poisson",
        .jitter = r.number("jitter"),
        .seed = static_cast<std::uint64_t>(r.integer("seed")),
        .dimension = dimension,
        .across = dimension == 3 ? 1 : r.number(dimension == 2 ? "thickness" : "cross_section"),
        .velocity = vec3(r, "initial_velocity"),
        .angular_velocity = vec3(r, "initial_angular_velocity"),
        .source = table,
    };
}

/// A half space has no end: points far from the pivot would move at any speed, which no time step can follow.
void refuse_turning_plane(const Reader& r) {
    const Value* type = r.value("shape")->find("type");
    const bool is_plane =
        type && std::holds_alternative<std::string>(type->data) && std::get<std::string>(type->data) == "plane";
    if (is_plane && !vec3(r, "angular_velocity").isZero(0.0))
        r.fail("angular_velocity", "is for shapes that end: a plane cannot turn\n  use a box as large as is needed");
}

ColliderSpec read_collider(const Value& table, std::size_t index, const std::string& folder) {
    const std::string default_name = fmt::format("collider {}", index);
    const std::string what = describe(table, default_name);
    const Reader r{table, keys::kCollider, what};
    check_shape(*r.value("shape"), what, folder, false);
    refuse_turning_plane(r);
    const std::string contact = r.text("contact");
    return {
        .name = r.given("name") ? r.text("name") : default_name,
        .shape = *r.value("shape"),
        .contact = contact == "sticky" ? Contact::sticky
                   : contact == "slip" ? Contact::slip
                                       : Contact::separate,
        .friction = r.number("friction"),
        .velocity = vec3(r, "velocity"),
        .angular_velocity = vec3(r, "angular_velocity"),
        .pivot = vec3(r, "pivot"),
        .source = table,
    };
}

}  // namespace

std::vector<BodySpec> read_bodies(const Reader& tree, const Scene& scene) {
    std::vector<BodySpec> bodies;
    for (const Value& table : elements(tree, "body")) bodies.push_back(read_body(table, bodies.size(), scene));
    if (bodies.empty()) throw InputError{tree.table().place.text(), "nothing to simulate: the scene has no [[body]]"};
    require_unique_names(bodies, "body");
    return bodies;
}

std::vector<ColliderSpec> read_colliders(const Reader& tree, const std::string& folder) {
    std::vector<ColliderSpec> colliders;
    for (const Value& table : elements(tree, "collider")) {
        colliders.push_back(read_collider(table, colliders.size(), folder));
    }
    require_unique_names(colliders, "collider");
    return colliders;
}

}  // namespace perimpm
