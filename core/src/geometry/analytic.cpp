// Solids with a closed-form signed distance. All distances are exact everywhere. On the medial axis, where several
// surface points are equally near, normal() returns one of the equally good directions.
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "perimpm/error.hpp"
#include "perimpm/geometry/shape.hpp"

namespace perimpm {

Shape::~Shape() = default;

namespace {

std::string text(const Vec3& v) {
    std::ostringstream out;
    out << '[' << v.x() << ", " << v.y() << ", " << v.z() << ']';
    return out.str();
}

void require_finite(const Vec3& v, const std::string& what) {
    if (!v.allFinite()) throw InputError(what + " is " + text(v) + "; expected three finite numbers");
}

void require_positive(double value, const std::string& what) {
    if (std::isfinite(value) && value > 0.0) return;
    throw InputError(what + " is " + std::to_string(value) + "; expected a positive length in m");
}

double sign(double value) { return value < 0.0 ? -1.0 : 1.0; }

class HalfSpace final : public Shape {
public:
    HalfSpace(const Vec3& point, const Vec3& unit_normal) : point_(point), normal_(unit_normal) {}
    double signed_distance(const Vec3& x) const override { return normal_.dot(x - point_); }
    Vec3 normal(const Vec3&) const override { return normal_; }
    Box3 bounds() const override {
        const Vec3 far = Vec3::Constant(std::numeric_limits<double>::infinity());
        return {-far, far};
    }

private:
    Vec3 point_;
    Vec3 normal_;
};

class Box final : public Shape {
public:
    Box(const Vec3& min, const Vec3& max) : bounds_(min, max), center_(0.5 * (min + max)), half_(0.5 * (max - min)) {}

    double signed_distance(const Vec3& x) const override {
        const Vec3 q = beyond_faces(x);
        return q.maxCoeff() > 0.0 ? q.cwiseMax(0.0).norm() : q.maxCoeff();
    }

    Vec3 normal(const Vec3& x) const override {
        const Vec3 side = (x - center_).unaryExpr(&sign);
        const Vec3 q = beyond_faces(x);
        Eigen::Index nearest_face;
        if (q.maxCoeff(&nearest_face) > 0.0) return q.cwiseMax(0.0).normalized().cwiseProduct(side);
        return side(nearest_face) * Vec3::Unit(nearest_face);
    }

    Box3 bounds() const override { return bounds_; }

private:
    /// Distance beyond the nearer face of each pair, negative between them [m].
    Vec3 beyond_faces(const Vec3& x) const { return (x - center_).cwiseAbs() - half_; }

    Box3 bounds_;
    Vec3 center_;
    Vec3 half_;
};

class Sphere final : public Shape {
public:
    Sphere(const Vec3& center, double radius) : center_(center), radius_(radius) {}
    double signed_distance(const Vec3& x) const override { return (x - center_).norm() - radius_; }
    Vec3 normal(const Vec3& x) const override {
        const Vec3 d = x - center_;
        const double length = d.norm();
        return length > 0.0 ? Vec3(d / length) : Vec3::UnitY();
    }
    Box3 bounds() const override { return {center_ - Vec3::Constant(radius_), center_ + Vec3::Constant(radius_)}; }

private:
    Vec3 center_;
    double radius_;
};

class Cylinder final : public Shape {
public:
    Cylinder(const Vec3& start, const Vec3& end, double radius)
        : center_(0.5 * (start + end)),
          axis_((end - start).normalized()),
          half_length_(0.5 * (end - start).norm()),
          radius_(radius) {}

    double signed_distance(const Vec3& x) const override {
        const Split s = split(x);
        const double side = s.radial - radius_, cap = std::abs(s.along) - half_length_;
        if (side > 0.0 && cap > 0.0) return std::hypot(side, cap);
        return std::max(side, cap);
    }

    Vec3 normal(const Vec3& x) const override {
        const Split s = split(x);
        const double side = s.radial - radius_, cap = std::abs(s.along) - half_length_;
        const Vec3 cap_normal = sign(s.along) * axis_;
        if (side > 0.0 && cap > 0.0) return (side * s.outward + cap * cap_normal).normalized();
        return side > cap ? s.outward : cap_normal;
    }

    /// A disk of radius r across the unit vector a reaches r sqrt(1 - a_i^2) along axis i.
    Box3 bounds() const override {
        const Vec3 disk = radius_ * (1.0 - axis_.array().square()).max(0.0).sqrt().matrix();
        const Vec3 reach = half_length_ * axis_.cwiseAbs() + disk;
        return {center_ - reach, center_ + reach};
    }

private:
    struct Split {
        double along;   ///< along the axis, 0 in the middle [m]
        double radial;  ///< from the axis [m]
        Vec3 outward;   ///< unit vector away from the axis
    };

    Split split(const Vec3& x) const {
        const Vec3 d = x - center_;
        const double along = axis_.dot(d);
        const Vec3 across = d - along * axis_;
        const double radial = across.norm();
        return {along, radial, radial > 0.0 ? Vec3(across / radial) : axis_.unitOrthogonal()};
    }

    Vec3 center_;
    Vec3 axis_;
    double half_length_;
    double radius_;
};

}  // namespace

ShapePtr make_half_space(const Vec3& point, const Vec3& normal) {
    require_finite(point, "half space: point");
    require_finite(normal, "half space: normal");
    if (normal.norm() == 0.0) throw InputError("half space: normal is zero; expected a direction such as [0, 1, 0]");
    return std::make_shared<HalfSpace>(point, normal.normalized());
}

ShapePtr make_box(const Vec3& min, const Vec3& max) {
    require_finite(min, "box: min");
    require_finite(max, "box: max");
    if ((min.array() >= max.array()).any())
        throw InputError("box: min " + text(min) + " is not below max " + text(max) + " on every axis");
    return std::make_shared<Box>(min, max);
}

ShapePtr make_sphere(const Vec3& center, double radius) {
    require_finite(center, "sphere: center");
    require_positive(radius, "sphere: radius");
    return std::make_shared<Sphere>(center, radius);
}

ShapePtr make_cylinder(const Vec3& start, const Vec3& end, double radius) {
    require_finite(start, "cylinder: start");
    require_finite(end, "cylinder: end");
    require_positive(radius, "cylinder: radius");
    if (start == end) throw InputError("cylinder: start and end are both " + text(start) + "; expected two points");
    return std::make_shared<Cylinder>(start, end, radius);
}

}  // namespace perimpm
