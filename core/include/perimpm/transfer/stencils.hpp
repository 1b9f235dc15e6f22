#pragma once

#include <algorithm>

#include "perimpm/math/bspline.hpp"
#include "perimpm/transfer/column.hpp"

namespace perimpm::bspline {

inline constexpr std::size_t kBatch = 64;  ///< particles whose weights and quads lie in the first-level cache together
inline constexpr std::int32_t kRowStride = 4 * kTileNodes, kSlabStride = 4 * kTileNodes * kTileNodes;

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

/// Weights of a batch of particles and the places of their stencils in the tile.
template <class Real, int Order, bool Slopes>
struct Stencils {
    Quads<Real> weight[3];
    Quads<Real> slope[Slopes ? 3 : 1];   ///< d weight / d x in 1/dx
    alignas(64) Real node[kBatch];       ///< of the stencil's first node in the tile, in numbers
    alignas(64) Real offset[3][kBatch];  ///< from that node to the particle, in dx

    /// Fills the places of up to a pack of particles from number p of the batch; x in dx.
    void set(std::size_t p, const Pack<Real> x[3], const std::int32_t origin[3]) {
        using P = Pack<Real>;
        P first(0);
        for (int c = 0; c < 3; ++c) {
            const BSpline<P, Order> spline(x[c]);
            weight[c].store(p, spline.w);
            if constexpr (Slopes) slope[c].store(p, spline.dw);
            spline.offset.copy_to(offset[c] + p, std::experimental::element_aligned);
            first = first * Real(kTileNodes) + (spline.base - static_cast<Real>(origin[c]));
        }
        (Real(4) * first).copy_to(node + p, std::experimental::element_aligned);
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
