#include <algorithm>

#include "step/transfer.hpp"

namespace perimpm {

namespace {

/// Brings what the kernel reads of a bond law's particles into grid order.
template <class Real>
void pack(World<Real>& w, Material<Real>& m, TransferBlock<Real>& b, std::size_t first) {
    Scratch<Real>& s = w.own_scratch();
    const bool stress = m.needs.stress;
    if (stress)
        b.tau = s.tau.view();
    else
        b.force = s.force.view();
    b.size = for_each_placed(m, first, b.size, [&](std::size_t to, std::size_t from) {
        const std::size_t at = m.begin + from;
        for (int c = 0; c < 3; ++c) {
            s.x[c][to] = w.x[c][at];
            s.v[c][to] = w.v[c][at];
            if (!stress) s.force[c][to] = m.force[c][from];
        }
        for (std::size_t c = 0; stress && c < 6; ++c) s.tau[c][to] = m.stress[c][from];
        for (std::size_t c = 0; b.C && c < 9; ++c) s.C[c][to] = w.C[c][at];
        s.mass[to] = w.mass[at], s.volume[to] = w.volume[at];
    });
}

template <class Real>
void scatter_block(World<Real>& w, std::size_t index) {
    const ParticleBlock& block = w.grid.particle_blocks()[index];
    Scratch<Real>& s = w.own_scratch();
    clear(w, s.now);
    for_each_run(w, index, [&](Material<Real>& m, std::size_t first, std::size_t size) {
        TransferBlock<Real> b = make_transfer_block(w, m, block, first, size);
        if (m.has_bonds()) {
            pack(w, m, b, first);
            if (b.size > 0) w.transfer->scatter(b);
        } else {
            scatter_stressed(w, m, first, b);
        }
    });
    w.grid.add_tile(block, s.now.tile.data(), false);
    if (w.transfer_needs.increment) w.grid.add_tile(block, s.now.increment.data(), true);
}

}  // namespace

/// Mass, momentum and internal forces to the grid. Stress of local laws is computed here, in cache. Nothing is atomic, and
/// sums have a fixed order.
template <class Real>
void scatter(World<Real>& w) {
    w.timer("clear grid", [&] { clear_nodes(w, w.grid.nodes(0), w.grid.increments(0)); });
    const bool stress =
        std::any_of(w.materials.begin(), w.materials.end(), [](const auto& m) { return !m.has_bonds(); });
    w.timer(stress ? "stress and scatter" : "scatter",
            [&] { for_each_block_in_turn(w, [&](std::size_t b) { scatter_block(w, b); }); });
}

template void scatter(World<float>&);
template void scatter(World<double>&);

}  // namespace perimpm
