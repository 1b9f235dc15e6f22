#include "geometry/triangle_tree.hpp"

#include <algorithm>
#include <utility>

namespace perimpm {

namespace {

/// Points as seen along the way from a to b, flattened by a shear (Woop, Benthin & Wald 2013, Watertight Ray/Triangle
/// Intersection, JCGT 2): rounded once by point, whatever triangle asks.
class Way {
public:
    Way(const TriangleMesh& mesh, const Vec3& a, const Vec3& b) : mesh_{mesh}, a_{a}, b_{b} {
        const Vec3 way = b - a;
        way.cwiseAbs().maxCoeff(&along_);
        shear_ = {way[x()] / way[along_], way[y()] / way[along_]};
    }
    bool found() const { return found_; }

    // What BVIntersect asks: boxes that the way's own box meets, then their triangles.
    bool intersectVolume(const Box3& other) const { return box_.intersects(other); }
    bool intersectObject(std::uint32_t t) { return found_ = goes_through(mesh_.triangles[t]); }

private:
    int x() const { return (along_ + 1) % 3; }
    int y() const { return (along_ + 2) % 3; }
    Eigen::Vector2d flat(const Vec3& point) const {
        const Vec3 p = point - a_;
        return {p[x()] - shear_[0] * p[along_], p[y()] - shear_[1] * p[along_]};
    }
    /// On which side of the edge from p to q the way passes: 1, -1, or 0 for on it. Products are compared, not subtracted:
    /// rounding then turns no side into the other, and no way slips between triangles that share an edge or a corner.
    static int side(const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
        const double one = p[0] * q[1], other = p[1] * q[0];
        return int{one > other} - int{one < other};
    }
    bool goes_through(const std::array<std::uint32_t, 3>& t) const {
        const Vec3& corner = mesh_.points[t[0]];
        const Vec3 normal = (mesh_.points[t[1]] - corner).cross(mesh_.points[t[2]] - corner);
        if ((normal.dot(a_ - corner) >= 0) == (normal.dot(b_ - corner) >= 0)) return false;
        const Eigen::Vector2d p = flat(corner), q = flat(mesh_.points[t[1]]), r = flat(mesh_.points[t[2]]);
        const auto [least, most] = std::minmax({side(p, q), side(q, r), side(r, p)});
        return least >= 0 || most <= 0;
    }

    const TriangleMesh& mesh_;
    Vec3 a_, b_;
    Box3 box_ = Box3(a_.cwiseMin(b_), a_.cwiseMax(b_));
    int along_ = 0;  ///< axis that the way follows most
    Eigen::Vector2d shear_;
    bool found_ = false;
};

}  // namespace

TriangleTree::TriangleTree(TriangleMesh mesh) : mesh_{std::move(mesh)} {
    std::vector<std::uint32_t> triangles;
    std::vector<Box3> boxes;
    for (const auto& t : mesh_.triangles) {
        triangles.push_back(static_cast<std::uint32_t>(boxes.size()));
        Box3& box = boxes.emplace_back();
        for (const std::uint32_t point : t) box.extend(mesh_.points[point]);
    }
    boxes_.init(triangles.begin(), triangles.end(), boxes.begin(), boxes.end());
}

bool TriangleTree::crosses(const Vec3& a, const Vec3& b) const {
    Way way(mesh_, a, b);
    Eigen::BVIntersect(boxes_, way);
    return way.found();
}

}  // namespace perimpm
