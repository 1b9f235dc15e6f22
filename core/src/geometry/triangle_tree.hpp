#pragma once

#include <unsupported/Eigen/BVH>

#include "perimpm/geometry/shape.hpp"

namespace perimpm {

/// Triangles in a tree of boxes, to find what goes through them.
class PERIMPM_API TriangleTree {
public:
    explicit TriangleTree(TriangleMesh mesh);

    /// Whether the way from a to b goes through a triangle. A point on a triangle's plane counts to the side that its normal
    /// points to. No way slips through between triangles that share an edge or
    /// a corner, unless it ends within rounding of a fold.
    bool crosses(const Vec3& a, const Vec3& b) const;

private:
    TriangleMesh mesh_;
    Eigen::KdBVH<double, 3, std::uint32_t> boxes_;
};

}  // namespace perimpm
