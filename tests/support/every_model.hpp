#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/model.hpp"

/// Names of the family's installed plugins; without scripts, which need an interpreter.
inline std::vector<std::string> names_of(perimpm::Family family) {
    std::vector<std::string> names;
    for (const perimpm::PluginFile& file : perimpm::installed(family))
        if (!file.path.ends_with(".py")) names.push_back(file.name);
    return names;
}

/// The table that a model accepts when only what it must have is given: numbers well inside their range, 1e6 for Pa and J/m^6.
/// A declared Young's modulus, critical stretch or energy is always given, since models may require it depending on other keys.
inline std::string smallest_table(perimpm::Family family, const std::string& name) {
    const perimpm::PluginDescriptor& d = *perimpm::open_plugin(family, name).descriptor;
    std::string table;
    for (std::uint32_t k = 0; k < d.param_count; ++k) {
        const perimpm::ParamSpec& spec = d.params[k];
        const bool wanted = std::string(spec.key) == "youngs_modulus" || std::string(spec.key) == "critical_stretch" ||
                            std::string(spec.key) == "critical_energy";
        const bool has_default = !std::isnan(spec.default_value) || spec.default_text || spec.optional;
        if (has_default && !wanted) continue;
        if (spec.kind == perimpm::ParamKind::model) {
            table += fmt::format("{} = {{ type = \"fixed_corotated\", youngs_modulus = 1e6 }}\n", spec.key);
            continue;
        }
        const double low = spec.range.low, high = spec.range.high;
        const double value = std::string(spec.unit) == "Pa" || std::string(spec.unit) == "J/m^6" ? 1e6
                             : std::isfinite(low) && std::isfinite(high)                         ? (low + high) / 2
                             : std::isfinite(low)                                                ? low + 1
                                                                                                 : 1.0;
        table += fmt::format("{} = {}\n", spec.key, value);
    }
    return table;
}

/// What every plugin's declaration owes its users.
inline void check_declaration(perimpm::Family family, const std::string& name) {
    const perimpm::PluginDescriptor& d = *perimpm::open_plugin(family, name).descriptor;
    CHECK(d.family == family);
    CHECK_FALSE(std::string(d.summary).empty());
    for (std::uint32_t k = 0; k < d.param_count; ++k) {
        const perimpm::ParamSpec& spec = d.params[k];
        CAPTURE(spec.key);
        CHECK_FALSE(std::string(spec.unit).empty());
        CHECK_FALSE(std::string(spec.doc).empty());
        const bool is_choice = spec.kind == perimpm::ParamKind::choice;
        CHECK((!is_choice || spec.choices));
        for (const char c : std::string(spec.key))
            CHECK(((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'));
        // Doubling a letter makes a key that nobody declares.
        const std::string misspelt = std::string(spec.key) + spec.key[std::string(spec.key).size() - 1];
        const std::string table = smallest_table(family, name) + misspelt + " = 1\n";
        const perimpm::Value values = perimpm::parse_scene_text(table, name);
        const std::string message = message_of([&] { perimpm::Reader(values, {d.params, d.param_count}, name); });
        CHECK(contains(message, "unknown key '" + misspelt + "'"));
        CHECK(contains(message, "did you mean '" + std::string(spec.key) + "'?"));
    }
}

/// What every declared history field owes its users.
inline void check_fields(const perimpm::FieldSpecs& fields) {
    for (std::uint32_t k = 0; k < fields.size; ++k) {
        CAPTURE(fields.data[k].name);
        CHECK_FALSE(std::string(fields.data[k].unit).empty());
        CHECK_FALSE(std::string(fields.data[k].doc).empty());
        CHECK(fields.data[k].components > 0);
    }
}
