#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "perimpm/error.hpp"
#include "step/stages.hpp"

namespace perimpm {

namespace {

template <class Real>
TransferBlock<Real> particles_of(World<Real>& w, Material<Real>& m, const Block<Real>& b) {
    TransferBlock<Real> t;
    t.size = b.size;
    t.dt = static_cast<Real>(w.dt);
    t.x = w.x.view().from(m.begin + b.first), t.v = w.v.view().from(m.begin + b.first);
    t.force = b.force;
    t.mass = b.mass, t.volume = b.volume;
    return t;
}

/// Of all positions and velocities: not finite when any of them is not.
template <class Real>
double sum_of(const TransferBlock<Real>& t) {
    double sum = 0;
    for (int c = 0; c < 3; ++c)
        for (std::uint32_t i = 0; i < t.size; ++i)
            sum += static_cast<double>(t.x[c][i]) + static_cast<double>(t.v[c][i]);
    return sum;
}

template <class Real>
void kick(World<Real>& w) {
    Real gravity[3];
    const auto decay = static_cast<Real>(std::exp(-w.scene.simulation.damping * w.dt / 2));
    for (int c = 0; c < 3; ++c) gravity[c] = static_cast<Real>(w.scene.simulation.gravity[c]);
    for (Material<Real>& m : w.materials) {
        const double sum = reduce_chunks(
            w, m, 0.0,
            [&](Block<Real>& b) {
                TransferBlock<Real> t = particles_of(w, m, b);
                w.integrator->kick(t, gravity);
                for (int c = 0; decay < 1 && c < 3; ++c)
                    for (std::uint32_t i = 0; i < t.size; ++i) t.v[c][i] *= decay;
                return sum_of(t);
            },
            std::plus<>());
        if (!std::isfinite(sum))
            throw SimulationError(fmt::format(
                "positions or velocities of material '{}' are no longer finite in step {} (t = {:g} s, dt = {:g} s): "
                "the step is unstable; lower simulation.safety or dt",
                m.name, w.steps + 1, w.time, w.dt));
    }
}

/// Loads of time `force_time` for half a step, velocities of `velocity_time`.
template <class Real>
void meet_conditions(World<Real>& w, double force_time, double velocity_time) {
    if (w.conditions.list.empty()) return;
    w.timer("conditions", [&] {
        apply_loads(w, force_time, w.dt / 2);
        prescribe_velocities(w, velocity_time);
    });
}

}  // namespace

/// Without a grid: velocity Verlet with the forces of the step before.
template <class Real>
void integrate_particles(World<Real>& w) {
    for (Collider& collider : w.colliders) collider.set_time(w.time + w.dt);
    if (!w.forces_known) compute_bond_forces(w);
    w.timer("kick and drift", [&] { kick(w); });
    meet_conditions(w, w.time, w.time + w.dt / 2);
    if (!w.colliders.empty()) w.timer("particle collisions", [&] { collide_particles(w); });
    w.timer("kick and drift", [&] {
        for (Material<Real>& m : w.materials)
            for_each_chunk(w, m, [&](std::size_t, Block<Real>& b) {
                TransferBlock<Real> t = particles_of(w, m, b);
                w.integrator->drift(t);
            });
    });
    compute_bond_forces(w);
    w.forces_known = true;
    w.timer("kick and drift", [&] { kick(w); });
    meet_conditions(w, w.time + w.dt, w.time + w.dt);
}

template void integrate_particles(World<float>&);
template void integrate_particles(World<double>&);

}  // namespace perimpm
