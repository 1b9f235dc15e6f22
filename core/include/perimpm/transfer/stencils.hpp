#pragma once

#include <algorithm>

#include "perimpm/math/bspline.hpp"
#include "perimpm/transfer/column.hpp"

namespace perimpm::bspline {

inline constexpr std::size_t kBatch = 64;  ///< particles whose weights and quads lie in the first-level cache together
inline constexpr std::int32_t kRowStride = 4 * kTileNodes, kSlabStride = 4 * kTileNodes * kTileNodes;

/// As many particles as a cell usually holds.
template <class Real>
inline constexpr std::size_t kGroup = std::min<std::size_t>(8, kLanes<Real>);
template <class Real>
using Group = std::experimental::simd<Real, std::experimental::simd_abi::deduce_t<Real, kGroup<Real>>>;

/// A number for each particle of a batch, and room for the idle lanes of its last group.
template <class Real>
struct Lanes {
    alignas(64) Real values[kBatch + kGroup<Real>];

    Group<Real> group(std::size_t p) const { return {values + p, std::experimental::element_aligned}; }
    void store(std::size_t p, const Group<Real>& group) {
        group.copy_to(values + p, std::experimental::element_aligned);
    }
    Pack<Real> pack(std::size_t p) const { return {values + p, std::experimental::element_aligned}; }
    void store_pack(std::size_t p, const Pack<Real>& pack) {
        pack.copy_to(values + p, std::experimental::element_aligned);
    }
};

/// Quads of a batch of particles.
template <class Real>
struct Quads {
    alignas(64) Real values[4 * kBatch];

    static std::size_t place(std::size_t p) {
        constexpr std::size_t N = kLanes<Real>;
        return 4 * (p - p % N + quad_place<Real>(p % N));
    }
    Real* at(std::size_t place) { return values + place; }
    const Real* at(std::size_t place) const { return values + place; }
    void store(std::size_t p, const Pack<Real> component[4]) { store_quads<Real>(values + 4 * p, component); }
    void load(std::size_t p, Pack<Real> component[4]) const { load_quads<Real>(values + 4 * p, component); }
};

/// Where the stencils of a batch of particles lie.
template <class Real, int Order>
struct Stencils {
    alignas(64) Real node[kBatch];  ///< of the stencil's first node in the tile, in numbers
    Lanes<Real> offset[3];          ///< from that node to the particle, in dx

    /// Fills the places of up to a pack of particles from number p of the batch; x in dx. keep(splines) takes the weights
    /// of the three axes.
    template <class Keep>
    void set(std::size_t p, const Pack<Real> x[3], const std::int32_t origin[3], Keep keep) {
        using Spline = BSpline<Pack<Real>, Order>;
        const Spline splines[3] = {Spline(x[0]), Spline(x[1]), Spline(x[2])};
        Pack<Real> first(0);
        for (int c = 0; c < 3; ++c) {
            offset[c].store_pack(p, splines[c].offset);
            first = first * Real(kTileNodes) + (splines[c].base - static_cast<Real>(origin[c]));
        }
        (Real(4) * first).copy_to(node + p, std::experimental::element_aligned);
        keep(splines);
    }
};

/// Calls body(first, count) for batches of at most kBatch particles.
template <class Body>
void for_each_batch(std::size_t size, Body body) {
    for (std::size_t first = 0; first < size; first += kBatch) body(first, std::min(kBatch, size - first));
}

/// Calls body(p, end, node) for runs p .. end - 1 of the batch whose stencils start at the same node.
template <class Real, class Body>
void for_each_cell(const Real* node, std::size_t size, Body body) {
    for (std::size_t p = 0; p < size;) {
        std::size_t end = p + 1;
        while (end < size && node[end] == node[p]) ++end;
        body(p, end, static_cast<std::int32_t>(node[p]));
        p = end;
    }
}

}  // namespace perimpm::bspline
