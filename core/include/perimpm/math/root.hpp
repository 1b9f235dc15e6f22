#pragma once

#include "perimpm/math/simd.hpp"

/*! Square roots and reciprocals for loops that would wait for the divider: a 512-bit root and a division keep it busy for
    longer than all else that a bond needs. There they come from the processor's estimate of 14 bits and Newton's steps;
    narrower estimates are too coarse to gain anything. */
namespace perimpm {

/// A root of a finite number, correctly rounded, and its reciprocal, 0 for 0.
template <class T>
struct Root {
    T root, inverse;
};

#ifdef __AVX512F__
namespace detail {

PERIMPM_INLINE __m512 inverse_root_estimate(__m512 x) {
    return _mm512_maskz_rsqrt14_ps(_mm512_cmp_ps_mask(x, _mm512_setzero_ps(), _CMP_NEQ_UQ), x);
}
PERIMPM_INLINE __m512d inverse_root_estimate(__m512d x) {
    return _mm512_maskz_rsqrt14_pd(_mm512_cmp_pd_mask(x, _mm512_setzero_pd(), _CMP_NEQ_UQ), x);
}
PERIMPM_INLINE __m512 inverse_estimate(__m512 x) { return _mm512_rcp14_ps(x); }
PERIMPM_INLINE __m512d inverse_estimate(__m512d x) { return _mm512_rcp14_pd(x); }
/// a b + c and c - a b, rounded once.
PERIMPM_INLINE __m512 plus_product(__m512 c, __m512 a, __m512 b) { return _mm512_fmadd_ps(a, b, c); }
PERIMPM_INLINE __m512d plus_product(__m512d c, __m512d a, __m512d b) { return _mm512_fmadd_pd(a, b, c); }
PERIMPM_INLINE __m512 minus_product(__m512 c, __m512 a, __m512 b) { return _mm512_fnmadd_ps(a, b, c); }
PERIMPM_INLINE __m512d minus_product(__m512d c, __m512d a, __m512d b) { return _mm512_fnmadd_pd(a, b, c); }

/// (1/sqrt(1 - e) - 1)/e, to the precision's last digits for the |e| < 2^-13 that an estimate leaves over.
PERIMPM_INLINE __m512 root_series(__m512 e) { return plus_product(_mm512_set1_ps(0.5f), _mm512_set1_ps(0.375f), e); }
PERIMPM_INLINE __m512d root_series(__m512d e) {
    return plus_product(_mm512_set1_pd(0.5), plus_product(_mm512_set1_pd(0.375), _mm512_set1_pd(0.3125), e), e);
}

template <class Real>
struct Register {
    using type = __m512;
};
template <>
struct Register<double> {
    using type = __m512d;
};

}  // namespace detail
#endif

/// 1/x for finite x other than 0, with an error of at most two units in the last place.
template <class T>
PERIMPM_INLINE T inverse_of(const T& x) {
#ifdef __AVX512F__
    if constexpr (sizeof(T) == sizeof(__m512)) {
        using V = typename detail::Register<Scalar<T>>::type;
        const auto divisor = __builtin_bit_cast(V, x), one = __builtin_bit_cast(V, T(Scalar<T>(1)));
        V inverse = detail::inverse_estimate(divisor);
        for (std::size_t digits = 14; digits < 8 * sizeof(Scalar<T>) * 3 / 4; digits *= 2)
            inverse = detail::plus_product(inverse, inverse, detail::minus_product(one, divisor, inverse));
        return __builtin_bit_cast(T, inverse);
    } else
#endif
        return T(1) / x;
}

/// 1/x, 0 for 0 (a bond shrunk to a point has no direction and no force).
template <class T>
PERIMPM_INLINE T inverse_length(const T& length) {
    return select(length > T(0), inverse_of(select(length > T(0), length, T(1))), T(0));
}

template <class T>
PERIMPM_INLINE Root<T> root_of(const T& square) {
    using std::sqrt;
#ifdef __AVX512F__
    if constexpr (sizeof(T) == sizeof(__m512)) {
        using Real = Scalar<T>;
        using V = typename detail::Register<Real>::type;
        const auto x = __builtin_bit_cast(V, square);
        const auto one = __builtin_bit_cast(V, T(Real(1))), half = __builtin_bit_cast(V, T(Real(0.5)));
        const V r = detail::inverse_root_estimate(x), e = detail::minus_product(one, V(x * r), r);
        V series = half;
        if constexpr (sizeof(Real) == sizeof(double)) series = detail::root_series(e);
        const V inverse = detail::plus_product(r, V(r * e), series);
        // the residual is exact: adding its share gives the nearest number (Markstein 1990, doi:10.1147/rd.341.0111)
        const V near = x * inverse;
        const V root = detail::plus_product(near, V(half * inverse), detail::minus_product(x, near, near));
        return {__builtin_bit_cast(T, root), __builtin_bit_cast(T, inverse)};
    } else
#endif
    {
        const T root = sqrt(square);
        return {root, inverse_length(root)};
    }
}

/// 1 - 1/sqrt(1 + u), the share of its present length that something of relative square 1 + u is longer; 0 for u <= -1.
/// Costs no digits that rounding of 1 + u would cost.
template <class T>
PERIMPM_INLINE T shortening_of(const T& u) {
#ifdef __AVX512F__
    if constexpr (sizeof(T) == sizeof(__m512)) {
        using V = typename detail::Register<Scalar<T>>::type;
        const auto x = __builtin_bit_cast(V, u), one = __builtin_bit_cast(V, T(Scalar<T>(1)));
        // e = 1 - (1 + u) r^2 is small: taken as (1 - r^2) - u r^2 it keeps its digits
        const V r = detail::inverse_root_estimate(V(one + x));
        const V e = detail::minus_product(detail::minus_product(one, r, r), V(x * r), r);
        const V shortening = detail::minus_product(V(one - r), V(r * e), detail::root_series(e));
        return select(u <= T(-1), T(0), __builtin_bit_cast(T, shortening));
    } else
#endif
    {
        const T square = larger(T(T(1) + u), T(0));
        return u * inverse_length(T(square + root_of(square).root));
    }
}

}  // namespace perimpm
