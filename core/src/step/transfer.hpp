#pragma once

#include <algorithm>

#include "step/stages.hpp"

namespace perimpm {

/// What the transfer kernel sees of `size` particles from number `first` of the material's grid order. Particles of
/// local laws lie in that order already; those of bond laws are brought into it in the worker's scratch.
template <class Real>
TransferBlock<Real> make_transfer_block(World<Real>& w, Material<Real>& m, const ParticleBlock& block,
                                        std::size_t first, std::size_t size) {
    Scratch<Real>& s = w.own_scratch();
    TransferBlock<Real> b;
    b.size = static_cast<std::uint32_t>(size);
    b.dt = static_cast<Real>(w.dt);
    b.spacing = static_cast<Real>(w.spacing());
    for (int c = 0; c < 3; ++c) b.origin[c] = kBlockNodes * block.coordinate[c] - kTileOffset;
    b.tile = s.now.tile.data();
    b.increment = w.transfer_needs.increment ? s.now.increment.data() : nullptr;
    const std::size_t at = m.begin + first;
    if (!m.has_bonds()) {
        b.x = w.x.view().from(at), b.v = w.v.view().from(at);
        if (w.transfer_needs.affine) b.C = w.C.view().from(at);
        b.F = m.F.view().from(first);
        b.mass = w.mass.data() + at, b.volume = w.volume.data() + at;
        return b;
    }
    b.x = s.x.view(), b.v = s.v.view(), b.mass = s.mass.data(), b.volume = s.volume.data();
    if (w.transfer_needs.affine) b.C = s.C.view();
    return b;
}

/// Copies between the places of a bond law's particles and a block in grid order, without those that have left the grid;
/// copy(in the block, in storage). Returns their number.
template <class Real, class Copy>
std::uint32_t for_each_placed(const Material<Real>& m, std::size_t first, std::size_t size, Copy copy) {
    std::uint32_t count = 0;
    for (std::size_t i = first; i < first + size; ++i)
        if (!m.is_free(m.order[i])) copy(count++, m.order[i]);
    return count;
}

/// Calls body(material, first, size) for runs of at most kRun particles of every material in particle block `b`.
template <class Real, class Body>
void for_each_run(World<Real>& w, std::size_t b, Body body) {
    for (Material<Real>& m : w.materials)
        for (std::size_t first = m.block_begin[b]; first < m.block_begin[b + 1]; first += kRun)
            body(m, first, std::min<std::size_t>(kRun, m.block_begin[b + 1] - first));
}

/// Calls body(number) for every particle block, in parallel, so that tiles of blocks visited at the same time do not
/// overlap, and that each node sees its blocks in the same order however many threads there are.
template <class Real, class Body>
void for_each_block_in_turn(World<Real>& w, Body body) {
    w.threads.run(w.grid.schedule(), [&](std::uint32_t item) {
        const BlockRange& range = w.grid.ranges()[item];
        for (std::uint32_t b = range.first; b < range.end; ++b) body(b);
    });
}

/// Zeros for all nodes, and for their increments where the transfer has such.
template <class Real>
void clear_nodes(World<Real>& w, Real* nodes, Real* increments) {
    w.threads.run(w.grid.size(), [&](std::size_t g) {
        std::fill_n(nodes + g * kBlockValues, kBlockValues, Real(0));
        if (w.transfer_needs.increment) std::fill_n(increments + g * kBlockValues, kBlockValues, Real(0));
    });
}

template <class Real>
void clear(const World<Real>& w, Tiles<Real>& tiles) {
    std::fill_n(tiles.tile.data(), tiles.tile.size(), Real(0));
    if (w.transfer_needs.increment) std::fill_n(tiles.increment.data(), tiles.increment.size(), Real(0));
}

template <class Real>
void load_tiles(const World<Real>& w, const ParticleBlock& block, Tiles<Real>& tiles) {
    w.grid.load_tile(block, tiles.tile.data(), false);
    if (w.transfer_needs.increment) w.grid.load_tile(block, tiles.increment.data(), true);
}

/// Stress of a local law's particles, in cache, and what they give to the tile.
template <class Real>
void scatter_stressed(World<Real>& w, Material<Real>& m, std::size_t first, TransferBlock<Real>& b) {
    Block<Real> law = make_block(w, m, first, b.size);
    law.v = b.v;
    law.tau = w.own_scratch().tau.view();
    m.law->evaluate(law, b.dt);
    b.tau = law.tau;
    w.transfer->scatter(b);
}

}  // namespace perimpm
