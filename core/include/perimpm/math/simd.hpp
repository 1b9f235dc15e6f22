#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <experimental/simd>
#include <type_traits>
#include <utility>

#ifdef __AVX__
#include <immintrin.h>
#endif

/// For the small functions of inner loops: a call there costs more than the function, and compilers do not always see it.
#define PERIMPM_INLINE [[gnu::always_inline]] inline
#define PERIMPM_INLINE_LAMBDA __attribute__((always_inline))

namespace perimpm {

/// As many numbers as the target's widest register holds; algorithms are templates over T = Real or Pack<Real>.
template <class Real>
using Pack = std::experimental::native_simd<Real>;
template <class Real>
inline constexpr std::size_t kLanes = Pack<Real>::size();

/// How many packs registers hold.
#if defined(__AVX512F__) || defined(__aarch64__)
inline constexpr int kRegisters = 32;
#else
inline constexpr int kRegisters = 16;
#endif

template <class Real>
PERIMPM_INLINE Real select(bool mask, Real yes, Real no) {
    return mask ? yes : no;
}
template <class Real, class Abi>
PERIMPM_INLINE std::experimental::simd<Real, Abi> select(const std::experimental::simd_mask<Real, Abi>& mask,
                                                         const std::experimental::simd<Real, Abi>& yes,
                                                         std::experimental::simd<Real, Abi> no) {
    where(mask, no) = yes;
    return no;
}

/// The larger one, a where either is no number.
template <class T>
PERIMPM_INLINE T larger(const T& a, const T& b) {
#ifdef __AVX512F__
    if constexpr (std::is_same_v<T, Pack<float>>)
        return __builtin_bit_cast(T, _mm512_max_ps(__builtin_bit_cast(__m512, b), __builtin_bit_cast(__m512, a)));
    else if constexpr (std::is_same_v<T, Pack<double>>)
        return __builtin_bit_cast(T, _mm512_max_pd(__builtin_bit_cast(__m512d, b), __builtin_bit_cast(__m512d, a)));
    else
#endif
        return select(a < b, b, a);
}

inline bool all(bool mask) { return mask; }
template <class Real, class Abi>
PERIMPM_INLINE bool all(const std::experimental::simd_mask<Real, Abi>& mask) {
    return all_of(mask);
}

/// A product that is rounded before it is added. In a b + c d compilers merge either product with the sum, and not always
/// the same one.
template <class Real, class Abi>
PERIMPM_INLINE std::experimental::simd<Real, Abi> rounded(const std::experimental::simd<Real, Abi>& product) {
    typedef Real Lanes __attribute__((vector_size(sizeof product)));
    auto lanes = __builtin_bit_cast(Lanes, product);
#if defined(__x86_64__)
    asm("" : "+v"(lanes));
#elif defined(__aarch64__)
    asm("" : "+w"(lanes));
#else
    asm("" : "+m"(lanes));
#endif
    return __builtin_bit_cast(std::experimental::simd<Real, Abi>, lanes);
}

/// The first `count` lanes.
template <class Real>
PERIMPM_INLINE typename Pack<Real>::mask_type first_lanes(std::size_t count) {
    const Pack<Real> lane([](auto i) { return static_cast<Real>(i); });
    return lane < static_cast<Real>(count);
}

/// 1 in the lanes whose bits are set, the first lane's lowest, else 0.
template <class Real>
PERIMPM_INLINE Pack<Real> ones_at(std::uint32_t bits) {
    using Bits = std::conditional_t<sizeof(Real) == sizeof(std::uint32_t), std::uint32_t, std::uint64_t>;
    typedef Bits Lanes __attribute__((vector_size(sizeof(Pack<Real>))));
    Lanes bit;
    for (std::size_t lane = 0; lane < kLanes<Real>; ++lane) bit[lane] = Bits(1) << lane;
    const auto one = __builtin_bit_cast(Lanes, Pack<Real>(1));
    const Lanes set = (Lanes{} + Bits(bits)) & bit;
    return __builtin_bit_cast(Pack<Real>, (Lanes)(set == bit) & one);
}

/// Loads `count` (at most a pack) consecutive numbers; missing lanes hold `rest` and their memory is not touched.
template <class Real>
PERIMPM_INLINE Pack<Real> load(const Real* from, std::size_t count, Real rest = Real(0)) {
    if (count >= kLanes<Real>) return Pack<Real>(from, std::experimental::element_aligned);
    Pack<Real> pack(rest);
    where(first_lanes<Real>(count), pack).copy_from(from, std::experimental::element_aligned);
    return pack;
}

/// Loads lanes `begin` to `end` - 1 of consecutive numbers; the others hold 0 and their memory is not touched.
template <class Real>
PERIMPM_INLINE Pack<Real> load_between(const Real* from, std::ptrdiff_t begin, std::ptrdiff_t end) {
    constexpr std::ptrdiff_t kEnd = kLanes<Real>;
    begin = begin < 0 ? 0 : begin > kEnd ? kEnd : begin;
    end = end < begin ? begin : end > kEnd ? kEnd : end;
#ifdef __AVX512F__
    const auto lanes = (1u << end) - (1u << begin);
    if constexpr (std::is_same_v<Real, float>)
        return __builtin_bit_cast(Pack<Real>, _mm512_maskz_loadu_ps(static_cast<__mmask16>(lanes), from));
    else
        return __builtin_bit_cast(Pack<Real>, _mm512_maskz_loadu_pd(static_cast<__mmask8>(lanes), from));
#else
    const Pack<Real> lane([](auto i) { return static_cast<Real>(i); });
    Pack<Real> pack(0);
    where(lane >= static_cast<Real>(begin) && lane < static_cast<Real>(end), pack)
        .copy_from(from, std::experimental::element_aligned);
    return pack;
#endif
}

/// Stores the first `count` lanes; memory of the others is not touched.
template <class Real>
PERIMPM_INLINE void store(Real* to, const Pack<Real>& pack, std::size_t count) {
    if (count >= kLanes<Real>) return pack.copy_to(to, std::experimental::element_aligned);
#if defined(__SSE2__) && !defined(__AVX__)
    // The masked store of SSE2 goes past the caches, and faults on pages that only masked lanes lie in.
    for (std::size_t lane = 0; lane < count; ++lane) to[lane] = pack[lane];
#else
    where(first_lanes<Real>(count), pack).copy_to(to, std::experimental::element_aligned);
#endif
}

/// Calls body(0) to body(kCount - 1), each number a constant: what it indexes can stay in registers.
template <int kCount, class Body>
PERIMPM_INLINE void unrolled(Body body) {
    [&]<int... kIndex>(std::integer_sequence<int, kIndex...>) PERIMPM_INLINE_LAMBDA {
        (body(std::integral_constant<int, kIndex>()), ...);
    }
    (std::make_integer_sequence<int, kCount>());
}

/// Scalar type below a pack.
template <class T>
struct ScalarOf {
    using type = T;
};
template <class Real, class Abi>
struct ScalarOf<std::experimental::simd<Real, Abi>> {
    using type = Real;
};
template <class T>
using Scalar = typename ScalarOf<T>::type;

}  // namespace perimpm
