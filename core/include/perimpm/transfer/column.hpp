#pragma once

#include "perimpm/math/quads.hpp"
#include "perimpm/model/transfer_kernel.hpp"

namespace perimpm::bspline {

namespace detail {

using perimpm::detail::as_pack, perimpm::detail::as_vector, perimpm::detail::repeat_quad, perimpm::detail::Vec;

/// From repeated quads: in the k-th group of four lanes, component First + k everywhere.
template <int First, class V, int... I>
V spread_nodes(V v, std::integer_sequence<int, I...>) {
    return __builtin_shufflevector(v, v, (I / 4 * 4 + First + I / 4)...);
}

/// Quads A and B of a, then quads A and B of b.
template <int A, int B, class V, int... I>
V pick_quads(V a, V b, std::integer_sequence<int, I...>) {
    constexpr int N = sizeof...(I);
    return __builtin_shufflevector(a, b, (I / (N / 2) * N + (I / 4 % (N / 4) % 2 == 0 ? A : B) * 4 + I % 4)...);
}

}  // namespace detail

/// Four z-nodes of a tile's column, a quad (momentum or velocity, mass) each: sixteen numbers in registers.
template <class Real>
struct Column {
    using P = Pack<Real>;
    static constexpr int kLanes = perimpm::kLanes<Real>, kParts = 16 / kLanes;
    static_assert(kParts * kLanes == 16);
    P part[kParts];

    static Column load(const Real* from) {
        Column c;
        for (int k = 0; k < kParts; ++k) c.part[k].copy_from(from + k * kLanes, std::experimental::element_aligned);
        return c;
    }
    void store(Real* to) const {
        for (int k = 0; k < kParts; ++k) part[k].copy_to(to + k * kLanes, std::experimental::element_aligned);
    }
    /// (a b c d) at each of the four nodes.
    static Column repeat(const Real quad[4]) {
        Column c;
        if constexpr (kLanes >= 4) {
            c.part[0] = detail::as_pack<Real>(detail::repeat_quad<Real, kLanes>(quad));
            for (int k = 1; k < kParts; ++k) c.part[k] = c.part[0];
        } else {
            for (int k = 0; k < kParts; ++k)
                c.part[k].copy_from(quad + k * kLanes % 4, std::experimental::element_aligned);
        }
        return c;
    }
    /// a, b, c, d for all numbers of node 0, 1, 2, 3.
    static Column spread(const Real quad[4]) {
        Column c;
        if constexpr (kLanes > 4) {
            using V = detail::Vec<Real, kLanes>;
            const V v = detail::repeat_quad<Real, kLanes>(quad);
            [&]<int... K>(std::integer_sequence<int, K...>) {
                ((c.part[K] = detail::as_pack<Real>(
                      detail::spread_nodes<K * kLanes / 4>(v, std::make_integer_sequence<int, kLanes>()))),
                 ...);
            }
            (std::make_integer_sequence<int, kParts>());
        } else {
            for (int k = 0; k < kParts; ++k) c.part[k] = P(quad[k * kLanes / 4]);
        }
        return c;
    }
    /// 0, 1, 2, 3: the node's index.
    static Column index() {
        constexpr Real k[4] = {0, 1, 2, 3};
        return spread(k);
    }

    Column& operator+=(const Column& b) {
        for (int k = 0; k < kParts; ++k) part[k] += b.part[k];
        return *this;
    }
    friend Column operator+(Column a, const Column& b) { return a += b; }
    friend Column operator*(const Column& a, const Column& b) {
        Column c;
        for (int k = 0; k < kParts; ++k) c.part[k] = a.part[k] * b.part[k];
        return c;
    }
    friend Column operator*(Real a, const Column& b) {
        Column c;
        for (int k = 0; k < kParts; ++k) c.part[k] = P(a) * b.part[k];
        return c;
    }
};

/// Sum of a column over its nodes.
template <class Real>
void store_node_sum(const Column<Real>& column, Real* to) {
    using C = Column<Real>;
    constexpr int N = C::kLanes;
    if constexpr (N >= 8) {
        using V = detail::Vec<Real, N>;
        const V a = N == 16 ? detail::as_vector<Real>(column.part[0])
                            : detail::as_vector<Real>(column.part[0] + column.part[C::kParts - 1]);
        auto sum = __builtin_shufflevector(a, a, 0, 1, 2, 3) + __builtin_shufflevector(a, a, 4, 5, 6, 7);
        if constexpr (N == 16)
            sum += __builtin_shufflevector(a, a, 8, 9, 10, 11) + __builtin_shufflevector(a, a, 12, 13, 14, 15);
        __builtin_memcpy(to, &sum, sizeof sum);
    } else {
        constexpr int kPerQuad = 4 / N;  // parts of one node
        for (int q = 0; q < kPerQuad; ++q) {
            typename C::P sum = column.part[q];
            for (int node = 1; node < 4; ++node) sum += column.part[node * kPerQuad + q];
            sum.copy_to(to + q * N, std::experimental::element_aligned);
        }
    }
}

/// The same for four columns at once.
template <class Real>
void store_node_sums(const Column<Real> (&column)[4], Real* const (&to)[4]) {
    constexpr int N = Column<Real>::kLanes;
    if constexpr (N == 16) {
        using V = detail::Vec<Real, 16>;
        constexpr auto all = std::make_integer_sequence<int, 16>();
        V half[2];
        for (int k = 0; k < 2; ++k) {
            const V a = detail::as_vector<Real>(column[2 * k].part[0]),
                    b = detail::as_vector<Real>(column[2 * k + 1].part[0]);
            half[k] = detail::pick_quads<0, 1>(a, b, all) + detail::pick_quads<2, 3>(a, b, all);
        }
        const V sum = detail::pick_quads<0, 2>(half[0], half[1], all) + detail::pick_quads<1, 3>(half[0], half[1], all);
        for (int k = 0; k < 4; ++k)
            __builtin_memcpy(to[k], reinterpret_cast<const char*>(&sum) + k * sizeof(V) / 4, sizeof(V) / 4);
    } else {
        for (int k = 0; k < 4; ++k) store_node_sum(column[k], to[k]);
    }
}

}  // namespace perimpm::bspline
