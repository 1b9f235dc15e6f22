#include <fmt/format.h>

#include <cmath>

#include "perimpm/error.hpp"
#include "step/stages.hpp"

namespace perimpm {

namespace {

/// Faces of the domain stop a particle that has left through them, as separating obstacles; sticky ones hold it.
template <class Real>
Vec3 obey_faces(const World<Real>& w, const Vec3& x, Vec3 v) {
    const GridSpec& grid = w.scene.grid;
    for (int f = 0; f < 6 && grid.bounded; ++f) {
        const Face face = grid.faces[f];
        if (face == Face::open || face == Face::periodic) continue;
        const int axis = f / 2;
        const bool upper = f % 2;
        if (upper ? x[axis] < grid.domain.max()[axis] : x[axis] > grid.domain.min()[axis]) continue;
        v = resolve_contact(v, Vec3::Unit(axis) * (upper ? -1.0 : 1.0),
                            face == Face::sticky ? Contact::sticky : Contact::separate,
                            face == Face::symmetry ? 0.0 : grid.face_friction);
    }
    return v;
}

/// Returns the square of the largest speed, not a number if one is not finite.
template <class Real>
double move_block(World<Real>& w, const Material<Real>& m, const Block<Real>& b) {
    const double decay = std::exp(-w.scene.simulation.damping * w.dt);
    const Field<Real> x = w.x.view().from(m.begin + b.first), v = w.v.view().from(m.begin + b.first);
    double fastest2 = 0;
    for (std::uint32_t i = 0; i < b.size; ++i) {
        if (b.family.damage[i] == 0) continue;
        Vec3 at, speed;
        for (int c = 0; c < 3; ++c) {
            const double pull = static_cast<double>(b.force[c][i]) / static_cast<double>(b.mass[i]);
            speed[c] = decay * (static_cast<double>(v[c][i]) + w.dt * (pull + w.scene.simulation.gravity[c]));
            at[c] = static_cast<double>(x[c][i]);
        }
        speed = obey_faces(w, at + w.dt * speed, speed);
        for (int c = 0; c < 3; ++c) {
            v[c][i] = static_cast<Real>(speed[c]);
            x[c][i] = static_cast<Real>(at[c] + w.dt * speed[c]);
        }
        for (std::size_t c = 0; c < w.C.components(); ++c) w.C[c][m.begin + b.first + i] = 0;
        const double speed2 = speed.squaredNorm();
        if (!(speed2 <= fastest2)) fastest2 = speed2;
    }
    return fastest2;
}

}  // namespace

/// Symplectic Euler, as on the grid: the forces of the step's start, on the velocity that the particle has by itself (Lyu et
/// al. 2019, section 3.4). What its bonds do to particles on the grid is among the forces of those: momentum is exact.
template <class Real>
void move_crack_surfaces(World<Real>& w) {
    double fastest2 = 0;
    for (Material<Real>& m : w.materials) {
        if (!m.frees_crack_surfaces) continue;
        fastest2 = reduce_chunks(
            w, m, fastest2, [&](Block<Real>& b) { return move_block(w, m, b); },
            [](double a, double b) { return a >= b ? a : b; });  // keeps what is not a number
    }
    if (!std::isfinite(fastest2))
        throw SimulationError(fmt::format(
            "velocities at crack surfaces are no longer finite in step {} (t = {:g} s, dt = {:g} s): the step "
            "is unstable; lower simulation.safety or dt",
            w.steps, w.time, w.motion.dt));
    w.max_speed = std::max(w.max_speed, std::sqrt(fastest2));
}

template void move_crack_surfaces(World<float>&);
template void move_crack_surfaces(World<double>&);

}  // namespace perimpm
