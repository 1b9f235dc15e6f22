#pragma once

#include "support/catch.hpp"
#include "support/particles.hpp"

/*! What every bond law whose force is its energy's gradient owes, on the cube of five lattice particles an edge. */
namespace perimpm {

inline constexpr double kShakenReach = 0.2;  ///< largest shift along an axis, in spacings

/// Shifts every particle at random and evaluates. Returns where they are.
inline std::vector<Vec3> shake(Particles<double>& particles, double spacing) {
    std::mt19937 random(10);
    std::uniform_real_distribution<double> shift(-kShakenReach * spacing, kShakenReach * spacing);
    std::vector<Vec3> y = particles.reference();
    for (std::size_t p = 0; p < y.size(); ++p)
        particles.place(p, y[p] += Vec3(shift(random), shift(random), shift(random)));
    particles.evaluate();
    return y;
}

/// Forces and their torques add up to nothing.
inline void check_momenta(Particles<double>& particles, const std::vector<Vec3>& y, double spacing) {
    Vec3 sum = Vec3::Zero(), torque = Vec3::Zero();
    double scale = 0;
    for (std::size_t p = 0; p < y.size(); ++p) {
        const Vec3 f = particles.force(p);
        sum += f, torque += y[p].cross(f), scale += f.norm();
    }
    CHECK(sum.norm() <= 1e-13 * scale);
    CHECK(torque.norm() <= 1e-13 * scale * 5 * spacing);
}

/// Forces of a corner, the centre and a particle of a face are minus the energy's slopes by central differences.
inline void check_gradient(Particles<double>& particles, const std::vector<Vec3>& y, double spacing) {
    const double step = 1e-6 * spacing, largest = particles.largest_force();
    for (const std::size_t p : {std::size_t{0}, middle(5), particles.size() - 3})
        for (int c = 0; c < 3; ++c) {
            const auto energy = [&](double by) {
                particles.place(p, y[p] + by * Vec3::Unit(c));
                return particles.energy();
            };
            const double slope = (energy(step) - energy(-step)) / (2 * step);
            particles.place(p, y[p]);
            CHECK_THAT(particles.force(p)[c], WithinAbs(-slope, 1e-6 * largest));
        }
}

/// A particle alone, a pair that pulls, and a bond shrunk to a point, which has no direction: no NaN.
template <class Real>
void check_few_bonds(const ConstitutiveLaw<Real>& law, double spacing, double volume) {
    Particles<Real> one(law, {Vec3::Zero()}, volume);
    one.evaluate();
    CHECK(one.largest_force() == 0);
    CHECK(one.energy() == 0);
    Particles<Real> pair(law, {Vec3::Zero(), Vec3(spacing, 0, 0)}, volume);
    pair.place(1, {2 * spacing, 0, 0});
    pair.evaluate();
    CHECK(pair.force(0)[0] > 0);
    CHECK((pair.force(0) + pair.force(1)).norm() <= 1e-6 * pair.force(0).norm());
    CHECK(std::isfinite(pair.energy()));
    pair.place(1, Vec3::Zero());
    pair.evaluate();
    CHECK(pair.largest_force() == 0);
}

}  // namespace perimpm
