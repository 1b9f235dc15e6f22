#pragma once

#include "perimpm/geometry/shape.hpp"

namespace perimpm {

/// A flat piece of surface: all of a plane, the rectangle between two edges at right angles, or a disc. Metres.
struct Patch {
    Vec3 origin;                                        ///< rectangle: a corner; disc: the centre
    Vec3 normal;                                        ///< of any length
    Vec3 edge_u = Vec3::Zero(), edge_v = Vec3::Zero();  ///< rectangle, else zero
    double radius = 0;                                  ///< disc, else 0

    /// Whether the way from a to b goes through. A point on the plane counts to the side that the normal points to.
    bool crosses(const Vec3& a, const Vec3& b) const {
        const double from = normal.dot(a - origin), to = normal.dot(b - origin);
        if ((from >= 0) == (to >= 0)) return false;
        const Vec3 at = a + from / (from - to) * (b - a) - origin;
        if (radius > 0) return at.squaredNorm() <= radius * radius;
        return within(at, edge_u) && within(at, edge_v);
    }

private:
    static bool within(const Vec3& at, const Vec3& edge) {
        const double along = at.dot(edge);
        return along >= 0 && along <= edge.squaredNorm();
    }
};

}  // namespace perimpm
