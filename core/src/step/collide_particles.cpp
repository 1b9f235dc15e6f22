#include <algorithm>

#include "step/world.hpp"

namespace perimpm {

namespace {

template <class Real>
Vec3 load3(const Field<const Real>& f, std::size_t i) {
    return {static_cast<double>(f[0][i]), static_cast<double>(f[1][i]), static_cast<double>(f[2][i])};
}

/// Largest change of a velocity in the block [m/s].
template <class Real>
double collide_block(World<Real>& w, const Material<Real>& m, const Block<Real>& b) {
    // FLIP moves particles with the grid's velocity, which has been stopped already, not with the one changed here
    const double moved = w.transfer_needs.grid && !w.transfer_needs.increment ? w.dt : 0.0;
    Box3 box;
    for (std::uint32_t i = 0; i < b.size; ++i) box.extend(load3(b.x, i));
    double largest = 0;
    for (const Collider& collider : w.colliders) {
        if (collider.signed_distance(box.center()) > 0.5 * box.diagonal().norm()) continue;
        for (std::uint32_t i = 0; i < b.size; ++i) {
            const Vec3 x = load3(b.x, i);
            if (collider.signed_distance(x) > 0) continue;
            const Vec3 v = load3(b.v, i);
            const Vec3 change = collider.resolve(x, v) - v;
            for (int c = 0; c < 3; ++c) {
                w.v[c][m.begin + b.first + i] = static_cast<Real>(v[c] + change[c]);
                w.x[c][m.begin + b.first + i] = static_cast<Real>(x[c] + moved * change[c]);
            }
            largest = std::max(largest, change.norm());
        }
    }
    return largest;
}

}  // namespace

/// Particles inside a collider get the velocity that contact allows (step 6 of the method; Stomakhin et al. 2013,
/// section 8). Through a grid they have moved by then, so the change of velocity moves them, too: otherwise they would
/// sink into curved colliders, whose surface the grid sees only at its nodes.
template <class Real>
void collide_particles(World<Real>& w) {
    for (Material<Real>& m : w.materials) {
        const double largest = reduce_chunks(
            w, m, 0.0, [&](Block<Real>& b) { return collide_block(w, m, b); },
            [](double a, double b) { return std::max(a, b); });
        w.drift += w.dt * largest;
    }
}

template void collide_particles(World<float>&);
template void collide_particles(World<double>&);

}  // namespace perimpm
