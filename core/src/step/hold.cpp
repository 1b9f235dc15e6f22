#include <algorithm>
#include <cmath>

#include "step/transfer.hpp"

namespace perimpm {

namespace {

/// Share of a node's mass that must prescribe a component for the node to be held along it. Splines are smooth, so what
/// is held ends about a quarter of a cell behind the last held node. A tenth is the share of a node 0.66 (quadratic) or
/// 0.75 cells (cubic) in front of the region's border: wherever the border lies in its cell, it acts within half a cell
/// of its place, and particles that move by a part of a cell do not switch nodes on a border plane on and off.
constexpr double kShare = 0.1;

/// Puts the run's held particles into the worker's scratch. Returns their number.
template <class Real>
std::uint32_t pack_held(World<Real>& w, Material<Real>& m, std::size_t first, std::size_t size,
                        std::uint32_t (&number)[kRun]) {
    Scratch<Real>& s = w.own_scratch();
    std::uint32_t count = 0;
    for (std::size_t i = first; i < first + size; ++i) {
        const std::size_t own = m.has_bonds() ? m.order[i] : i, p = m.begin + own;
        if (m.is_free(own)) continue;
        const std::uint32_t held = w.conditions.held[w.id[p]];
        if (held == Conditions<Real>::kFree) continue;
        for (int c = 0; c < 3; ++c) s.x[c][count] = w.x[c][p], s.force[c][count] = 0;
        for (int c = 0; c < 9; ++c) s.C[c][count] = 0;
        s.mass[count] = w.mass[p], s.volume[count] = w.volume[p];
        number[count++] = held;
    }
    return count;
}

template <class Real>
void scatter_held_block(World<Real>& w, std::size_t index) {
    const ParticleBlock& block = w.grid.particle_blocks()[index];
    Conditions<Real>& all = w.conditions;
    Scratch<Real>& s = w.own_scratch();
    AlignedArray<Real>& tile = s.now.tile;
    std::uint32_t number[kRun];
    // The kernel carries v from particles to nodes: first what is prescribed, then 1 where something is.
    for (const bool indicator : {false, true}) {
        std::fill_n(tile.data(), tile.size(), Real(0));
        for_each_run(w, index, [&](Material<Real>& m, std::size_t first, std::size_t size) {
            TransferBlock<Real> b = make_transfer_block(w, m, block, first, size);
            b.size = pack_held(w, m, first, size, number);
            if (b.size == 0) return;
            for (std::uint32_t i = 0; i < b.size; ++i)
                for (std::size_t c = 0; c < 3; ++c) {
                    const Real v = all.velocity[3 * number[i] + c];
                    s.v[c][i] = std::isnan(v) ? Real(0) : indicator ? Real(1) : v;
                }
            b.x = s.x.view(), b.v = s.v.view(), b.mass = s.mass.data(), b.volume = s.volume.data();
            b.force = s.force.view();
            if (w.transfer_needs.affine) b.C = s.C.view();
            b.F = {}, b.tau = {};
            w.transfer->scatter(b);
        });
        w.grid.add_tile_to(block, tile.data(), (indicator ? all.mass : all.momentum).data());
    }
}

template <class Real>
void fold_held(World<Real>& w, const NodeImage& image) {
    Conditions<Real>& all = w.conditions;
    if (image.node == image.of || !all.near[image.node / kNodesPerBlock]) return;
    const Real* momentum = all.momentum.data() + 4 * std::size_t{image.node};
    const Real* mass = all.mass.data() + 4 * std::size_t{image.node};
    Real* to_momentum = all.momentum.data() + 4 * std::size_t{image.of};
    Real* to_mass = all.mass.data() + 4 * std::size_t{image.of};
    for (int c = 0; c < 3; ++c)
        to_momentum[c] += image.flip >> c & 1 ? -momentum[c] : momentum[c], to_mass[c] += mass[c];
}

}  // namespace

/// After a sort: which blocks have held particles, and which nodes those reach.
template <class Real>
void prepare_held_nodes(World<Real>& w) {
    Conditions<Real>& all = w.conditions;
    const std::vector<ParticleBlock>& blocks = w.grid.particle_blocks();
    all.block_holds.assign(blocks.size(), 0);
    all.near.assign(w.grid.size(), 0);
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        for_each_run(w, b, [&](Material<Real>& m, std::size_t first, std::size_t size) {
            for (std::size_t i = first; i < first + size && !all.block_holds[b]; ++i)
                all.block_holds[b] =
                    all.held[w.id[m.begin + (m.has_bonds() ? m.order[i] : i)]] != Conditions<Real>::kFree;
        });
        if (!all.block_holds[b]) continue;
        for (const std::uint32_t link : blocks[b].links) all.near[link] = 1;
    }
    for (const NodeImage& image : w.grid.images())
        if (all.near[image.node / kNodesPerBlock]) all.near[image.of / kNodesPerBlock] = 1;
    const std::size_t needed = w.grid.size() * kBlockValues;
    if (all.mass.size() < needed) {
        all.mass = AlignedArray<Real>(needed + needed / 4);
        all.momentum = AlignedArray<Real>(needed + needed / 4);
    }
}

/// What prescribed particles bring to the nodes.
template <class Real>
void scatter_held(World<Real>& w) {
    Conditions<Real>& all = w.conditions;
    w.threads.run(w.grid.size(), [&](std::size_t g) {
        if (!all.near[g]) return;
        std::fill_n(all.momentum.data() + g * kBlockValues, kBlockValues, Real(0));
        std::fill_n(all.mass.data() + g * kBlockValues, kBlockValues, Real(0));
    });
    for_each_block_in_turn(w, [&](std::size_t b) {
        if (all.block_holds[b]) scatter_held_block(w, b);
    });
    for (const NodeImage& image : w.grid.images()) fold_held(w, image);
}

template <class Real>
void hold_nodes(World<Real>& w) {
    Conditions<Real>& all = w.conditions;
    w.threads.run(w.grid.size(), [&](std::size_t g) {
        if (!all.near[g]) return;
        Real* node = w.grid.nodes(g);
        Real* before = w.transfer_needs.increment ? w.grid.increments(g) : nullptr;
        const Real* momentum = all.momentum.data() + g * kBlockValues;
        const Real* mass = all.mass.data() + g * kBlockValues;
        for (std::size_t n = 0; n < kBlockValues; n += 4)
            for (std::size_t c = n; c < n + 3; ++c) {
                if (!(mass[c] > 0) || mass[c] < static_cast<Real>(kShare) * node[n + 3]) continue;
                node[c] = momentum[c] / mass[c];
                if (before) before[c] = node[c];
            }
    });
}

template void prepare_held_nodes(World<float>&);
template void prepare_held_nodes(World<double>&);
template void scatter_held(World<float>&);
template void scatter_held(World<double>&);
template void hold_nodes(World<float>&);
template void hold_nodes(World<double>&);

}  // namespace perimpm
