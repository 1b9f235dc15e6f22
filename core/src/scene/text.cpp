// A tree as TOML and JSON text. Scalars are written alike in both: JSON's numbers and escapes are valid TOML.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>

#include "perimpm/error.hpp"
#include "perimpm/scene/tree.hpp"

namespace perimpm {
namespace {

template <class Scalar>
std::string scalar(const Scalar& value) {
    return nlohmann::json(value).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

bool is_bare_key(const std::string& key) {
    const auto is_bare = [](unsigned char c) { return (c < 128 && std::isalnum(c)) || c == '_' || c == '-'; };
    return !key.empty() && std::all_of(key.begin(), key.end(), is_bare);
}

struct Writer {
    const char *open_table, *equals, *close_table, *nothing;
    bool is_json;
    const Place& place;

    std::string operator()(std::monostate) const { return nothing; }
    std::string operator()(bool b) const { return scalar(b); }
    std::string operator()(std::int64_t i) const { return scalar(i); }
    std::string operator()(const std::string& s) const { return scalar(s); }
    std::string operator()(double x) const {
        if (std::isfinite(x)) return scalar(x);
        if (is_json) throw InputError{place.text(), "JSON has no NaN and no infinity"};
        return std::isnan(x) ? "nan" : x > 0 ? "inf" : "-inf";
    }
    std::string operator()(const Value::List& list) const {
        std::string text = "[";
        for (const Value& value : list) text += (text.size() > 1 ? ", " : "") + write(value);
        return text + "]";
    }
    std::string operator()(const Value::Table& table) const {
        std::string entries;
        for (const auto& [key, value] : table) {
            const std::string name = !is_json && is_bare_key(key) ? key : scalar(key);
            entries += (entries.empty() ? "" : ", ") + name + equals + write(value);
        }
        return entries.empty() ? "{}" : open_table + entries + close_table;
    }

private:
    std::string write(const Value& value) const {
        return std::visit(Writer{open_table, equals, close_table, nothing, is_json, value.place}, value.data);
    }
};

}  // namespace

std::string Value::to_toml() const { return std::visit(Writer{"{ ", " = ", " }", "\"\"", false, place}, data); }
std::string Value::to_json() const { return std::visit(Writer{"{", ": ", "}", "null", true, place}, data); }

}  // namespace perimpm
