#pragma once

#include <string>

#include "perimpm/geometry/shape.hpp"

namespace perimpm {

/// Type of the mesh module's one symbol, "perimpm_make_mesh": arguments and errors of make_mesh(). The caller owns the
/// shape and deletes it through its virtual destructor.
using MakeMesh = Shape*(const std::string& file, const MeshPlacement& placement, double voxel_size);

}  // namespace perimpm
