#include "step/collider.hpp"

namespace perimpm {

Collider::Collider(const ColliderSpec& spec, ShapePtr shape)
    : spec_{spec}, shape_{std::move(shape)}, pivot_{spec.pivot} {}

void Collider::set_time(double t) {
    pivot_ = spec_.pivot + t * spec_.velocity;
    const double rate = spec_.angular_velocity.norm();
    if (rate > 0) rotation_ = Eigen::AngleAxisd(rate * t, spec_.angular_velocity / rate).toRotationMatrix();
}

Vec3 Collider::resolve(const Vec3& x, const Vec3& v) const {
    const Vec3 own = velocity(x);
    return own + resolve_contact(v - own, normal(x), spec_.contact, spec_.friction);
}

Vec3 Collider::hold(const Vec3& x, const Vec3& v) const {
    if (spec_.contact == Contact::separate) return v;
    const Vec3 own = velocity(x);
    return own + resolve_contact(v - own, normal(x), spec_.contact, 0.0);
}

double Collider::max_speed() const {
    const double rate = spec_.angular_velocity.norm();
    if (rate == 0) return spec_.velocity.norm();
    const Box3 box = shape_->bounds();
    double reach = 0;
    for (int corner = 0; corner < 8; ++corner)
        reach = std::max(reach, (box.corner(static_cast<Box3::CornerType>(corner)) - spec_.pivot).norm());
    return spec_.velocity.norm() + rate * reach;  // shapes that turn have an end
}

Vec3 resolve_contact(const Vec3& relative, const Vec3& normal, Contact contact, double friction) {
    if (contact == Contact::sticky) return Vec3::Zero();
    const double approach = relative.dot(normal);
    if (contact == Contact::separate && approach >= 0) return relative;
    const Vec3 along = relative - approach * normal;
    const double speed = along.norm(), lost = friction * std::abs(approach);
    if (speed <= lost) return Vec3::Zero();
    return along * (1 - lost / speed);
}

}  // namespace perimpm
