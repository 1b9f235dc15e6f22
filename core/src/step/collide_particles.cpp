#include <algorithm>

#include "step/stages.hpp"

namespace perimpm {

namespace {

template <class Real>
Vec3 load3(const Field<Real>& f, std::size_t i) {
    return {static_cast<double>(f[0][i]), static_cast<double>(f[1][i]), static_cast<double>(f[2][i])};
}

}  // namespace

template <class Real>
double collide_run(World<Real>& w, const Field<Real>& x, const Field<Real>& v, std::size_t size) {
    // FLIP moves particles with the grid's velocity, which has been stopped already, not with the one changed here
    const double moved = w.transfer_needs.grid && !w.transfer_needs.increment ? w.motion.dt : 0.0;
    Box3 box;
    for (std::size_t i = 0; i < size; ++i) box.extend(load3(x, i));
    const double reach = 0.5 * box.diagonal().norm() + w.spacing();  // more than distances sampled from a mesh err by
    std::vector<const Collider*>& near = w.own_scratch().near.colliders;
    near.clear();
    for (const Collider& collider : w.colliders)
        if (collider.signed_distance(box.center()) <= reach) near.push_back(&collider);
    double largest = 0;
    for (std::size_t i = 0; i < size && !near.empty(); ++i) {
        double changed = 0;
        for (const Collider* collider : near) {
            const Vec3 at = load3(x, i), before = load3(v, i);
            if (collider->signed_distance(at) > 0) continue;
            const Vec3 change = collider->resolve(at, before) - before;
            for (int c = 0; c < 3; ++c) {
                v[c][i] = static_cast<Real>(before[c] + change[c]);
                x[c][i] = static_cast<Real>(at[c] + moved * change[c]);
            }
            changed += change.norm();
        }
        largest = std::max(largest, changed);
    }
    return largest;
}

/// Particles inside a collider get the velocity that contact allows (step 6 of the method; Stomakhin et al. 2013,
/// section 8). Through a grid they have moved by then, so the change of velocity moves them, too: otherwise they would
/// sink into curved colliders, whose surface the grid sees only at its nodes.
template <class Real>
void collide_particles(World<Real>& w) {
    double largest = 0;
    for (Material<Real>& m : w.materials)
        largest = reduce_chunks(
            w, m, largest,
            [&](Block<Real>& b) {
                const std::size_t at = m.begin + b.first;
                return collide_run(w, w.x.view().from(at), w.v.view().from(at), b.size);
            },
            [](double a, double b) { return std::max(a, b); });
    w.drift += w.motion.dt * largest;
}

template double collide_run(World<float>&, const Field<float>&, const Field<float>&, std::size_t);
template double collide_run(World<double>&, const Field<double>&, const Field<double>&, std::size_t);
template void collide_particles(World<float>&);
template void collide_particles(World<double>&);

}  // namespace perimpm
