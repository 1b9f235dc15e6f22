#include "perimpm/scene/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "perimpm/error.hpp"
#include "scene/checks.hpp"
#include "scene/models.hpp"

namespace perimpm {
namespace {

/// Largest integer up to which every integer is a double: values reach plugins as double.
constexpr std::int64_t kLargestInteger = std::int64_t{1} << 53;

/// Texts of choices must match; other kinds take one of their words instead of a value. False: no text, or a number in quotes.
bool read_word(const Value& value, const ParamSpec& spec, const std::string& what, ParamValue& out) {
    const auto* text = std::get_if<std::string>(&value.data);
    if (!text || !spec.choices) return false;
    if (spec.kind != ParamKind::choice && reads_as_number(*text)) return false;
    const std::vector<std::string> words = split_choices(spec.choices);
    if (std::find(words.begin(), words.end(), *text) == words.end()) {
        throw InputError{value.place.text(), fmt::format("'{}' in {} does not know '{}'\n  {}", spec.key, what, *text,
                                                         suggestion(*text, words))};
    }
    out.text = text->c_str();
    return true;
}

void require_vector(const Value& value, const ParamSpec& spec, const std::string& what, double out[3]) {
    const auto* list = std::get_if<Value::List>(&value.data);
    if (!list) refuse_kind(value, spec, what);
    if (list->size() != 3) {
        throw InputError{value.place.text(), fmt::format("'{}' in {} must be a list of 3 numbers{}, got {}", spec.key,
                                                         what, unit_note(spec), list->size())};
    }
    for (std::size_t c = 0; c < 3; ++c) {
        out[c] = require_number((*list)[c], spec, what);
        check_range(out[c], (*list)[c].place, spec, what);
    }
}

constexpr ParamSpec ramp_end(const char* key, const ParamSpec& like, const char* doc) {
    return {.key = key, .unit = like.unit, .range = like.range, .doc = doc};
}

Ramp read_ramp(const Value& value, const ParamSpec& spec, const std::string& what) {
    const ParamSpec specs[] = {
        ramp_end("from", spec, "value at `start` and before"),
        ramp_end("to", spec, "value at `end` and beyond"),
        {.key = "start", .kind = ParamKind::vector, .unit = "m", .doc = "where the ramp begins"},
        {.key = "end", .kind = ParamKind::vector, .unit = "m", .doc = "where the ramp ends"},
    };
    const Reader reader{value, specs, fmt::format("{}.{}", what, spec.key)};
    const Ramp ramp{reader.number("from"), reader.number("to"), reader.vector("start"), reader.vector("end")};
    if (ramp.start == ramp.end) reader.fail("end", "must differ from 'start'");
    return ramp;
}

}  // namespace

/// A model inside this one, by the key that names it.
struct Reader::Inner {
    std::string key;
    ModelSpec spec;
    ModelChoice choice;

