#pragma once

#include <string>

#include "perimpm/geometry/shape.hpp"

namespace perimpm {

/// Types of the mesh module's symbols. "perimpm_make_mesh": arguments and errors of make_mesh(). The caller owns the
/// shape and deletes it through its virtual destructor.
using MakeMesh = Shape*(const std::string& file, const MeshPlacement& placement, double voxel_size);
/// "perimpm_sample_mesh_surface": fills `sample` as sample_mesh_surface() returns it.
using SampleMeshSurface = void(const std::string& file, const MeshPlacement& placement, double spacing,
                               std::uint64_t seed, LayerSample& sample);
/// "perimpm_read_mesh": fills `mesh` as read_mesh() returns it.
using ReadMesh = void(const std::string& file, const MeshPlacement& placement, TriangleMesh& mesh);
/// "perimpm_surface_around": fills `mesh` as surface_around() returns it.
using SurfaceAround = void(const std::vector<Vec3>& points, double spacing, TriangleMesh& mesh);

}  // namespace perimpm
