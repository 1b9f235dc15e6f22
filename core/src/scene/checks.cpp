#include "scene/checks.hpp"

#include <fmt/format.h>

#include <cmath>
#include <sstream>
#include <string_view>

#include "perimpm/error.hpp"

namespace perimpm {
namespace {

bool carries_number(const ParamSpec& spec) {
    return spec.kind == ParamKind::number || spec.kind == ParamKind::integer || spec.kind == ParamKind::vector;
}

std::string expected_kind(const ParamSpec& spec) {
    switch (spec.kind) {
        case ParamKind::number:
            return spec.per_particle ? "a number or a ramp { from, to, start, end }" : "a number";
        case ParamKind::integer:
            return "an integer";
        case ParamKind::boolean:
            return "true or false";
        case ParamKind::text:
            return "a text";
        case ParamKind::choice:
            return "one of";
        case ParamKind::vector:
            return "a list of 3 numbers";
        case ParamKind::table:
            return "a table";
        case ParamKind::list:
            return "a list";
        case ParamKind::model:
            return "a table { type = constitutive plugin, its parameters }";
    }
    return "a value";
}

/// `"a", "b"` after the kind, for keys that take words.
std::string expected_words(const ParamSpec& spec) {
    if (!spec.choices) return "";
    const std::vector<std::string> choices = split_choices(spec.choices);
    std::string words;
    for (const std::string& word : choices) words += (words.empty() ? "\"" : ", \"") + word + '"';
    if (spec.kind == ParamKind::choice) return " " + words;
    return (choices.size() > 1 ? " or one of " : " or ") + words;
}

/// For the usual slips: a model or shape named by its bare type, one bracket too few, a number in quotes.
std::string remedy(const Value& value, const ParamSpec& spec) {
    const bool takes_type = spec.kind == ParamKind::model ||
                            (spec.kind == ParamKind::table && std::string_view{spec.doc}.starts_with("{ type"));
    if (takes_type && std::holds_alternative<std::string>(value.data))
        return fmt::format("\n  write {} = {{ type = {}, ... }}", spec.key, value.to_toml());
    if (spec.kind == ParamKind::list && value.is_table())
        return fmt::format("\n  write [[{0}]], with two brackets, above the keys of each {0}", spec.key);
    const auto* text = std::get_if<std::string>(&value.data);
    if (text && carries_number(spec) && reads_as_number(*text)) return "\n  write it without quotes";
    return "";
}

std::string describe(const Range& range, const std::string& unit) {
    std::string low, high;
    if (std::isfinite(range.low)) low = fmt::format("{} {}{}", range.low_open ? "above" : "at least", range.low, unit);
    if (std::isfinite(range.high))
        high = fmt::format("{} {}{}", range.high_open ? "below" : "at most", range.high, unit);
    return low + (low.empty() || high.empty() ? "" : " and ") + high;
}

}  // namespace

std::string unit_note(const ParamSpec& spec) {
    return carries_number(spec) && std::string_view{spec.unit} != "1" ? fmt::format(" [{}]", spec.unit) : "";
}

bool has_default(const ParamSpec& spec) { return spec.default_text != nullptr || !std::isnan(spec.default_value); }

std::vector<std::string> split_choices(const char* choices) {
    std::vector<std::string> words;
    std::istringstream stream{choices};
    for (std::string word; std::getline(stream, word, '|');) words.push_back(word);
    return words;
}

bool reads_as_number(const std::string& text) {
    std::istringstream stream{text};
    double number = 0;
    return stream >> number && stream.peek() == std::char_traits<char>::eof();
}

void refuse_kind(const Value& value, const ParamSpec& spec, const std::string& what) {
    const bool is_leaf = !value.is_table() && !value.is_list();
    throw InputError{value.place.text(),
                     fmt::format("'{}' in {} must be {}{}{}, got {}{}{}", spec.key, what, expected_kind(spec),
                                 unit_note(spec), expected_words(spec), value.kind(),
                                 is_leaf ? " (" + value.to_toml() + ")" : "", remedy(value, spec))};
}

double require_number(const Value& value, const ParamSpec& spec, const std::string& what) {
    if (const auto* integer = std::get_if<std::int64_t>(&value.data)) return static_cast<double>(*integer);
    const auto* number = std::get_if<double>(&value.data);
    if (!number) refuse_kind(value, spec, what);
    if (!std::isfinite(*number)) {
        throw InputError{value.place.text(), fmt::format("'{}' in {} must be finite{}, got {}", spec.key, what,
                                                         unit_note(spec), value.to_toml())};
    }
    return *number;
}

void check_range(double number, const Place& place, const ParamSpec& spec, const std::string& what) {
    const Range& r = spec.range;
    const bool is_low = r.low_open ? number <= r.low : number < r.low;
    const bool is_high = r.high_open ? number >= r.high : number > r.high;
    if (!is_low && !is_high) return;
    const std::string unit = std::string_view{spec.unit} == "1" ? "" : fmt::format(" {}", spec.unit);
    throw InputError{place.text(),
                     fmt::format("'{}' in {} must be {}, got {}", spec.key, what, describe(r, unit), number)};
}

}  // namespace perimpm