    Inner(const ParamSpec& param, const Value& table, const std::string& what)
        : key{param.key},
          spec{read_model(table, Family::constitutive, what)},
          choice{spec.type.c_str(), spec.params->specs().data(), spec.params->values().data(),
                 static_cast<std::uint32_t>(spec.params->specs().size())} {
        for (const ParamSpec& own : spec.params->specs())
            if (own.per_particle && spec.params->ramp(own.key))
                spec.params->fail(own.key, "cannot vary per particle inside another model: give a number");
    }
};

Reader::Reader(const Value& table, std::span<const ParamSpec> specs, std::string what,
               std::span<const char* const> extra)
    : table_{&table}, specs_{specs}, what_{std::move(what)} {
    if (!table.is_table()) {
        throw InputError{table.place.text(), fmt::format("{} must be a table, got {}", what_, table.kind())};
    }
    refuse_unknown_keys(extra);
    values_.reserve(specs.size());
    for (const ParamSpec& spec : specs) values_.push_back(read(spec));
}

void Reader::refuse_unknown_keys(std::span<const char* const> extra) const {
    std::vector<std::string> accepted, shown;
    for (const ParamSpec& spec : specs_) {
        accepted.emplace_back(spec.key);
        shown.push_back(spec.key + unit_note(spec));
    }
    for (const char* key : extra) {
        if (std::find(accepted.begin(), accepted.end(), key) != accepted.end()) continue;
        accepted.emplace_back(key);
        shown.emplace_back(key);
    }
    for (const auto& [key, value] : std::get<Value::Table>(table_->data)) {
        if (std::find(accepted.begin(), accepted.end(), key) != accepted.end()) continue;
        throw InputError{value.place.text(),
                         fmt::format("unknown key '{}' in {}\n  {}", key, what_, suggestion(key, accepted, shown))};
    }
}

const ModelChoice* Reader::read_inner(const Value& table, const ParamSpec& spec) {
    inner_.push_back(std::make_shared<const Inner>(spec, table, fmt::format("{}.{}", what_, spec.key)));
    return &inner_.back()->choice;
}

ParamValue Reader::read(const ParamSpec& spec) {
    ParamValue out{.number = spec.default_value, .text = spec.default_text};
    const Value* value = table_->find(spec.key);
    if (!value) {
        if (spec.optional || has_default(spec)) return out;
        throw InputError{table_->place.text(),
                         fmt::format("missing key '{}'{} in {}: {}", spec.key, unit_note(spec), what_, spec.doc)};
    }
    out = {.given = true};
    if (read_word(*value, spec, what_, out)) return out;
    switch (spec.kind) {
        case ParamKind::number:
            if (spec.per_particle && value->is_table()) {
                out.number = read_ramp(*value, spec, what_).from;
            } else {
                out.number = require_number(*value, spec, what_);
                check_range(out.number, value->place, spec, what_);
            }
            break;
        case ParamKind::integer: {
            const auto* integer = std::get_if<std::int64_t>(&value->data);
            if (!integer) refuse_kind(*value, spec, what_);
            if (*integer < -kLargestInteger || *integer > kLargestInteger)
                fail(spec.key, "must lie within 2^53 of zero");
            out.number = static_cast<double>(*integer);
            check_range(out.number, value->place, spec, what_);
            break;
        }
        case ParamKind::boolean: {
            const auto* flag = std::get_if<bool>(&value->data);
            if (!flag) refuse_kind(*value, spec, what_);
            out.number = *flag ? 1.0 : 0.0;
            break;
        }
        case ParamKind::text:
        case ParamKind::choice: {
            const auto* text = std::get_if<std::string>(&value->data);
            if (!text) refuse_kind(*value, spec, what_);
            out.text = text->c_str();
            break;
        }
        case ParamKind::vector:
            require_vector(*value, spec, what_, out.vector);
            break;
        case ParamKind::table:
            if (!value->is_table()) refuse_kind(*value, spec, what_);
            break;
        case ParamKind::list:
            if (!value->is_list()) refuse_kind(*value, spec, what_);
            break;
        case ParamKind::model:
            if (!value->is_table()) refuse_kind(*value, spec, what_);
            out.model = read_inner(*value, spec);
            break;
    }
    return out;
}

std::size_t Reader::index(const char* key) const {
    for (std::size_t i = 0; i < specs_.size(); ++i) {
        if (std::strcmp(specs_[i].key, key) == 0) return i;
    }
    throw std::logic_error{fmt::format("the key '{}' of {} is read but not declared", key, what_)};
}

double Reader::number(const char* key) const { return values_[index(key)].number; }
std::int64_t Reader::integer(const char* key) const { return static_cast<std::int64_t>(number(key)); }
bool Reader::flag(const char* key) const { return number(key) != 0.0; }
bool Reader::given(const char* key) const { return values_[index(key)].given; }

std::string Reader::text(const char* key) const {
    const char* text = values_[index(key)].text;
    return text ? text : "";
}

std::array<double, 3> Reader::vector(const char* key, std::array<double, 3> fallback) const {
    if (!given(key)) return fallback;
    return std::to_array(values_[index(key)].vector);
}

const Value* Reader::value(const char* key) const { return given(key) ? table_->find(key) : nullptr; }

std::optional<Ramp> Reader::ramp(const char* key) const {
    const Value* value = this->value(key);
    if (!value || !value->is_table()) return std::nullopt;
    return read_ramp(*value, specs_[index(key)], what_);
}

const ModelSpec* Reader::model(const char* key) const {
    for (const auto& inner : inner_)
        if (inner->key == key) return &inner->spec;
    return nullptr;
}

void Reader::fail(const char* key, const std::string& message) const {
    const std::string path = key;
    if (const std::size_t dot = path.find('.'); dot != std::string::npos)
        if (const ModelSpec* inner = model(path.substr(0, dot).c_str()))
            inner->params->fail(path.substr(dot + 1).c_str(), message);
    const Value* value = table_->find(key);
    throw InputError{(value ? *value : *table_).place.text(), fmt::format("'{}' in {} {}", key, what_, message)};
}

std::string read_type(const Value& table, const std::string& what, const std::vector<std::string>& accepted) {
    if (!table.is_table()) {
        throw InputError{table.place.text(),
                         fmt::format("{} must be a table with a 'type', got {}", what, table.kind())};
    }
    const Value* type = table.find("type");
    const std::string hint = accepted.empty() ? "" : "\n  " + suggestion("", accepted);
    if (!type) throw InputError{table.place.text(), fmt::format("missing key 'type' in {}{}", what, hint)};
    const auto* name = std::get_if<std::string>(&type->data);
    if (!name)
        throw InputError{type->place.text(), fmt::format("'type' in {} must be a text, got {}", what, type->kind())};
    if (!accepted.empty() && std::find(accepted.begin(), accepted.end(), *name) == accepted.end()) {
        throw InputError{type->place.text(),
                         fmt::format("unknown type '{}' in {}\n  {}", *name, what, suggestion(*name, accepted))};
    }
    return *name;
}

}  // namespace perimpm
