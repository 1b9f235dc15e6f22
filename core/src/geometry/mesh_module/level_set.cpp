// Triangles to a signed distance field, by OpenVDB. The only file that includes OpenVDB's mesh converter (12 s to
// compile).
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/MeshToVolume.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "perimpm/error.hpp"
#include "triangle_mesh.hpp"

namespace perimpm {

namespace {

constexpr float kExteriorBand = 4.0f;                               // [voxels]
constexpr float kInteriorBand = std::numeric_limits<float>::max();  // the whole inside, as deep as it goes
constexpr double kMostVoxels = 1.0e9;                               // 4 GB of floats
constexpr double kFlatField = 1.0e-3;                               // slope below which the field gives no direction

/// The triangles in voxel units, as OpenVDB asks for them; double, so that small spacings keep their accuracy.
class VoxelSpaceMesh {
public:
    VoxelSpaceMesh(const TriangleMesh& mesh, const Vec3& origin, double voxel_size)
        : mesh_(mesh), origin_(origin), voxel_size_(voxel_size) {}
    std::size_t polygonCount() const { return mesh_.triangles.size(); }
    std::size_t pointCount() const { return mesh_.points.size(); }
    std::size_t vertexCount(std::size_t) const { return 3; }
    void getIndexSpacePoint(std::size_t polygon, std::size_t vertex, openvdb::Vec3d& out) const {
        const Vec3 p = (mesh_.points[mesh_.triangles[polygon][vertex]] - origin_) / voxel_size_;
        out = {p.x(), p.y(), p.z()};
    }

private:
    const TriangleMesh& mesh_;
    Vec3 origin_;
    double voxel_size_;
};

/// What signed_distance() returns: inside, the distance at every depth; outside, the distance up to kExteriorBand
/// voxels and beyond that a lower bound of it (the larger of the band width and the distance to the mesh's bounds), so
/// that the sign is right everywhere. Near the surface both are trilinear between voxels.
class LevelSet final : public Shape {
public:
    LevelSet(const TriangleMesh& mesh, const Vec3& origin, double voxel_size)
        : points_(mesh.points), origin_(origin), voxel_size_(voxel_size) {
        for (const Vec3& p : points_) bounds_.extend(p);
        openvdb::initialize();
        const auto transform = openvdb::math::Transform::createLinearTransform(voxel_size);
        grid_ = openvdb::tools::meshToVolume<openvdb::FloatGrid>(VoxelSpaceMesh(mesh, origin, voxel_size), *transform,
                                                                 kExteriorBand, kInteriorBand);
    }

    double signed_distance(const Vec3& x) const override {
        const double distance = field(x);
        return distance > 0.0 ? std::max(distance, bounds_.exteriorDistance(x)) : distance;
    }

    Vec3 normal(const Vec3& x) const override {
        Vec3 slope;
        for (int axis = 0; axis < 3; ++axis) {
            const Vec3 step = 0.5 * voxel_size_ * Vec3::Unit(axis);
            slope(axis) = (field(x + step) - field(x - step)) / voxel_size_;
        }
        return slope.norm() > kFlatField ? slope.normalized() : away_from_nearest_point(x);
    }

    Box3 bounds() const override { return bounds_; }

    bool has_inside() const {
        for (auto voxel = grid_->cbeginValueOn(); voxel; ++voxel)
            if (*voxel < 0.0f) return true;
        return false;
    }

private:
    double field(const Vec3& x) const {
        const Vec3 voxel = (x - origin_) / voxel_size_;
        // not registered with the tree, so that threads share nothing
        const openvdb::tree::ValueAccessor<const openvdb::FloatTree, false> values(grid_->tree());
        return openvdb::tools::BoxSampler::sample(values, openvdb::Vec3d(voxel.x(), voxel.y(), voxel.z()));
    }

    /// Beyond the band, and where opposite sides are equally far, the field is flat. Rare, so a plain search will do.
    Vec3 away_from_nearest_point(const Vec3& x) const {
        const Vec3 nearest_point = *std::min_element(points_.begin(), points_.end(), [&](const Vec3& a, const Vec3& b) {
            return (a - x).squaredNorm() < (b - x).squaredNorm();
        });
        const Vec3 away = field(x) < 0.0 ? Vec3(nearest_point - x) : Vec3(x - nearest_point);
        return away.normalized();
    }

    std::vector<Vec3> points_;
    Vec3 origin_;  // position of voxel (0, 0, 0)
    double voxel_size_;
    Box3 bounds_;
    openvdb::FloatGrid::ConstPtr grid_;
};

std::string number(double value) {
    std::ostringstream out;
    out << value;
    return out.str();
}

void require_voxel_size(const TriangleMesh& mesh, double voxel_size, const std::string& file) {
    if (!std::isfinite(voxel_size) || voxel_size <= 0.0)
        throw InputError(file, "voxel size is " + number(voxel_size) + "; expected a positive length in m");
    const double band = surface_area(mesh) * kExteriorBand / (voxel_size * voxel_size);
    const double voxels = enclosed_volume(mesh) / std::pow(voxel_size, 3) + band;
    if (voxels > kMostVoxels)
        throw InputError(file, "a level set with voxels of " + number(voxel_size) + " m needs about " + number(voxels) +
                                   " of them, at most " + number(kMostVoxels) +
                                   " are supported; use a larger spacing or a smaller scale");
}

void refuse_thin(const std::string& file, double voxel_size, double thickness) {
    throw InputError(file, "thinner than a voxel: the voxel size is " + number(voxel_size) + " m, the mesh is about " +
                               number(thickness) + " m thick on average; use a spacing smaller than its thickness");
}

}  // namespace

std::unique_ptr<Shape> make_level_set(const TriangleMesh& mesh, double voxel_size, const std::string& file) {
    require_voxel_size(mesh, voxel_size, file);
    // A sheet of thickness t has 2 volume / area = t, a cube of side t has t / 3: below a third of a voxel no part of
    // the mesh is resolved, even where a voxel happens to fall inside.
    const double thickness = 2.0 * enclosed_volume(mesh) / surface_area(mesh);
    if (thickness < voxel_size / 3.0) refuse_thin(file, voxel_size, thickness);

    Box3 bounds;
    for (const Vec3& p : mesh.points) bounds.extend(p);
    // Voxels are the points of sample_lattice(), and faces on whole spacings lie midway between them.
    const Vec3 origin = bounds.min() + Vec3::Constant(0.5 * voxel_size);
    auto shape = std::make_unique<LevelSet>(mesh, origin, voxel_size);
    if (!shape->has_inside()) refuse_thin(file, voxel_size, thickness);
    return shape;
}

}  // namespace perimpm
