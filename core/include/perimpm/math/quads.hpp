#pragma once

#include <utility>

#include "perimpm/math/simd.hpp"

/*! Quads: four numbers side by side, such as (x, y, z, -) of one particle. A pack of quads and four packs of components
    turn into each other by 4x4 transposes inside registers. Sums over packs or records of quads need no transposes. */
namespace perimpm {

inline constexpr std::size_t kMatrixRecord = 16;  ///< a 3x3 matrix and a vector as quads: the columns, then x

namespace detail {

template <class Real, int N>
struct Lanes {
    typedef Real type __attribute__((vector_size(N * sizeof(Real))));
};
template <class Real, int N>
using Vec = typename Lanes<Real, N>::type;

template <class Real>
PERIMPM_INLINE Vec<Real, kLanes<Real>> as_vector(const Pack<Real>& pack) {
    return __builtin_bit_cast(Vec<Real, kLanes<Real>>, pack);
}
template <class Real>
PERIMPM_INLINE Pack<Real> as_pack(const Vec<Real, kLanes<Real>>& vector) {
    return __builtin_bit_cast(Pack<Real>, vector);
}

/// From each quad of lanes of a and b: lanes First and First + 1 of both, alternating (`Interleave`) or one after the other.
template <int First, bool Interleave, class V, int... I>
PERIMPM_INLINE V mix(V a, V b, std::integer_sequence<int, I...>) {
    constexpr int N = sizeof...(I);
    return __builtin_shufflevector(
        a, b, (I / 4 * 4 + First + (Interleave ? I % 4 / 2 + I % 2 * N : I % 2 + I % 4 / 2 * N))...);
}

template <class Real, int N, int... I>
PERIMPM_INLINE Vec<Real, 2 * N> join(Vec<Real, N> a, Vec<Real, N> b, std::integer_sequence<int, I...>) {
    return __builtin_shufflevector(a, b, I...);
}

template <class Real>
PERIMPM_INLINE Vec<Real, 4> load_quad(const Real* quad) {
    Vec<Real, 4> v;
    __builtin_memcpy(&v, quad, sizeof v);
    return v;
}

/// First quads of the entries k, k + 4, k + 8, ..., side by side. Width: numbers from one entry to the next.
template <class Real, int N, std::size_t Width>
PERIMPM_INLINE Vec<Real, N> every_fourth(const Real* quads, const std::uint32_t* entry) {
    if constexpr (N == 4) {
        return load_quad(quads + Width * std::size_t{entry[0]});
    } else {
        return join<Real, N / 2>(every_fourth<Real, N / 2, Width>(quads, entry),
                                 every_fourth<Real, N / 2, Width>(quads, entry + N / 2),
                                 std::make_integer_sequence<int, N>());
    }
}

/// The same quad N/4 times.
template <class Real, int N>
PERIMPM_INLINE Vec<Real, N> repeat_quad(const Real quad[4]) {
    if constexpr (N == 4) {
        return load_quad(quad);
    } else {
        const Vec<Real, N / 2> half = repeat_quad<Real, N / 2>(quad);
        return join<Real, N / 2>(half, half, std::make_integer_sequence<int, N>());
    }
}

/// Lanes First to First + N - 1.
template <int First, int N, class V, int... I>
PERIMPM_INLINE auto lanes_from(V v, std::integer_sequence<int, I...>) {
    return __builtin_shufflevector(v, v, (First + I)...);
}
/// Sum of a vector's quads.
template <class Real, int N>
PERIMPM_INLINE Vec<Real, 4> sum_of_quads(Vec<Real, N> v) {
    if constexpr (N == 4) {
        return v;
    } else {
        constexpr auto half = std::make_integer_sequence<int, N / 2>();
        return sum_of_quads<Real, N / 2>(lanes_from<0, N / 2>(v, half) + lanes_from<N / 2, N / 2>(v, half));
    }
}

/// Three quads side by side in as few registers as hold them: what follows the third is not looked at.
template <class Real>
struct ThreeQuads {
    static constexpr int kWidth = kLanes<Real> < 4 ? 4 : kLanes<Real>, kParts = (12 + kWidth - 1) / kWidth;
    Vec<Real, kWidth> part[kParts];
};
template <int First, class V, int... I>
PERIMPM_INLINE V lanes_over_quads(V v, std::integer_sequence<int, I...>) {
    return __builtin_shufflevector(v, v, (First + I / 4)...);
}
template <class Real>
PERIMPM_INLINE ThreeQuads<Real> load_columns(const Real* record) {
    ThreeQuads<Real> columns;
    for (int k = 0; k < columns.kParts; ++k)
        __builtin_memcpy(&columns.part[k], record + k * columns.kWidth, sizeof columns.part[k]);
    return columns;
}
/// x[c] over the whole of quad c, where x is the record's fourth quad.
template <class Real>
PERIMPM_INLINE ThreeQuads<Real> spread_vector(const Real* record) {
    constexpr int N = ThreeQuads<Real>::kWidth;
    constexpr auto all = std::make_integer_sequence<int, N>();
    Vec<Real, N> last;  // of the record's registers
    __builtin_memcpy(&last, record + kMatrixRecord - N, sizeof last);
    if constexpr (N == 16) return {{lanes_over_quads<12>(last, all)}};
    if constexpr (N == 8) return {{lanes_over_quads<4>(last, all), lanes_over_quads<6>(last, all)}};
    if constexpr (N == 4)
        return {{lanes_over_quads<0>(last, all), lanes_over_quads<1>(last, all), lanes_over_quads<2>(last, all)}};
}

}  // namespace detail

/// Within each group of four lanes: row k of `rows` becomes lane k of the columns. Its own inverse.
template <class Real>
PERIMPM_INLINE void transpose_quads(const Pack<Real> rows[4], Pack<Real> columns[4]) {
    constexpr int N = kLanes<Real>;
    static_assert(N >= 4);
    using V = detail::Vec<Real, N>;
    constexpr auto all = std::make_integer_sequence<int, N>();
    const V r[4] = {detail::as_vector<Real>(rows[0]), detail::as_vector<Real>(rows[1]),
                    detail::as_vector<Real>(rows[2]), detail::as_vector<Real>(rows[3])};
    const V xy01 = detail::mix<0, true>(r[0], r[1], all), xy23 = detail::mix<0, true>(r[2], r[3], all);
    const V zw01 = detail::mix<2, true>(r[0], r[1], all), zw23 = detail::mix<2, true>(r[2], r[3], all);
    columns[0] = detail::as_pack<Real>(detail::mix<0, false>(xy01, xy23, all));
    columns[1] = detail::as_pack<Real>(detail::mix<2, false>(xy01, xy23, all));
    columns[2] = detail::as_pack<Real>(detail::mix<0, false>(zw01, zw23, all));
    columns[3] = detail::as_pack<Real>(detail::mix<2, false>(zw01, zw23, all));
}

/// Place of lane `lane`'s quad among the quads that store_quads writes.
template <class Real>
constexpr std::size_t quad_place(std::size_t lane) {
    constexpr std::size_t N = kLanes<Real>;
    return N < 4 ? lane : lane % 4 * (N / 4) + lane / 4;
}

/// Writes one quad per lane, lane l's to place quad_place(l); `to` holds 4 packs.
template <class Real>
PERIMPM_INLINE void store_quads(Real* to, const Pack<Real> component[4]) {
    constexpr std::size_t N = kLanes<Real>;
    if constexpr (N < 4) {
        for (std::size_t lane = 0; lane < N; ++lane)
            for (std::size_t c = 0; c < 4; ++c) to[4 * lane + c] = component[c][lane];
    } else {
        Pack<Real> rows[4];
        transpose_quads<Real>(component, rows);
        for (std::size_t k = 0; k < 4; ++k) rows[k].copy_to(to + k * N, std::experimental::element_aligned);
    }
}

/// Reads quads that lie at the places of store_quads.
template <class Real>
PERIMPM_INLINE void load_quads(const Real* from, Pack<Real> component[4]) {
    constexpr std::size_t N = kLanes<Real>;
    if constexpr (N < 4) {
        for (std::size_t c = 0; c < 4; ++c)
            component[c] = Pack<Real>([&](std::size_t lane) { return from[4 * lane + c]; });
    } else {
        Pack<Real> rows[4];
        for (std::size_t k = 0; k < 4; ++k) rows[k].copy_from(from + k * N, std::experimental::element_aligned);
        transpose_quads<Real>(rows, component);
    }
}

/// Components of the first quads of the entries entry[lane]: whole quads are loaded, which takes a third of the
/// instructions of loading number by number.
template <std::size_t Width = 4, class Real>
PERIMPM_INLINE void gather_quads(const Real* quads, const std::uint32_t* entry, Pack<Real> component[4]) {
    constexpr int N = kLanes<Real>;
    if constexpr (N < 4) {
        for (std::size_t c = 0; c < 4; ++c)
            component[c] = Pack<Real>([&](std::size_t lane) { return quads[Width * std::size_t{entry[lane]} + c]; });
    } else {
        Pack<Real> rows[4];
        for (int k = 0; k < 4; ++k)
            rows[k] = detail::as_pack<Real>(detail::every_fourth<Real, N, Width>(quads, entry + k));
        transpose_quads<Real>(rows, component);
    }
}

/// Sums over all lanes of four packs, in half the instructions of one after the other.
template <class Real>
PERIMPM_INLINE void reduce_four(const Pack<Real> packs[4], Real sums[4]) {
    constexpr int N = kLanes<Real>;
    if constexpr (N < 4) {
        for (int k = 0; k < 4; ++k) sums[k] = reduce(packs[k]);
    } else {
        Pack<Real> c[4];
        transpose_quads<Real>(packs, c);
        const auto sum = detail::sum_of_quads<Real, N>(detail::as_vector<Real>((c[0] + c[1]) + (c[2] + c[3])));
        __builtin_memcpy(sums, &sum, sizeof sum);
    }
}

/// sum over k < count of weight(k) M (x - x_own), where `records` has M and x at entry[k] and x_own is that of the record
/// `own`. Apart from the difference a product costs a load, a shuffle and a multiply-add per register.
template <class Real, class Weight>
PERIMPM_INLINE void sum_products(const Real* records, const std::uint32_t* entry, std::uint32_t count, const Real* own,
                                 Weight weight, Real sum[3]) {
    using Quads = detail::ThreeQuads<Real>;
    constexpr int kParts = Quads::kParts;
    constexpr std::uint32_t kChains = kParts == 1 ? 4 : 2;  // independent sums, or each would wait for the last
    const Quads from = detail::spread_vector(own);
    Quads chain[kChains] = {};
    const auto add = [&](std::uint32_t k, Quads& to) PERIMPM_INLINE_LAMBDA {
        const Real* record = records + kMatrixRecord * std::size_t{entry[k]};
        const Quads columns = detail::load_columns(record), x = detail::spread_vector(record);
        for (int part = 0; part < kParts; ++part)
            to.part[part] += columns.part[part] * ((x.part[part] - from.part[part]) * weight(k));
    };
    std::uint32_t k = 0;
    for (; k + kChains <= count; k += kChains)
        for (std::uint32_t c = 0; c < kChains; ++c) add(k + c, chain[c]);
    for (; k < count; ++k) add(k, chain[0]);
    Real quads[kParts * Quads::kWidth];
    for (int part = 0; part < kParts; ++part) {
        for (std::uint32_t c = 1; c < kChains; ++c) chain[0].part[part] += chain[c].part[part];
        __builtin_memcpy(quads + part * Quads::kWidth, &chain[0].part[part], sizeof chain[0].part[part]);
    }
    for (int r = 0; r < 3; ++r) sum[r] = quads[r] + quads[4 + r] + quads[8 + r];
}

}  // namespace perimpm
