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

/// A number for each particle of a batch, and room for the idle lanes of its last group, at least three.
template <class Real>
struct Lanes {
    alignas(64) Real values[kBatch + std::max<std::size_t>(4, kGroup<Real>)];

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
};

/// Splines of a pack of particles along the three axes.
template <class Real, int Order>
struct Splines {
    BSpline<Pack<Real>, Order> axis[3];

    /// `count` particles from number `at` of the block.
    PERIMPM_INLINE Splines(const Field<Real>& x, std::size_t at, std::size_t count, Real inverse_spacing)
        : axis{along(x[0] + at, count, inverse_spacing), along(x[1] + at, count, inverse_spacing),
               along(x[2] + at, count, inverse_spacing)} {}
    /// The first node of each stencil in the tile, in numbers.
    PERIMPM_INLINE Pack<Real> node(const std::int32_t origin[3]) const {
        Pack<Real> first(0);
        for (int c = 0; c < 3; ++c) first = first * Real(kTileNodes) + (axis[c].base - static_cast<Real>(origin[c]));
        return Real(4) * first;
    }

private:
    PERIMPM_INLINE static BSpline<Pack<Real>, Order> along(const Real* x, std::size_t count, Real inverse_spacing) {
        return BSpline<Pack<Real>, Order>(load(x, count) * inverse_spacing);
    }
};

/// Calls body(first, count) for batches of at most kBatch particles.
template <class Body>
PERIMPM_INLINE void for_each_batch(std::size_t size, Body body) {
    for (std::size_t first = 0; first < size; first += kBatch) body(first, std::min(kBatch, size - first));
}

/// Calls body(p, end, node) for runs p .. end - 1 of the batch whose stencils start at the same node.
template <class Real, class Body>
PERIMPM_INLINE void for_each_cell(const Real* node, std::size_t size, Body body) {
    for (std::size_t p = 0; p < size;) {
        std::size_t end = p + 1;
        while (end < size && node[end] == node[p]) ++end;
        body(p, end, static_cast<std::int32_t>(node[p]));
        p = end;
    }
}

}  // namespace perimpm::bspline
