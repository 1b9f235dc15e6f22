#pragma once

#include <vector>

#include "perimpm/scene/scene.hpp"

namespace perimpm {

/// Reads the list [[condition]]; the scene's materials, bodies and folder must be set.
std::vector<ConditionSpec> read_conditions(const Reader& tree, const Scene& scene);

}  // namespace perimpm
