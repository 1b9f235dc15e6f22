// What makes triangles a solid, and where the solid stands.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "perimpm/error.hpp"
#include "triangle_mesh.hpp"

namespace perimpm {

namespace {

/// Height over longest edge below which rounding of float coordinates decides a triangle's normal.
constexpr double kFlat = 1.0e-6;

std::string count(std::size_t n, const std::string& noun) {
    return std::to_string(n) + ' ' + noun + (n == 1 ? "" : "s");
}

bool has_no_area(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t) {
    const Vec3 &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
    const double longest = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    return (b - a).cross(c - a).norm() <= kFlat * longest;
}

struct EdgeCount {
    std::size_t open = 0, crowded = 0, inconsistent = 0, all = 0;
};

/// An edge as its lower and higher point, and whether its triangle runs from the lower to the higher.
struct HalfEdge {
    std::uint64_t edge;
    bool upward;
    auto operator<=>(const HalfEdge&) const = default;
};

std::vector<HalfEdge> half_edges(const TriangleMesh& mesh) {
    std::vector<HalfEdge> edges;
    edges.reserve(3 * mesh.triangles.size());
    for (const auto& t : mesh.triangles)
        for (std::size_t c = 0; c < 3; ++c) {
            const std::uint64_t from = t[c], to = t[(c + 1) % 3];
            edges.push_back({std::min(from, to) << 32 | std::max(from, to), from < to});
        }
    std::sort(edges.begin(), edges.end());
    return edges;
}

EdgeCount count_edges(const TriangleMesh& mesh) {
    const std::vector<HalfEdge> edges = half_edges(mesh);
    EdgeCount n;
    for (std::size_t first = 0, last; first < edges.size(); first = last) {
        for (last = first; last < edges.size() && edges[last].edge == edges[first].edge; ++last) {
        }
        ++n.all;
        n.open += last - first == 1;
        n.crowded += last - first > 2;
        n.inconsistent += last - first == 2 && edges[first].upward == edges[first + 1].upward;
    }
    return n;
}

double six_volumes(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t, const Vec3& origin) {
    const Vec3 a = mesh.points[t[0]] - origin, b = mesh.points[t[1]] - origin, c = mesh.points[t[2]] - origin;
    return a.dot(b.cross(c));
}

/// The lowest point index of each point's connected part (union-find with path halving).
std::vector<std::uint32_t> part_of_points(const TriangleMesh& mesh) {
    std::vector<std::uint32_t> parent(mesh.points.size());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](std::uint32_t p) {
        for (; parent[p] != p; p = parent[p]) parent[p] = parent[parent[p]];
        return p;
    };
    for (const auto& t : mesh.triangles)
        for (std::size_t c = 1; c < 3; ++c) {
            const std::uint32_t a = root(t[0]), b = root(t[c]);
            parent[std::max(a, b)] = std::min(a, b);
        }
    for (std::uint32_t p = 0; p < parent.size(); ++p) parent[p] = root(p);
    return parent;
}

void require_outward_parts(const TriangleMesh& mesh, const std::string& file) {
    const std::vector<std::uint32_t> part = part_of_points(mesh);
    std::vector<double> volume(mesh.points.size(), 0.0);  // six times, per part, at the part's lowest point
    for (const auto& t : mesh.triangles) volume[part[t[0]]] += six_volumes(mesh, t, mesh.points[part[t[0]]]);

    std::size_t parts = 0, inverted = 0;
    for (std::uint32_t p = 0; p < part.size(); ++p) {
        parts += part[p] == p;
        inverted += volume[p] < 0.0;
    }
    if (inverted == 0) return;
    if (inverted == parts)
        throw InputError(file,
                         "inverted mesh: its faces point inwards (negative volume); flip the winding of all faces");
    throw InputError(file, "inverted parts: " + std::to_string(inverted) + " of the mesh's " +
                               count(parts, "closed part") +
                               " point inwards (negative volume); flip their winding, or remove them if they are meant "
                               "as cavities, which are not supported");
}

}  // namespace

void check_triangles(const TriangleMesh& mesh, const std::string& file) {
    if (mesh.triangles.empty()) throw InputError(file, "has no triangles; expected a triangle mesh");

    const auto flat = std::count_if(mesh.triangles.begin(), mesh.triangles.end(),
                                    [&](const auto& t) { return has_no_area(mesh, t); });
    if (flat != 0)
        throw InputError(file, count(std::size_t(flat), "degenerate triangle") + " (zero area) of " +
                                   std::to_string(mesh.triangles.size()) + "; remove them, then close the mesh again");
}

void check_solid(const TriangleMesh& mesh, const std::string& file) {
    check_triangles(mesh, file);
    const EdgeCount n = count_edges(mesh);
    if (n.open + n.crowded + n.inconsistent != 0)
        throw InputError(
            file, "not watertight: " + count(n.open, "open edge") + ", " + count(n.crowded, "non-manifold edge") +
                      ", " + count(n.inconsistent, "inconsistently oriented edge") + " of " + std::to_string(n.all) +
                      "; expected every edge to be shared by two triangles of opposite direction");
    require_outward_parts(mesh, file);
}

void place(TriangleMesh& mesh, const MeshPlacement& placement, const std::string& file) {
    if (!std::isfinite(placement.scale) || placement.scale <= 0.0)
        throw InputError(file, "scale is " + std::to_string(placement.scale) + "; expected a positive number");
    if (!placement.rotation.allFinite() || !placement.translation.allFinite())
        throw InputError(file, "rotation and translation must be finite numbers");

    const Vec3 angle = placement.rotation * (std::numbers::pi / 180.0);
    const Eigen::Matrix3d rotate =
        (Eigen::AngleAxisd(angle.z(), Vec3::UnitZ()) * Eigen::AngleAxisd(angle.y(), Vec3::UnitY()) *
         Eigen::AngleAxisd(angle.x(), Vec3::UnitX()))
            .toRotationMatrix();
    for (Vec3& p : mesh.points) p = rotate * (placement.scale * p) + placement.translation;
}

double enclosed_volume(const TriangleMesh& mesh) {
    double sum = 0.0;
    for (const auto& t : mesh.triangles) sum += six_volumes(mesh, t, mesh.points.front());
    return sum / 6.0;
}

double surface_area(const TriangleMesh& mesh) {
    double sum = 0.0;
    for (const auto& t : mesh.triangles) {
        const Vec3& a = mesh.points[t[0]];
        sum += 0.5 * (mesh.points[t[1]] - a).cross(mesh.points[t[2]] - a).norm();
    }
    return sum;
}

}  // namespace perimpm
