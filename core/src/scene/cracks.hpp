#pragma once

#include <span>
#include <vector>

#include "perimpm/scene/scene.hpp"

namespace perimpm {

/// Reads the list [[crack]]; the scene's bodies must be set.
std::vector<CrackSpec> read_cracks(const Reader& tree, const Scene& scene);

/// The keys of a crack's checked shape.
std::span<const ParamSpec> patch_keys(const Value& shape);

}  // namespace perimpm
