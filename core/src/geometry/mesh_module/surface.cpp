// Poisson-disk points on triangles by dart throwing: points uniform in area, one after the other, kept when none is nearer
// than the radius.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "../random.hpp"
#include "triangle_mesh.hpp"

namespace perimpm {

namespace {

/// Dart throwing on a plane ends with 0.70/r^2 points (random sequential adsorption of disks covers 0.547).
constexpr double kRadius = 0.83;  ///< of the spacing of as many points on a square lattice
constexpr double kDarts = 100;    ///< by area of spacing squared; leaves a few per cent of room for more points

using Cell = std::array<std::int64_t, 3>;

/// Points by cells as wide as the radius.
class Disks {
public:
    explicit Disks(double radius) : radius_(radius) {}

    void add_unless_crowded(const Vec3& x, std::vector<Vec3>& points) {
        const Cell home = cell_of(x);
        for (std::int64_t k = 0; k < 27; ++k) {
            const auto found = cells_.find({home[0] + k % 3 - 1, home[1] + k / 3 % 3 - 1, home[2] + k / 9 - 1});
            if (found == cells_.end()) continue;
            for (const std::size_t p : found->second)
                if ((points[p] - x).squaredNorm() < radius_ * radius_) return;
        }
        cells_[home].push_back(points.size());
        points.push_back(x);
    }

private:
    Cell cell_of(const Vec3& x) const {
        Cell cell;
        for (int c = 0; c < 3; ++c)
            cell[static_cast<std::size_t>(c)] = static_cast<std::int64_t>(std::floor(x[c] / radius_));
        return cell;
    }

    double radius_;
    std::map<Cell, std::vector<std::size_t>> cells_;
};

}  // namespace

LayerSample sample_triangles(const TriangleMesh& mesh, double spacing, std::uint64_t seed) {
    std::vector<double> area_up_to;
    double area = 0;
    for (const auto& t : mesh.triangles) {
        const Vec3& a = mesh.points[t[0]];
        area_up_to.push_back(area += 0.5 * (mesh.points[t[1]] - a).cross(mesh.points[t[2]] - a).norm());
    }
    LayerSample sample;
    Disks disks(kRadius * spacing);
    Random random(seed);
    const double darts = std::ceil(kDarts * area / (spacing * spacing));
    for (double dart = 0; dart < darts; ++dart) {
        const auto hit = std::upper_bound(area_up_to.begin(), area_up_to.end(), random.unit() * area);
        const auto& t =
            mesh.triangles[static_cast<std::size_t>(std::min(hit, area_up_to.end() - 1) - area_up_to.begin())];
        double u = random.unit(), v = random.unit();
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const Vec3& a = mesh.points[t[0]];
        disks.add_unless_crowded(a + u * (mesh.points[t[1]] - a) + v * (mesh.points[t[2]] - a), sample.points);
    }
    sample.measure = area / static_cast<double>(sample.points.size());
    return sample;
}

}  // namespace perimpm
