#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "perimpm/export.hpp"

namespace perimpm {

/// Where a value was given: a scene file's line, or the dotted path of a Python dict or of --set.
struct Place {
    std::string file;
    int line = 0;
    int column = 0;
    std::string path;  ///< dotted path inside the scene, e.g. "material.rubber.constitutive"

    /// "bar.toml:8:52", or the dotted path when there is no file.
    PERIMPM_API std::string text() const;
};

/// One node of a scene before validation; TOML files and Python dicts both become this tree.
class PERIMPM_API Value {
public:
    using List = std::vector<Value>;
    using Table = std::vector<std::pair<std::string, Value>>;  ///< in order of appearance

    std::variant<std::monostate, bool, std::int64_t, double, std::string, List, Table> data;
    Place place;  ///< of the key for an entry of a table, of the value itself in a list

    const Value* find(const std::string& key) const;
    Value* find(const std::string& key);
    bool is_table() const { return std::holds_alternative<Table>(data); }
    bool is_list() const { return std::holds_alternative<List>(data); }
    /// "a number", "a table", ... for error messages.
    std::string kind() const;
    /// The value as TOML text (tables inline), for run.json and messages.
    std::string to_toml() const;
    /// The value as JSON text. Throws InputError for NaN and infinity, which JSON does not have.
    std::string to_json() const;
};

/// Reads a scene file. Throws InputError with file, line and column.
PERIMPM_API Value parse_scene_file(const std::string& path);
/// The same from text; `name` stands for the file in messages.
PERIMPM_API Value parse_scene_text(const std::string& text, const std::string& name);
/// Sets the dotted path of a value and of everything inside it; the root's path is "".
PERIMPM_API void set_path(Value& value, const std::string& path);
/// Applies "a.b.c=value" (value in TOML). A table replaces the whole table; tables on the way that are missing are
/// made. List elements by index: "body.0.particles_per_cell=27"; the element must exist, and so must the material
/// of "material.rubber.density=900". A value that is not valid TOML is an error that shows the text and proposes quotes.
PERIMPM_API void apply_override(Value& scene, const std::string& assignment);

}  // namespace perimpm
