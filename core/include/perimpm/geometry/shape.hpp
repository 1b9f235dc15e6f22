#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "perimpm/export.hpp"

namespace perimpm {

using Vec3 = Eigen::Vector3d;
using Box3 = Eigen::AlignedBox3d;

/// A solid given by its signed distance, negative inside. Metres. Thread-safe to query.
class PERIMPM_API Shape {
public:
    virtual ~Shape();
    virtual double signed_distance(const Vec3& x) const = 0;
    /// Outward unit normal of the level set through x (gradient of the signed distance).
    virtual Vec3 normal(const Vec3& x) const = 0;
    /// Infinite extents for a half space.
    virtual Box3 bounds() const = 0;
};
using ShapePtr = std::shared_ptr<const Shape>;

PERIMPM_API ShapePtr make_half_space(const Vec3& point, const Vec3& normal);
PERIMPM_API ShapePtr make_box(const Vec3& min, const Vec3& max);
PERIMPM_API ShapePtr make_sphere(const Vec3& center, double radius);
/// Solid cylinder between two end points.
PERIMPM_API ShapePtr make_cylinder(const Vec3& start, const Vec3& end, double radius);

/// Where a mesh stands: scaled, then rotated about the origin (Euler angles in degrees, x then y then z, as Houdini's
/// default xyz order), then translated.
struct MeshPlacement {
    double scale = 1.0;
    Vec3 rotation = Vec3::Zero();
    Vec3 translation = Vec3::Zero();
};

/// Closed triangle mesh from obj, ply, stl, gltf or glb (assimp) as a level set (OpenVDB) with the given voxel size.
/// Inside, the distance is known at every depth; outside, up to four voxels, and beyond that a lower bound of it.
/// Opens the mesh module. Throws InputError: missing or unreadable file, no triangles, triangles without area, open or
/// inconsistent mesh (with the number of offending edges), inverted mesh, cavities, thinner than a voxel.
PERIMPM_API ShapePtr make_mesh(const std::string& file, const MeshPlacement& placement, double voxel_size);

/// Points of the cubic lattice {origin + spacing (i + 1/2)} that lie inside. The lattice is anchored at the lower
/// corner of the shape's bounds, so that a box of whole spacings is filled exactly.
PERIMPM_API std::vector<Vec3> sample_lattice(const Shape& shape, double spacing);

/// Moves every point by up to `reach` [m] along each axis. Deterministic in `seed` on any machine.
PERIMPM_API void jitter(std::vector<Vec3>& points, double reach, std::uint64_t seed);

/// Poisson-disk points inside: no two nearer than `radius`, no hole larger (to a thousandth); about 0.75
/// volume/radius^3 of them. Deterministic in `seed` on any machine.
PERIMPM_API std::vector<Vec3> sample_poisson(const Shape& shape, double radius, std::uint64_t seed);

/// Points of a sheet or a strand, and what each of them stands for: area [m^2] or length [m].
struct LayerSample {
    std::vector<Vec3> points;
    double measure;
};
/// Points of the square lattice {corner + spacing ((i + 1/2) u + (j + 1/2) v)} on the rectangle between two edges that are
/// at right angles, u and v along them.
PERIMPM_API LayerSample sample_rectangle(const Vec3& corner, const Vec3& edge_u, const Vec3& edge_v, double spacing);
/// Points at (i + 1/2) spacing along the line through the corners.
PERIMPM_API LayerSample sample_polyline(const std::vector<Vec3>& corners, double spacing);
/// Poisson-disk points on the surface of a mesh, which may be open; as many as a square lattice of `spacing` would have.
/// Opens the mesh module. Throws InputError for files as make_mesh does, and for triangles without area.
PERIMPM_API LayerSample sample_mesh_surface(const std::string& file, const MeshPlacement& placement, double spacing,
                                            std::uint64_t seed);

/// Triangles over shared points; counter-clockwise seen from outside. Metres.
struct TriangleMesh {
    std::vector<Vec3> points;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};
/// The triangles of a mesh, which may be open. Opens the mesh module. Throws InputError for files as make_mesh does, and for
/// triangles without area.
PERIMPM_API TriangleMesh read_mesh(const std::string& file, const MeshPlacement& placement);
/// The closed surface of the solid that particles at these places fill, `spacing` apart: half a spacing beyond the outermost.
/// What is narrower than two spacings is filled. Opens the mesh module. Throws InputError for a spacing that is not positive
/// and for places that are not finite.
PERIMPM_API TriangleMesh surface_around(const std::vector<Vec3>& points, double spacing);

/// Volume of the shape by quadrature of its signed distance on cells of `spacing` (partial cells counted linearly)
/// [m^3].
PERIMPM_API double measure_volume(const Shape& shape, double spacing);

}  // namespace perimpm
