#pragma once

#include <array>
#include <cstddef>
#include <string>

#include "perimpm/geometry/shape.hpp"

namespace perimpm {

/// Cubic cells that cover a shape's bounds, starting exactly at their lower corner.
struct Lattice {
    Vec3 origin;
    double spacing;                    ///< [m]
    std::array<std::size_t, 3> count;  ///< cells along x, y, z

    Vec3 center(std::size_t i, std::size_t j, std::size_t k) const {
        return origin + spacing * (Vec3(double(i), double(j), double(k)) + Vec3::Constant(0.5));
    }
};

/// Throws InputError for a spacing that is not positive, a shape without finite bounds, or more than 2^32 cells (the
/// particle limit). `what` names the length in the message.
Lattice lattice_over(const Shape& shape, double spacing, const std::string& what);

}  // namespace perimpm
