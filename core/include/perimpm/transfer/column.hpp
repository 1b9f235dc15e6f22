#pragma once

#include "perimpm/math/quads.hpp"
#include "perimpm/model/transfer_kernel.hpp"

namespace perimpm::bspline {

namespace detail {

using perimpm::detail::as_pack, perimpm::detail::repeat_quad, perimpm::detail::Vec;

/// From repeated quads: in the k-th group of four lanes, component First + k everywhere.
template <int First, class V, int... I>
V spread_nodes(V v, std::integer_sequence<int, I...>) {
    return __builtin_shufflevector(v, v, (I / 4 * 4 + First + I / 4)...);
}

}  // namespace detail

/// Quads of kCount particles side by side in one register.
template <class Real, std::size_t kCount>
struct Few {
    static constexpr int kLanes = 4 * static_cast<int>(kCount);
    using Pack = std::experimental::simd<Real, std::experimental::simd_abi::deduce_t<Real, kLanes>>;

    /// One quad for all.
    PERIMPM_INLINE static Pack repeat(const Real quad[4]) {
        return __builtin_bit_cast(Pack, detail::repeat_quad<Real, kLanes>(quad));
    }
    /// A number of each particle for its whole quad; of more than one particle four numbers are read.
    PERIMPM_INLINE static Pack spread(const Real* numbers) {
        if constexpr (kCount == 1)
            return Pack(*numbers);
        else
            return __builtin_bit_cast(Pack, detail::spread_nodes<0>(detail::repeat_quad<Real, kLanes>(numbers),
                                                                    std::make_integer_sequence<int, kLanes>()));
    }
    /// The quads' first, second and third numbers.
    PERIMPM_INLINE static void store(const Pack& quads, Real* x, Real* y, Real* z) {
        constexpr int count = kCount;
        const auto v = __builtin_bit_cast(detail::Vec<Real, kLanes>, quads);
        const auto columns = [&]<int... I>(std::integer_sequence<int, I...>) PERIMPM_INLINE_LAMBDA {
            return __builtin_shufflevector(v, v, (I % count * 4 + I / count)...);
        }
        (std::make_integer_sequence<int, kLanes>());
        const auto put = [&]<int first, int... I>(Real * to, std::integer_sequence<int, first>,
                                                  std::integer_sequence<int, I...>) PERIMPM_INLINE_LAMBDA {
            const detail::Vec<Real, kCount> part = {columns[first + I]...};
            __builtin_memcpy(to, &part, sizeof part);
        };
        constexpr auto all = std::make_integer_sequence<int, count>();
        put(x, std::integer_sequence<int, 0>(), all);
        put(y, std::integer_sequence<int, count>(), all);
        put(z, std::integer_sequence<int, 2 * count>(), all);
    }
};

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

    /// Itself, but kept from merging with a later sum into a multiply-add.
    friend Column rounded(Column a) {
        for (int k = 0; k < kParts; ++k) a.part[k] = perimpm::rounded(a.part[k]);
        return a;
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

}  // namespace perimpm::bspline
