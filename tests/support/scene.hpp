#pragma once

#include <string>
#include <vector>

#include "perimpm/step/simulation.hpp"

/// A scene from TOML text and overrides, as `perimpm run --set` reads it.
inline perimpm::Scene scene_from(const std::string& text, const std::vector<std::string>& overrides = {}) {
    perimpm::Value tree = perimpm::parse_scene_text(text, "s.toml");
    for (const std::string& assignment : overrides) perimpm::apply_override(tree, assignment);
    return perimpm::read_scene(std::move(tree), ".");
}

/// Component c of particle i of a field in double precision.
inline double& entry(const perimpm::FieldView& field, std::size_t i, std::size_t c = 0) {
    return static_cast<double*>(field.data)[c * field.stride + i];
}

inline perimpm::Vec3 vector_of(const perimpm::FieldView& field, std::size_t i) {
    return {entry(field, i, 0), entry(field, i, 1), entry(field, i, 2)};
}
