#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "perimpm/geometry/shape.hpp"

namespace perimpm {

/// Reads obj, ply, stl, gltf or glb; points at the same position become one. Throws InputError.
TriangleMesh import_mesh(const std::string& file);

/// Throws InputError unless there are triangles, all with area.
void check_triangles(const TriangleMesh& mesh, const std::string& file);

/// Throws InputError unless the mesh bounds a solid: triangles with area, every edge shared by exactly two of them in
/// opposite direction, every closed part wound outwards.
void check_solid(const TriangleMesh& mesh, const std::string& file);

/// Moves the points; throws InputError for a scale that is not positive.
void place(TriangleMesh& mesh, const MeshPlacement& placement, const std::string& file);

/// Enclosed volume by the divergence theorem [m^3].
double enclosed_volume(const TriangleMesh& mesh);
double surface_area(const TriangleMesh& mesh);

/// Poisson-disk points on the triangles, about as many as cells of `spacing` squared fit on them.
LayerSample sample_triangles(const TriangleMesh& mesh, double spacing, std::uint64_t seed);

/// The level set as a shape. Throws InputError for a mesh thinner than a voxel and for too many voxels.
std::unique_ptr<Shape> make_level_set(const TriangleMesh& mesh, double voxel_size, const std::string& file);

/// See surface_around().
TriangleMesh enclose(const std::vector<Vec3>& points, double spacing);

}  // namespace perimpm
