#pragma once

#include "perimpm/scene/scene.hpp"

namespace perimpm {

/// A rigid obstacle with prescribed motion: velocity, and rotation about a pivot that moves along.
class Collider {
public:
    Collider(const ColliderSpec& spec, ShapePtr shape);

    /// Moves the collider to time t [s].
    void set_time(double t);
    double signed_distance(const Vec3& x) const { return shape_->signed_distance(to_local(x)); }
    Vec3 normal(const Vec3& x) const { return rotation_ * shape_->normal(to_local(x)); }
    Vec3 velocity(const Vec3& x) const { return spec_.velocity + spec_.angular_velocity.cross(x - pivot_); }
    /// What becomes of a velocity at a point inside.
    Vec3 resolve(const Vec3& x, const Vec3& v) const;
    /// The part of it that holds at all times: sticky and slip without friction; separate changes nothing.
    Vec3 hold(const Vec3& x, const Vec3& v) const;
    /// Largest speed of a surface point [m/s]; 0 for a still collider.
    double max_speed() const;

    const std::string& name() const { return spec_.name; }

private:
    Vec3 to_local(const Vec3& x) const { return rotation_.transpose() * (x - pivot_) + spec_.pivot; }

    ColliderSpec spec_;
    ShapePtr shape_;
    Vec3 pivot_;
    Eigen::Matrix3d rotation_ = Eigen::Matrix3d::Identity();
};

/// Velocity relative to an obstacle after contact (Stomakhin et al. 2013, section 8): sticky takes the obstacle's; slip
/// loses the normal part; separate loses it only when approaching. Friction: Coulomb, sticking where it suffices.
Vec3 resolve_contact(const Vec3& relative, const Vec3& normal, Contact contact, double friction);

}  // namespace perimpm
