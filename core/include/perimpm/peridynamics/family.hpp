#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "perimpm/math/simd.hpp"
#include "perimpm/model/block.hpp"

/*! What bond laws share: walking through families in packs of bonds, influence functions, sums over the full lattice.
 */
namespace perimpm::peridynamics {

template <class T>
T norm(const T v[3]) {
    using std::sqrt;
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

namespace detail {

template <class Real, int N>
struct Lanes {
    typedef Real type __attribute__((vector_size(N * sizeof(Real))));
};
template <class Real, int N>
using Vec = typename Lanes<Real, N>::type;

template <class Real, int N, int... I>
Vec<Real, 2 * N> join(Vec<Real, N> a, Vec<Real, N> b, std::integer_sequence<int, I...>) {
    return __builtin_shufflevector(a, b, I...);
}
/// From each quad of lanes of a and b, chosen lanes: First of a, First of b, Second of a, Second of b for `Pairs`, or
/// (First, First + 1) of a, then of b.
template <class Real, int N, int First, bool Pairs, int... I>
Vec<Real, N> mix(Vec<Real, N> a, Vec<Real, N> b, std::integer_sequence<int, I...>) {
    return __builtin_shufflevector(a, b,
                                   (I / 4 * 4 + First + (Pairs ? I % 4 / 2 + I % 2 * N : I % 2 + I % 4 / 2 * N))...);
}

/// Entries k, k + 4, k + 8, ... of an array packed by four, side by side.
template <class Real, int N>
Vec<Real, N> every_fourth(const Real* packed, const std::uint32_t* entry) {
    if constexpr (N == 4) {
        Vec<Real, 4> v;
        __builtin_memcpy(&v, packed + 4 * std::size_t{entry[0]}, sizeof v);
        return v;
    } else {
        return join<Real, N / 2>(every_fourth<Real, N / 2>(packed, entry),
                                 every_fourth<Real, N / 2>(packed, entry + N / 2),
                                 std::make_integer_sequence<int, N>());
    }
}

/// Components x, y, z of a pack of entries of an array packed by four: whole entries are loaded and transposed in
/// registers, which takes a third of the instructions of loading number by number.
template <class Real>
void gather3(const Real* packed, const std::uint32_t* entry, Pack<Real> out[3]) {
    constexpr int N = kLanes<Real>;
    if constexpr (N < 4) {
        for (int c = 0; c < 3; ++c)
            out[c] = Pack<Real>([&](std::size_t lane) { return packed[4 * std::size_t{entry[lane]} + c]; });
    } else {
        constexpr auto all = std::make_integer_sequence<int, N>();
        Vec<Real, N> r[4];
        for (int k = 0; k < 4; ++k) r[k] = every_fourth<Real, N>(packed, entry + k);
        const auto xy01 = mix<Real, N, 0, true>(r[0], r[1], all), xy23 = mix<Real, N, 0, true>(r[2], r[3], all);
        const auto z01 = mix<Real, N, 2, true>(r[0], r[1], all), z23 = mix<Real, N, 2, true>(r[2], r[3], all);
        out[0] = Pack<Real>(mix<Real, N, 0, false>(xy01, xy23, all));
        out[1] = Pack<Real>(mix<Real, N, 2, false>(xy01, xy23, all));
        out[2] = Pack<Real>(mix<Real, N, 0, false>(z01, z23, all));
    }
}

}  // namespace detail

/// A pack of bonds of one particle. Lanes beyond `size` are bonds of the particle to itself.
template <class Real>
struct BondPack {
    std::uint32_t slot, size;
    const std::uint32_t* neighbour;

    /// Value of a per-bond field; 0 beyond `size`.
    Pack<Real> load(const Real* field) const { return perimpm::load(field + slot, size); }
    /// Value of a field of the neighbours, indexed over the whole material.
    Pack<Real> gather(const Real* field) const {
        return Pack<Real>([&](std::size_t lane) { return field[neighbour[lane]]; });
    }
    /// Vectors from the particle at `own` to its neighbours; both in arrays packed by four.
    void difference(const Real* packed, const Real* own, Pack<Real> out[3]) const {
        detail::gather3(packed, neighbour, out);
        for (int c = 0; c < 3; ++c) out[c] -= own[c];
    }
};

/// Calls body(pack, live) for the bonds of the block's particle i; `live` is 1 for whole bonds, 0 for broken ones and
/// for lanes beyond the pack's size.
template <class Real, class Body>
void for_each_bond(const Block<Real>& b, std::uint32_t i, Body body) {
    constexpr std::uint32_t lanes = kLanes<Real>;
    const auto& f = b.family;
    const bool damaged = f.damage && f.damage[i] > 0;
    for (std::uint32_t slot = f.row[i]; slot < f.row[i + 1]; slot += lanes) {
        const std::uint32_t size = std::min(lanes, f.row[i + 1] - slot);
        if (size == lanes && !damaged) {
            body(BondPack<Real>{slot, size, f.neighbour + slot}, Pack<Real>(1));
            continue;
        }
        std::uint32_t neighbour[lanes];
        for (std::uint32_t lane = 0; lane < lanes; ++lane)
            neighbour[lane] = lane < size ? f.neighbour[slot + lane] : b.first + i;
        body(BondPack<Real>{slot, size, neighbour}, Pack<Real>([&](std::size_t lane) {
                 return lane < size && !f.is_broken(slot + static_cast<std::uint32_t>(lane)) ? Real(1) : Real(0);
             }));
    }
}

/// 1/|v|, 0 for the zero vector (a bond shrunk to a point has no direction and no force).
template <class T>
T inverse_length(const T& length) {
    return select(length > T(0), T(1) / select(length > T(0), length, T(1)), T(0));
}

/// sum over the full cubic lattice of spacing h of value(|X|) h^3, |X| <= horizon.
template <class Value>
double lattice_sum(double horizon, double h, Value value) {
    const int reach = static_cast<int>(horizon / h) + 1;
    double sum = 0;
    for (int i = -reach; i <= reach; ++i)
        for (int j = -reach; j <= reach; ++j)
            for (int k = -reach; k <= reach; ++k) {
                const double length = h * std::sqrt(double(i * i + j * j + k * k));
                if (length > 0 && length <= horizon) sum += value(length) * h * h * h;
            }
    return sum;
}

/// Largest |Y|/|X| over the live bonds of the block, at least 1: waves travel faster through stretched families.
template <class Real>
double largest_stretch(const Block<Real>& b) {
    Pack<Real> largest(1);
    for (std::uint32_t i = 0; i < b.size; ++i) {
        const Real* own = b.family.position + 4 * std::size_t{b.first + i};
        for_each_bond(b, i, [&](const BondPack<Real>& bonds, const Pack<Real>& live) {
            Pack<Real> Y[3];
            bonds.difference(b.family.position, own, Y);
            const Pack<Real> stretch = live * norm(Y) * inverse_length(bonds.load(b.family.length));
            largest = select(stretch > largest, stretch, largest);
        });
    }
    return static_cast<double>(hmax(largest));
}

/// Silling & Askari 2005, eq. 50: dt < sqrt(2 m_i / sum_j k_ij), the smallest over the block [s]. `stiffness` times
/// `scale` is k [N/m].
template <class Real>
double silling_askari_bound(const Block<Real>& b, const Real* stiffness, double scale) {
    double smallest = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = 0; i < b.size; ++i) {
        double sum = 0;
        for (std::uint32_t slot = b.family.row[i]; slot < b.family.row[i + 1]; ++slot)
            sum += static_cast<double>(stiffness[slot]);
        if (sum > 0) smallest = std::min(smallest, std::sqrt(2 * static_cast<double>(b.mass[i]) / (scale * sum)));
    }
    return smallest;
}

}  // namespace perimpm::peridynamics
