#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "perimpm/error.hpp"
#include "perimpm/scene/reader.hpp"

namespace perimpm {

/// Index of the part that the key names; none where the key is absent. Throws InputError for a name that no part has.
template <class Spec>
std::optional<std::uint32_t> named_index(const Reader& r, const char* key, const std::vector<Spec>& specs) {
    if (!r.given(key)) return std::nullopt;
    const std::string name = r.text(key);
    std::vector<std::string> names;
    for (const Spec& spec : specs) names.push_back(spec.name);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end())
        r.fail(key, fmt::format("names '{}', which this scene does not have\n  {}", name, suggestion(name, names)));
    return static_cast<std::uint32_t>(found - names.begin());
}

}  // namespace perimpm
