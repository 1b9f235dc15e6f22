#include "step/world.hpp"

namespace perimpm {

/// Particles inside a collider get the velocity that contact allows (step 6 of the method; Stomakhin et al. 2013,
/// section 8).
template <class Real>
void collide_particles(World<Real>& w) {
    for (Material<Real>& m : w.materials)
        for_each_chunk(w, m, [&](std::size_t, Block<Real>& b) {
            Box3 box;
            const auto position = [&](std::uint32_t i) {
                return Vec3(static_cast<double>(b.x[0][i]), static_cast<double>(b.x[1][i]),
                            static_cast<double>(b.x[2][i]));
            };
            for (std::uint32_t i = 0; i < b.size; ++i) box.extend(position(i));
            for (const Collider& collider : w.colliders) {
                if (collider.signed_distance(box.center()) > 0.5 * box.diagonal().norm()) continue;
                for (std::uint32_t i = 0; i < b.size; ++i) {
                    const Vec3 x = position(i);
                    if (collider.signed_distance(x) > 0) continue;
                    const std::size_t at = m.begin + b.first + i;
                    const Vec3 v =
                        collider.resolve(x, Vec3(static_cast<double>(w.v[0][at]), static_cast<double>(w.v[1][at]),
                                                 static_cast<double>(w.v[2][at])));
                    for (int c = 0; c < 3; ++c) w.v[c][at] = static_cast<Real>(v[c]);
                }
            }
        });
}

template void collide_particles(World<float>&);
template void collide_particles(World<double>&);

}  // namespace perimpm
