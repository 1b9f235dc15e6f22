// Particles to a closed surface, by OpenVDB's level sets.
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetFilter.h>
#include <openvdb/tools/ParticlesToLevelSet.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "perimpm/error.hpp"
#include "triangle_mesh.hpp"

namespace perimpm {

namespace {

constexpr double kVoxel = 0.35;   ///< of the level set [spacings]
constexpr double kRadius = 1.25;  ///< of balls about the particles [spacings]
/// By how much their union is shrunk back [spacings]: the faces of a lattice then lie half a spacing out, on average.
constexpr double kShrink = 0.65;

/// Balls about the points, as OpenVDB asks for them, in spacings from the first point.
class Balls {
public:
    using PosType = openvdb::Vec3R;
    Balls(const std::vector<Vec3>& points, double spacing) : points_{points}, spacing_{spacing} {}
    std::size_t size() const { return points_.size(); }
    void getPos(std::size_t n, openvdb::Vec3R& at) const {
        const Vec3 x = (points_[n] - points_.front()) / spacing_;
        at = {x[0], x[1], x[2]};
    }
    void getPosRad(std::size_t n, openvdb::Vec3R& at, openvdb::Real& radius) const { getPos(n, at), radius = kRadius; }

private:
    const std::vector<Vec3>& points_;
    double spacing_;
};

void require_sound(const std::vector<Vec3>& points, double spacing) {
    if (!std::isfinite(spacing) || spacing <= 0)
        throw InputError("the surface around particles needs their spacing: expected a positive length in m");
    for (std::size_t n = 0; n < points.size(); ++n)
        if (!points[n].allFinite()) throw InputError("the place of particle " + std::to_string(n) + " is not finite");
}

}  // namespace

TriangleMesh enclose(const std::vector<Vec3>& points, double spacing) {
    require_sound(points, spacing);
    TriangleMesh mesh;
    if (points.empty()) return mesh;
    openvdb::initialize();
    const openvdb::FloatGrid::Ptr solid = openvdb::createLevelSet<openvdb::FloatGrid>(kVoxel);
    openvdb::tools::ParticlesToLevelSet<openvdb::FloatGrid> balls(*solid);
    balls.setRmin(kRadius / 2);
    balls.rasterizeSpheres(Balls(points, spacing));
    balls.finalize();
    openvdb::tools::LevelSetFilter<openvdb::FloatGrid>(*solid).offset(static_cast<float>(kShrink));

    std::vector<openvdb::Vec3s> corners;
    std::vector<openvdb::Vec3I> triangles;
    std::vector<openvdb::Vec4I> quads;
    openvdb::tools::volumeToMesh(*solid, corners, triangles, quads, 0.0);
    mesh.points.reserve(corners.size());
    for (const openvdb::Vec3s& c : corners)
        mesh.points.push_back(points.front() + spacing * Vec3(static_cast<double>(c[0]), static_cast<double>(c[1]),
                                                              static_cast<double>(c[2])));
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) { mesh.triangles.push_back({a, c, b}); };
    for (const openvdb::Vec3I& t : triangles) add(t[0], t[1], t[2]);
    for (const openvdb::Vec4I& q : quads) add(q[0], q[1], q[2]), add(q[0], q[2], q[3]);
    return mesh;
}

}  // namespace perimpm
