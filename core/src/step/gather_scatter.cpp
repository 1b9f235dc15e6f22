#include <limits>

#include "step/transfer.hpp"

namespace perimpm {

namespace {

/// What the kernel sees while it moves particles: velocities that the next scatter reads at once, and nobody else, stay in
/// the worker's scratch, unless the kernel asks for those of before, or the law may end the run and leave them to be seen.
template <class Real>
TransferBlock<Real> passing_through(World<Real>& w, const Material<Real>& m, TransferBlock<Real> b) {
    Scratch<Real>& s = w.own_scratch();
    b.dt = static_cast<Real>(w.motion.dt);
    if (m.needs.may_refuse) return b;
    if (!w.transfer_needs.own_velocity) b.v = s.v.view();
    if (w.transfer_needs.affine) b.C = s.C.view();
    return b;
}

template <class Real>
double measure(World<Real>& w, Material<Real>& m, std::size_t first, const TransferBlock<Real>& b) {
    Block<Real> law = make_block(w, m, first, b.size);
    law.v = b.v;
    return m.lightness * m.law->max_wave_speed(law);
}

template <class Real>
void move_and_scatter_block(World<Real>& w, std::size_t index) {
    const ParticleBlock& block = w.grid.particle_blocks()[index];
    Scratch<Real>& s = w.own_scratch();
    load_tiles(w, block, s.now);
    clear(w, s.next);
    BlockFindings found;
    for_each_run(w, index, [&](Material<Real>& m, std::size_t first, std::size_t size) {
        TransferBlock<Real> b = passing_through(w, m, make_transfer_block(w, m, block, first, size));
        w.transfer->gather(b);
        found.speed2 = std::max(found.speed2, static_cast<double>(b.fastest2));
        if (!w.colliders.empty()) found.collided = std::max(found.collided, collide_run(w, b.x, b.v, size));
        b.dt = static_cast<Real>(w.dt);
        b.tile = s.next.tile.data();
        if (b.increment) b.increment = s.next.increment.data();
        try {
            if (measures_now(w)) found.wave_speed = std::max(found.wave_speed, measure(w, m, first, b));
            scatter_stressed(w, m, first, b);
        } catch (...) {  // all other particles move, too, before the run ends
            if (!found.refusal) found.refusal = std::current_exception();
        }
    });
    w.grid.add_tile_to(block, s.next.tile.data(), w.grid.next_nodes());
    if (w.transfer_needs.increment) w.grid.add_tile_to(block, s.next.increment.data(), w.grid.next_increments());
    w.found[index] = found;
}

}  // namespace

template <class Real>
bool gather_can_wait(const World<Real>& w) {
    constexpr double rounding = static_cast<double>(std::numeric_limits<Real>::epsilon());
    // Contact takes at most the velocity relative to a collider, one collider after the other.
    const auto colliders = static_cast<double>(w.colliders.size());
    const double change = colliders * (w.motion.fastest + colliders * fastest_collider(w));
    const double farthest_move =
        (1 + 100 * rounding) * w.motion.dt * (w.motion.fastest + change) + rounding * w.farthest;
    return w.drift + farthest_move <= sort_margin(w.transfer_needs.order) * w.spacing();
}

template <class Real>
void gather_and_scatter(World<Real>& w) {
    w.timer("clear grid", [&] { clear_nodes(w, w.grid.next_nodes(), w.grid.next_increments()); });
    w.timer("gather, stress and scatter", [&] {
        w.found.resize(w.grid.particle_blocks().size());
        for_each_block_in_turn(w, [&](std::size_t b) { move_and_scatter_block(w, b); });
        w.grid.swap_nodes();
        const BlockFindings all = note_findings(w);
        w.drift += w.motion.dt * all.collided;
        if (all.refusal) std::rethrow_exception(all.refusal);
        if (measures_now(w)) w.wave_speed = all.wave_speed;
    });
}

template bool gather_can_wait(const World<float>&);
template bool gather_can_wait(const World<double>&);
template void gather_and_scatter(World<float>&);
template void gather_and_scatter(World<double>&);

}  // namespace perimpm
