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
#include "scene/nearby.hpp"

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

/// What to do about the parser's complaint; the first entry whose words it holds counts.
struct Remedy {
    const char *complaint, *advice;
};
constexpr Remedy kRemedies[] = {
    {"control characters", "a text in this line has no closing quote"},
    {"string: encountered end-of-file", "a text has no closing quote"},
    {"escape sequence", "a backslash in a text is written twice, or the text stands in 'single quotes'"},
    {"could not determine value type", "a text needs quotes, as in type = \"apic\"; a number stands alone"},
    {"expected value", "a value is missing behind the ="},
    {"expected '='", "a key is followed by = and its value"},
    {"boolean", "true and false are written in small letters"},
    {"table header: expected ']'", "close the brackets: [simulation], or [[body]] for an entry of a list"},
    {"cannot redefine existing table", "a section stands once; bodies and colliders take two brackets: [[body]]"},
    {"cannot redefine", "a key is given once"},
    {"inline table", "a table { ... } ends in the line where it begins, with commas between its keys"},
    {"array", "a list [ ... ] has commas between its values and ends with ]"},
    {"expected a comment or whitespace", "one key in a line; decimals take a point, as in 0.5"},
    {"expected decimal digit", "a number begins and ends with a digit, as in 0.5 or 1.0"},
};

std::string with_remedy(const std::string& complaint) {
    for (const Remedy& remedy : kRemedies)
        if (complaint.find(remedy.complaint) != std::string::npos) return complaint + "\n  " + remedy.advice;
    return complaint;
}

}  // namespace

Value parse_scene_text(const std::string& text, const std::string& name) {
    try {
        const toml::table table = toml::parse(std::string_view{text}, std::string_view{name});
        Value root = convert(table, {name, 0, 0, ""});
        set_path(root, "");
        return root;
    } catch (const toml::parse_error& e) {
        throw InputError{place_of(e.source(), name).text(), with_remedy(std::string{e.description()})};
    }
}

Value parse_scene_file(const std::string& path) {
    if (std::filesystem::is_directory(path)) throw InputError{path, "this is a folder, not a scene file"};
    if (!std::filesystem::exists(path))
        throw InputError{path, "there is no such scene" + nearby_files(path, {".toml"})};
    std::ifstream file{path, std::ios::binary};
    if (!file) throw InputError{path, std::string{"the scene cannot be read: "} + std::strerror(errno)};
    const std::string text{std::istreambuf_iterator<char>{file}, {}};
    return parse_scene_text(text, path);
}

}  // namespace perimpm
