#pragma once

#include "step/world.hpp"

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
    b.tile = s.tile.data();
    b.increment = w.transfer_needs.increment ? s.increment.data() : nullptr;
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

/// Copies between the places of a bond law's particles and a block in grid order; copy(in grid order, in storage).
template <class Real, class Copy>
void for_each_placed(const Material<Real>& m, std::size_t first, std::size_t size, Copy copy) {
    for (std::size_t i = 0; i < size; ++i) copy(i, m.order[first + i]);
}

/// Calls body(material, first, size) for runs of at most kChunk particles of every material in particle block `b`.
template <class Real, class Body>
void for_each_run(World<Real>& w, std::size_t b, Body body) {
    for (Material<Real>& m : w.materials)
        for (std::size_t first = m.block_begin[b]; first < m.block_begin[b + 1]; first += kChunk)
            body(m, first, std::min<std::size_t>(kChunk, m.block_begin[b + 1] - first));
}

}  // namespace perimpm
