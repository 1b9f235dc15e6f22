#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perimpm/scene/scene.hpp"

namespace perimpm {

/// By particle: which of `material.pieces` Voronoi pieces of its body it lies in. `bodies`: first particle of each body, then
/// the total. Their centres are particles, drawn at random. Throws InputError for a body with fewer particles than pieces.
std::vector<std::uint32_t> voronoi_pieces(std::span<const Vec3> X, std::span<const std::size_t> bodies,
                                          const MaterialSpec& material);

}  // namespace perimpm
