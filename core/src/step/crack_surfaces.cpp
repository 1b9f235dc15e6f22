#include <fmt/format.h>

#include <cmath>

#include "perimpm/error.hpp"
#include "perimpm/math/pseudo_inverse.hpp"
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
        const double speed2 = speed.squaredNorm();
        if (!(speed2 <= fastest2)) fastest2 = speed2;
    }
    return fastest2;
}

/// The family of particle p, broken bonds included, turns a little faster: v += dw x r about its centre of mass with I dw = L,
/// which leaves linear momentum as it is. A family on a line cannot take up what turns about it.
template <class Real>
void give_to_family(World<Real>& w, const Material<Real>& m, std::uint32_t p, const Vec3& spin) {
    constexpr double kSingular = 1e-6;  // moments of inertia below this share of the largest count as zero
    const auto for_each_member = [&](auto body) {
        body(m.begin + p);
        for (std::uint32_t slot = m.bonds.row[p]; slot < m.bonds.row[p + 1]; ++slot)
            body(m.begin + m.bonds.neighbour[slot]);
    };
    const auto place = [&](std::size_t q) {
        return Vec3(static_cast<double>(w.x[0][q]), static_cast<double>(w.x[1][q]), static_cast<double>(w.x[2][q]));
    };
    double mass = 0;
    Vec3 center = Vec3::Zero();
    for_each_member([&](std::size_t q) {
        const auto own = static_cast<double>(w.mass[q]);
        mass += own, center += own * place(q);
    });
    center /= mass;
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
    for_each_member([&](std::size_t q) {
        const Vec3 r = place(q) - center;
        inertia += static_cast<double>(w.mass[q]) * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
    });
    const Vec3 faster = pseudo_inverse(inertia, kSingular) * spin;
    for_each_member([&](std::size_t q) {
        const Vec3 more = faster.cross(place(q) - center);
        for (int c = 0; c < 3; ++c) w.v[c][q] += static_cast<Real>(more[c]);
    });
}

}  // namespace

template <class Real>
void leave_grid(World<Real>& w, Material<Real>& m, std::span<const std::uint32_t> particles) {
    if (!m.frees_crack_surfaces || !w.transfer_needs.affine) return;
    for (const std::uint32_t p : particles) {
        give_to_family(w, m, p, affine_spin(w, m.begin + p));
        for (std::size_t c = 0; c < w.C.components(); ++c) w.C[c][m.begin + p] = 0;
    }
}

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

template void leave_grid(World<float>&, Material<float>&, std::span<const std::uint32_t>);
template void leave_grid(World<double>&, Material<double>&, std::span<const std::uint32_t>);
template void move_crack_surfaces(World<float>&);
template void move_crack_surfaces(World<double>&);

}  // namespace perimpm
