#pragma once

#include <iterator>
#include <utility>

#include "perimpm/math/simd.hpp"

/*! Quads: four numbers side by side, such as (x, y, z, -) of one particle. A pack of quads and four packs of components
    turn into each other by 4x4 transposes inside registers. Sums over packs or records of quads need no transposes. */
namespace perimpm {

inline constexpr std::size_t kSumRecord = 16;  ///< numbers from one record of sum_records to the next

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

/// The same quad N/4 times: one instruction that loads, where GCC would load once and shuffle twice.
template <class Real, int N>
PERIMPM_INLINE Vec<Real, N> repeat_quad(const Real quad[4]) {
    if constexpr (N == 4) {
        return load_quad(quad);
#ifdef __AVX512F__
    } else if constexpr (N == 16) {
        return __builtin_bit_cast(Vec<Real, N>, _mm512_broadcast_f32x4(_mm_loadu_ps(quad)));
    } else if constexpr (N == 8 && sizeof(Real) == 8) {
        return __builtin_bit_cast(Vec<Real, N>, _mm512_broadcast_f64x4(_mm256_loadu_pd(quad)));
#endif
#ifdef __AVX__
    } else if constexpr (N == 8 && sizeof(Real) == 4) {
        return __builtin_bit_cast(Vec<Real, N>, _mm256_broadcast_ps(reinterpret_cast<const __m128*>(quad)));
#endif
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

/// Writes one quad per lane, Width numbers from one to the next.
template <std::size_t Width, class Real>
PERIMPM_INLINE void store_quads_apart(Real* to, const Pack<Real> component[4]) {
    Real quads[4 * kLanes<Real>];
    store_quads(quads, component);
    for (std::size_t lane = 0; lane < kLanes<Real>; ++lane)
        __builtin_memcpy(to + Width * lane, quads + 4 * quad_place<Real>(lane), 4 * sizeof(Real));
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

/// Reads one quad per lane, Width numbers from one to the next.
template <std::size_t Width = 4, class Real>
PERIMPM_INLINE void load_quads_apart(const Real* from, Pack<Real> component[4]) {
    static constexpr std::uint32_t kInOrder[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    static_assert(kLanes<Real> <= std::size(kInOrder));
    gather_quads<Width>(from, kInOrder, component);
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

/// sum over k < count of weight(k) times the record at entry[k]: kSumRecord numbers, of which the first 12 are summed. A
/// record costs a load and a multiply-add per register.
template <class Real, class Weight>
PERIMPM_INLINE void sum_records(const Real* records, const std::uint32_t* entry, std::uint32_t count, Weight weight,
                                Real sum[kSumRecord]) {
    constexpr int N = kLanes<Real>, kParts = (12 + N - 1) / N;
    constexpr std::uint32_t kChains = kParts < 4 ? 4 : 2;  // independent sums, or each would wait for the last
    using V = detail::Vec<Real, N>;
    V chain[kChains][kParts] = {};
    const auto add = [&](std::uint32_t k, V to[kParts]) PERIMPM_INLINE_LAMBDA {
        const Real* record = records + kSumRecord * std::size_t{entry[k]};
        const Real w = weight(k);
        for (int part = 0; part < kParts; ++part) {
            V numbers;
            __builtin_memcpy(&numbers, record + part * N, sizeof numbers);
            to[part] += numbers * w;
        }
    };
    std::uint32_t k = 0;
    for (; k + kChains <= count; k += kChains)
        for (std::uint32_t c = 0; c < kChains; ++c) add(k + c, chain[c]);
    for (; k < count; ++k) add(k, chain[0]);
    for (int part = 0; part < kParts; ++part) {
        for (std::uint32_t c = 1; c < kChains; ++c) chain[0][part] += chain[c][part];
        __builtin_memcpy(sum + part * N, &chain[0][part], sizeof chain[0][part]);
    }
}

}  // namespace perimpm
