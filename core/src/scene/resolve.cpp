#include <filesystem>

#include "perimpm/error.hpp"
#include "perimpm/scene/scene.hpp"
#include "scene/checks.hpp"
#include "scene/cracks.hpp"
#include "scene/keys.hpp"
#include "scene/shapes.hpp"

namespace perimpm {
namespace {

Value default_value(const ParamSpec& spec) {
    Value value;
    if (spec.default_text && (spec.kind == ParamKind::vector || spec.kind == ParamKind::list))
        return *parse_scene_text(std::string{"v = "} + spec.default_text, spec.key).find("v");
    if (spec.default_text)
        value.data = std::string{spec.default_text};
    else if (spec.kind == ParamKind::boolean)
        value.data = spec.default_value != 0.0;
    else if (spec.kind == ParamKind::integer)
        value.data = static_cast<std::int64_t>(spec.default_value);
    else
        value.data = spec.default_value;
    return value;
}

/// Keeps what is given, "type" first, then every key in the declared order with its default.
void complete(Value& table, std::span<const ParamSpec> specs) {
    Value::Table whole;
    if (const Value* type = table.find("type")) whole.emplace_back("type", *type);
    for (const ParamSpec& spec : specs) {
        if (const Value* given = table.find(spec.key))
            whole.emplace_back(spec.key, *given);
        else if (has_default(spec))
            whole.emplace_back(spec.key, default_value(spec));
    }
    table.data = std::move(whole);
}

/// The entry `key` of a table, made when missing.
Value& entry(Value& table, const char* key) {
    if (Value* found = table.find(key)) return *found;
    return std::get<Value::Table>(table.data).emplace_back(key, Value{Value::Table{}, {}}).second;
}

void erase(Value& table, const char* key) {
    std::erase_if(std::get<Value::Table>(table.data), [key](const auto& e) { return e.first == key; });
}

/// Whether the model takes these values as if the scene had given them.
template <template <class> class Interface>
bool accepts(const ModelSpec& model, const std::vector<ParamValue>& values, const ModelContext& context) {
    const auto specs = model.params->specs();
    try {
        create<Interface, double>(
            model.type, Params(specs.data(), values.data(), static_cast<std::uint32_t>(specs.size()), context));
        return true;
    } catch (const InvalidParameter&) {
        return false;
    }
}

template <template <class> class Interface>
void complete_model(Value& table, const ModelSpec& model, const ModelContext& context) {
    const auto specs = model.params->specs();
    complete(table, specs);
    for (const ParamSpec& spec : specs)
        if (const ModelSpec* inner = model.params->model(spec.key))
            complete_model<ConstitutiveLaw>(entry(table, spec.key), *inner, context);
    std::vector<ParamValue> values(model.params->values().begin(), model.params->values().end());
    for (std::size_t i = 0; i < specs.size(); ++i) {
        if (values[i].given || !has_default(specs[i])) continue;
        values[i].given = true;
        if (accepts<Interface>(model, values, context)) continue;
        values[i].given = false;
        erase(table, specs[i].key);
    }
}

/// The first body of a material, of which its law hears; null when there is none.
const BodySpec* first_body(const Scene& scene, std::uint32_t material) {
    for (const BodySpec& body : scene.bodies)
        if (body.material == material) return &body;
    return nullptr;
}

void complete_grid(Value& grid) {
    complete(grid, keys::kGrid);
    Value* domain = grid.find("domain");
    if (!domain) return;
    complete(*domain, keys::kDomain);
    if (Value* faces = domain->find("faces"); faces->is_table()) complete(*faces, keys::kFaces);
}

void complete_materials(Value& table, const Scene& scene) {
    for (std::uint32_t m = 0; m < scene.materials.size(); ++m) {
        const MaterialSpec& material = scene.materials[m];
        const BodySpec* body = first_body(scene, m);
        if (!body) continue;  // nothing creates the models of a material without bodies
        const ModelContext context{material.density, body->spacing(scene.grid), scene.grid.spacing, body->dimension,
                                   body->across};
        Value& own = entry(table, material.name.c_str());
        complete_model<ConstitutiveLaw>(entry(own, "constitutive"), material.law, context);
        if (material.criterion.params)
            complete_model<FractureCriterion>(entry(own, "fracture"), material.criterion, context);
    }
}

/// Mesh files get their whole paths.
void complete_shape(Value& shape, std::span<const ParamSpec> keys, const std::string& folder) {
    complete(shape, keys);
    if (Value* file = shape.find("file"); file && std::get<std::string>(shape.find("type")->data) == "mesh")
        file->data = std::filesystem::absolute(std::filesystem::path{folder} / std::get<std::string>(file->data))
                         .lexically_normal()
                         .string();
}

/// A body, collider or condition: its name, its keys, its shape.
template <class Spec>
void complete_part(Value& table, const Spec& spec, std::span<const ParamSpec> keys, const std::string& folder) {
    entry(table, "name").data = spec.name;
    complete(table, keys);
    if (!table.find("shape")) return;  // a condition without one is for all particles
    Value& shape = entry(table, "shape");
    complete_shape(shape, shape_keys(shape), folder);
}

}  // namespace

Value resolved_scene(const Scene& scene) {
    Value tree = scene.source;
    complete(tree, keys::kScene);
    complete(entry(tree, "simulation"), keys::kSimulation);
    complete(entry(tree, "output"), keys::kOutput);
    if (Value* grid = tree.find("grid")) complete_grid(*grid);
    complete_model<TransferKernel>(entry(tree, "transfer"), scene.transfer, {.grid_spacing = scene.grid.spacing});
    complete_materials(entry(tree, "material"), scene);
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
        Value& body = std::get<Value::List>(entry(tree, "body").data)[b];
        complete_part(body, scene.bodies[b], keys::kBody, scene.folder);
        if (scene.bodies[b].particle_spacing) erase(body, "particles_per_cell");
    }
    for (std::size_t c = 0; c < scene.colliders.size(); ++c)
        complete_part(std::get<Value::List>(entry(tree, "collider").data)[c], scene.colliders[c], keys::kCollider,
                      scene.folder);
    for (std::size_t c = 0; c < scene.conditions.size(); ++c)
        complete_part(std::get<Value::List>(entry(tree, "condition").data)[c], scene.conditions[c], keys::kCondition,
                      scene.folder);
    for (std::size_t c = 0; c < scene.cracks.size(); ++c) {
        Value& crack = std::get<Value::List>(entry(tree, "crack").data)[c];
        entry(crack, "name").data = scene.cracks[c].name;
        complete(crack, keys::kCrack);
        complete_shape(entry(crack, "shape"), patch_keys(entry(crack, "shape")), scene.folder);
    }
    return tree;
}

}  // namespace perimpm
