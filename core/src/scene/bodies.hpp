#pragma once

#include <string>
#include <vector>

#include "perimpm/scene/scene.hpp"

namespace perimpm {

/// Reads the list [[body]]; the scene's materials, grid and folder must be set.
std::vector<BodySpec> read_bodies(const Reader& tree, const Scene& scene);
/// Reads the list [[collider]]. folder: where relative mesh files start.
std::vector<ColliderSpec> read_colliders(const Reader& tree, const std::string& folder);

}  // namespace perimpm
