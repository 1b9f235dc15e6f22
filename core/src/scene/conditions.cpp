#include "scene/conditions.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "perimpm/error.hpp"
#include "scene/checks.hpp"
#include "scene/keys.hpp"
#include "scene/named.hpp"
#include "scene/shapes.hpp"
#include "scene/vectors.hpp"

namespace perimpm {
namespace {

constexpr std::pair<const char*, Drive> kDrives[] = {{"velocity", Drive::velocity},
                                                     {"clamped", Drive::velocity},
                                                     {"acceleration", Drive::acceleration},
                                                     {"body_force", Drive::body_force},
                                                     {"force", Drive::force}};

/// The key that says what the condition does.
const char* the_drive(const Reader& r) {
    const char* given = nullptr;
    for (const auto& [key, drive] : kDrives) {
        if (!r.given(key)) continue;
        if (given) r.fail(key, fmt::format("excludes '{}'; write two conditions", given));
        given = key;
    }
    if (!given)
        throw InputError{r.table().place.text(),
                         fmt::format("{} does nothing: expected one of velocity [m/s], clamped, acceleration [m/s^2], "
                                     "body_force [N/m^3], force [N]",
                                     r.what())};
    return given;
}

/// Three numbers, some of which may be "free".
void read_velocity(const Reader& r, ConditionSpec& spec) {
    const auto& list = std::get<Value::List>(r.value("velocity")->data);
    if (list.size() != 3) r.fail("velocity", fmt::format("must hold 3 components, got {}", list.size()));
    static constexpr ParamSpec kComponent{.key = "velocity", .unit = "m/s"};
    for (int c = 0; c < 3; ++c) {
        const auto* word = std::get_if<std::string>(&list[static_cast<std::size_t>(c)].data);
        spec.free[c] = word && *word == "free";
        if (word && !spec.free[c])
            r.fail("velocity", fmt::format("must hold numbers [m/s] or \"free\", got \"{}\"", *word));
        spec.value[c] = word ? 0.0 : require_number(list[static_cast<std::size_t>(c)], kComponent, r.what());
    }
    if (spec.free[0] && spec.free[1] && spec.free[2]) r.fail("velocity", "leaves every component free");
}

std::vector<double> read_numbers(const Reader& r, const char* key) {
    std::vector<double> numbers;
    if (!r.given(key)) return numbers;
    const ParamSpec element{.key = key};
    for (const Value& value : std::get<Value::List>(r.value(key)->data))
        numbers.push_back(require_number(value, element, r.what()));
    return numbers;
}

void read_factors(const Reader& r, ConditionSpec& spec) {
    spec.times = read_numbers(r, "times"), spec.factors = read_numbers(r, "factors");
    if (spec.times.size() != spec.factors.size())
        r.fail(r.given("factors") ? "factors" : "times",
               fmt::format("must have as many numbers as its partner: {} times, "
                           "{} factors",
                           spec.times.size(), spec.factors.size()));
    if (std::adjacent_find(spec.times.begin(), spec.times.end(), std::greater_equal<>()) != spec.times.end())
        r.fail("times", "must rise from one to the next");
}

}  // namespace

ConditionSpec read_condition(const Value& table, std::size_t index, const Scene& scene, std::optional<Drive> function) {
    const std::string default_name = fmt::format("condition {}", index);
    const Reader r{table, keys::kCondition, default_name};
    ConditionSpec spec;
    spec.name = r.given("name") ? r.text("name") : default_name;
    if (const Value* shape = r.value("shape")) {
        check_shape(*shape, default_name, scene.folder, false);
        spec.shape = *shape;
    }
    spec.body = named_index(r, "body", scene.bodies);
    spec.material = named_index(r, "material", scene.materials);
    read_factors(r, spec);
    spec.source = table;
    if (function) {
        spec.drive = *function;
        return spec;
    }
    const std::string key = the_drive(r);
    spec.drive =
        std::find_if(std::begin(kDrives), std::end(kDrives), [&](const auto& d) { return key == d.first; })->second;
    if (key == "velocity")
        read_velocity(r, spec);
    else if (key != "clamped")
        spec.value = vec3(r, key.c_str());
    else if (!r.flag("clamped"))
        r.fail("clamped", "must be true, or be left out");
    return spec;
}

std::vector<ConditionSpec> read_conditions(const Reader& tree, const Scene& scene) {
    std::vector<ConditionSpec> conditions;
    if (const Value* list = tree.value("condition"))
        for (const Value& table : std::get<Value::List>(list->data))
            conditions.push_back(read_condition(table, conditions.size(), scene));
    return conditions;
}

}  // namespace perimpm
