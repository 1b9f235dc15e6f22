#include <fmt/format.h>

#include <charconv>
#include <utility>

#include "perimpm/error.hpp"
#include "perimpm/scene/tree.hpp"

namespace perimpm {
namespace {

/// Keys of a dotted path in TOML's own notation, so that quoted keys work too.
std::vector<std::string> split_path(const std::string& path) {
    std::vector<std::string> keys;
    try {
        const Value tree = parse_scene_text(path + " = 0", "--set");
        for (const Value* node = &tree; node->is_table();) {
            const auto& [key, child] = std::get<Value::Table>(node->data).front();
            keys.push_back(key);
            node = &child;
        }
    } catch (const InputError&) {
        throw InputError{"--set " + path, "the name is not a dotted path, e.g. material.rubber.density"};
    }
    return keys;
}

Value parse_value(const std::string& path, const std::string& text) {
    try {
        Value tree = parse_scene_text("v = " + text, "--set");
        auto& entries = std::get<Value::Table>(tree.data);
        if (entries.size() == 1) return std::move(entries.front().second);
    } catch (const InputError&) {
        // The parser's position would count in a line that the user never wrote; the text itself says more.
    }
    const bool is_word = text.find_first_of("{}[]\"'=") == std::string::npos;
    throw InputError{
        "--set " + path,
        fmt::format("'{}' is not a TOML value\n  {}", text,
                    is_word ? fmt::format("a text needs quotes: --set '{}=\"{}\"'", path, text)
                            : "is a bracket or a quote missing? --set 'name={ key = 1.0, other = \"text\" }'")};
}

/// The place of an override is its dotted path.
void forget_position(Value& value) {
    value.place = {};
    if (auto* table = std::get_if<Value::Table>(&value.data)) {
        for (auto& entry : *table) forget_position(entry.second);
    } else if (auto* list = std::get_if<Value::List>(&value.data)) {
        for (Value& element : *list) forget_position(element);
    }
}

Value& element(Value::List& list, const std::string& key, const std::string& path) {
    std::size_t i = 0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), i);
    if (error != std::errc{} || end != key.data() + key.size()) {
        throw InputError{"--set " + path, fmt::format("'{}' must be the index of a list element (0, 1, ...)", key)};
    }
    if (i >= list.size()) {
        throw InputError{"--set " + path, fmt::format("index {} is out of range: the list has {} element{}", i,
                                                      list.size(), list.size() == 1 ? "" : "s")};
    }
    return list[i];
}

/// The entry `key` of a table or list; made in a table when missing.
Value& child(Value& parent, const std::string& key, const std::string& path) {
    if (auto* list = std::get_if<Value::List>(&parent.data)) return element(*list, key, path);
    if (!parent.is_table()) {
        throw InputError{"--set " + path,
                         fmt::format("'{}' is {}; it has no entry '{}'", parent.place.path, parent.kind(), key)};
    }
    if (Value* found = parent.find(key)) return *found;
    return std::get<Value::Table>(parent.data).emplace_back(key, Value{Value::Table{}, {}}).second;
}

/// Materials have names of the scene's choice: a key of one that it lacks is a slip, not the beginning of a new material.
void require_material(const Value& scene, const std::vector<std::string>& keys, const std::string& path) {
    if (keys.size() < 3 || keys.front() != "material") return;
    const Value* materials = scene.find("material");
    if (materials && (!materials->is_table() || materials->find(keys[1]))) return;
    std::vector<std::string> names;
    if (materials)
        for (const auto& entry : std::get<Value::Table>(materials->data)) names.push_back(entry.first);
    throw InputError{"--set " + path,
                     fmt::format("the scene has no material '{}'\n  {}", keys[1], suggestion(keys[1], names))};
}

}  // namespace

void apply_override(Value& scene, const std::string& assignment) {
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos) {
        throw InputError{"--set " + assignment, "expected NAME=VALUE, e.g. material.rubber.density=900"};
    }
    const std::string path = assignment.substr(0, equals);
    Value value = parse_value(path, assignment.substr(equals + 1));
    forget_position(value);
    const std::vector<std::string> keys = split_path(path);
    require_material(scene, keys, path);
    Value changed = scene;  // so that a refused override leaves no half-made tables behind
    Value* node = &changed;
    for (const std::string& key : keys) node = &child(*node, key, path);
    *node = std::move(value);
    set_path(changed, "");
    scene = std::move(changed);
}

}  // namespace perimpm
