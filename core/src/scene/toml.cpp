#include <toml++/toml.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <tuple>

#include "perimpm/error.hpp"
#include "perimpm/scene/tree.hpp"

namespace perimpm {
namespace {

Place place_of(const toml::source_region& region, const std::string& file) {
    return {file, static_cast<int>(region.begin.line), static_cast<int>(region.begin.column), ""};
}

Value convert(const toml::node& node, const Place& place);

/// toml++ keeps tables sorted by key; the order of appearance follows from the positions.
Value::Table convert_table(const toml::table& table, const std::string& file) {
    Value::Table result;
    for (const auto& [key, node] : table) {
        result.emplace_back(std::string{key.str()}, convert(node, place_of(key.source(), file)));
    }
    const auto position = [](const auto& entry) {
        return std::tuple{entry.second.place.line, entry.second.place.column};
    };
    std::sort(result.begin(), result.end(), [&](const auto& a, const auto& b) { return position(a) < position(b); });
    return result;
}

Value::List convert_list(const toml::array& array, const std::string& file) {
    Value::List result;
    for (const toml::node& node : array) result.push_back(convert(node, place_of(node.source(), file)));
    return result;
}

Value convert(const toml::node& node, const Place& place) {
    Value value{{}, place};
    if (const auto* table = node.as_table()) {
        value.data = convert_table(*table, place.file);
    } else if (const auto* array = node.as_array()) {
        value.data = convert_list(*array, place.file);
    } else if (const auto* flag = node.as_boolean()) {
        value.data = flag->get();
    } else if (const auto* integer = node.as_integer()) {
        value.data = integer->get();
    } else if (const auto* number = node.as_floating_point()) {
        value.data = number->get();
    } else if (const auto* text = node.as_string()) {
        value.data = text->get();
    } else {
        throw InputError{place.text(), "dates and times have no use in a scene; a text needs quotes"};
    }
    return value;
}

}  // namespace

Value parse_scene_text(const std::string& text, const std::string& name) {
    try {
        const toml::table table = toml::parse(std::string_view{text}, std::string_view{name});
        Value root = convert(table, {name, 0, 0, ""});
        set_path(root, "");
        return root;
    } catch (const toml::parse_error& e) {
        throw InputError{place_of(e.source(), name).text(), std::string{e.description()}};
    }
}

Value parse_scene_file(const std::string& path) {
    if (std::filesystem::is_directory(path)) throw InputError{path, "this is a folder, not a scene file"};
    std::ifstream file{path, std::ios::binary};
    if (!file) throw InputError{path, std::string{"the scene cannot be read: "} + std::strerror(errno)};
    const std::string text{std::istreambuf_iterator<char>{file}, {}};
    return parse_scene_text(text, path);
}

}  // namespace perimpm
