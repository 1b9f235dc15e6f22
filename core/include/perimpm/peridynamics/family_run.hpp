#pragma once

#include <algorithm>
#include <type_traits>

#include "perimpm/peridynamics/family.hpp"

/*! Families several at a time. Inner particles of a lattice that follow each other in memory see the same bonds, and so
    do their neighbours: with a family in each lane the same loop over bonds runs without gathering, transposing and
    summing over lanes. Laws write it once, for `OneFamily` (lanes are bonds) and `FamilyRun` (lanes are particles). */
namespace perimpm::peridynamics {

/// The bonds of the block's particle i, a pack of them at a time. What sums over them is spread over the lanes.
template <class Real>
class OneFamily {
    using P = Pack<Real>;

public:
    OneFamily(const Block<Real>& b, std::uint32_t i) : b_{b}, i_{i} {}

    template <class Body>
    PERIMPM_INLINE void for_each_bond(Body body) const {
        peridynamics::for_each_bond(b_, static_cast<std::uint32_t>(i_), body);
    }
    /// Y of the bonds.
    PERIMPM_INLINE void deformed(const BondPack<Real>& bonds, P Y[3]) const {
        bonds.difference(b_.family.position, b_.family.position + 4 * (b_.first + i_), Y);
    }
    /// Writes the sums over the family.
    PERIMPM_INLINE void write(const P sums[3], const Field<Real>& to) const {
        const P four[4] = {sums[0], sums[1], sums[2], P(0)};
        Real sum[4];
        reduce_four(four, sum);
        for (std::size_t c = 0; c < 3; ++c) to[c][i_] = sum[c];
    }
    /// What only lanes with bonds of the family hold.
    PERIMPM_INLINE P own(const P& values) const { return values; }
    /// Sum over the family.
    PERIMPM_INLINE Real total(const P& sum) const { return reduce(sum); }
    /// Number of the particle, in a field of the block.
    PERIMPM_INLINE Real at(const Real* of_block) const { return of_block[i_]; }
    PERIMPM_INLINE void put(Real* of_block, Real value) const { of_block[i_] = value; }
    PERIMPM_INLINE void put_quad(Real* of_block, const Real quad[4]) const { std::copy_n(quad, 4, of_block + 4 * i_); }

private:
    const Block<Real>& b_;
    std::size_t i_;
};

/// Bonds of a run of families, the k-th of each: lane l shows that of the l-th family. `Shapes`: one index of first
/// constants where all have the same, else one for each lane.
template <class Real, class Shapes>
struct RunPack {
    std::ptrdiff_t neighbour;  ///< of the first family
    std::uint32_t k;
    std::uint32_t slot, count;  ///< of the first family's bond; bonds of a family
    std::size_t last;           ///< lane of the last family
    const Shapes& shape;

    /// Value of a per-bond field.
    PERIMPM_INLINE Pack<Real> load(const Real* field) const {
        return Pack<Real>([&](std::size_t lane) { return field[slot + count * std::min(lane, last)]; });
    }

    PERIMPM_INLINE Pack<Real> constant(const Real* numbers) const {
        if constexpr (std::is_array_v<Shapes>)
            return Pack<Real>([&](std::size_t lane) { return numbers[shape[lane] + k]; });
        else
            return Pack<Real>(numbers[shape + k]);
    }
    /// Value of a field of the neighbours, indexed over the whole material.
    PERIMPM_INLINE Pack<Real> gather(const Real* field) const {
        return Pack<Real>(field + neighbour, std::experimental::element_aligned);
    }
};

/// A run of families with one twin, a family in each lane: no transposes, no sums over lanes, and a neighbour's numbers are
/// read in a row. Lanes beyond the run's end show what is no family.
template <class Real>
class FamilyRun {
    using P = Pack<Real>;

public:
    static constexpr std::uint32_t kLeast = 3;  ///< shorter runs are faster one by one

    /// How many families from the block's particle i on one FamilyRun may take: at least kLeast, or none.
    static std::uint32_t size_at(const Block<Real>& b, std::uint32_t i) {
        const Families<Real>& f = b.family;
        if (!f.run || f.run[i] < kLeast) return 0;
        const std::uint32_t longest = std::min({std::uint32_t{f.run[i]}, std::uint32_t{kLanes<Real>}, b.size - i});
        std::uint32_t size = 0;
        while (size < longest && !(f.damage && f.damage[i + size] > 0)) ++size;
        return size < kLeast ? 0 : size;
    }

    FamilyRun(const Block<Real>& b, std::uint32_t i, std::uint32_t size) : b_{b}, i_{i}, size_{size} {
        for (std::uint32_t lane = 0; lane < kLanes<Real>; ++lane) {
            shape_[lane] = b.family.shape[i + (lane < size ? lane : 0)];
            one_shape_ = one_shape_ && shape_[lane] == shape_[0];
        }
    }
    std::uint32_t first() const { return i_; }
    std::uint32_t size() const { return size_; }

    template <class Body>
    PERIMPM_INLINE void for_each_bond(Body body) const {
        const TwinRow twin = twin_of(b_, i_);
        const std::uint32_t first = b_.family.row[i_], count = b_.family.row[i_ + 1] - first;
        const auto each = [&](const auto& shape) PERIMPM_INLINE_LAMBDA {
            using Bonds = RunPack<Real, std::remove_cvref_t<decltype(shape)>>;
            for (std::uint32_t k = 0; k < count; ++k)
                body(Bonds{static_cast<std::ptrdiff_t>(twin.neighbour[k]) + twin.shift, k, first + k, count, size_ - 1,
                           shape},
                     P(1));
        };
        one_shape_ ? each(shape_[0]) : each(shape_);
    }
    template <class Shapes>
    PERIMPM_INLINE void deformed(const RunPack<Real, Shapes>& bonds, P Y[3]) const {
        for (std::size_t c = 0; c < 3; ++c)
            Y[c] = bonds.gather(b_.family.y[c]) - P(b_.family.y[c] + b_.first + i_, std::experimental::element_aligned);
    }
    PERIMPM_INLINE void write(const P sums[3], const Field<Real>& to) const {
        for (std::size_t c = 0; c < 3; ++c) store(to[c] + i_, sums[c], size_);
    }
    PERIMPM_INLINE P own(const P& values) const { return select(first_lanes<Real>(size_), values, P(0)); }
    PERIMPM_INLINE P total(const P& sum) const { return sum; }
    PERIMPM_INLINE P at(const Real* of_block) const { return P(of_block + i_, std::experimental::element_aligned); }
    PERIMPM_INLINE void put(Real* of_block, const P& values) const { store(of_block + i_, values, size_); }
    PERIMPM_INLINE void put_quad(Real* of_block, const P quad[4]) const {
        store_quads_apart<4>(of_block + 4 * std::size_t{i_}, quad, size_);
    }

private:
    const Block<Real>& b_;
    std::uint32_t i_, size_;
    std::uint32_t shape_[kLanes<Real>];
    bool one_shape_ = true;
};

/// Calls body(families) for the block's particles, several of them in lanes where their families are alike, one by one
/// elsewhere; `families` is a OneFamily or a FamilyRun.
template <class Real, class Body>
PERIMPM_INLINE void for_each_family(const Block<Real>& b, Body body) {
    for (std::uint32_t i = 0; i < b.size;) {
        if (const std::uint32_t size = FamilyRun<Real>::size_at(b, i)) {
            body(FamilyRun<Real>(b, i, size));
            i += size;
        } else {
            body(OneFamily<Real>(b, i++));
        }
    }
}

}  // namespace perimpm::peridynamics
