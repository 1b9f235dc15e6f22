#pragma once

#include <cstdint>
#include <vector>

#include "perimpm/model/constitutive_law.hpp"
#include "state/array.hpp"
#include "state/bonds.hpp"
#include "state/lattice_rows.hpp"

namespace perimpm {

/// Families of neighbouring particles side by side: Slices and what they show.
template <class Real>
struct BondSlices {
    std::uint32_t lanes = 0;
    AlignedArray<Slice> slice;  ///< by particle over lanes
    AlignedArray<std::int32_t> offset;
    AlignedArray<Real> bond, length, moment;
    AlignedArray<std::uint32_t> mask;
    AlignedArray<Real> axis, sum;

    Slices<Real> view() const;
    std::size_t bytes() const {
        return slice.bytes() + offset.bytes() + bond.bytes() + length.bytes() + moment.bytes() + mask.bytes() +
               axis.bytes() + sum.bytes();
    }
};

/// Numbers of bonds that never change. Families that have the same share them, as the inner families of a lattice
/// do: then they take no memory and no bandwidth.
template <class Real>
struct BondConstants {
    AlignedArray<std::uint32_t> shape;         ///< by particle: index of its first bond's numbers
    AlignedArray<Real> length;                 ///< |X| [m]
    std::vector<AlignedArray<Real>> declared;  ///< the law's, in the order of declaration; those of slices last
    BondSlices<Real> slices;
    BondRows<Real> rows;

    /// Lengths, and every declared number at its initial value; nothing is shared yet. `reference`: positions packed by
    /// four in the precision that forces are computed in: a bond in its reference state then has no extension, not even
    /// by rounding.
    BondConstants(const Bonds& bonds, const Real* reference, const FieldSpecs& declared);
    BondConstants() = default;

    /// Once the law has set its numbers. `needs`: what slices it asks for.
    void share(const Bonds& bonds, const Real* reference, const LawNeeds& needs);

private:
    void make_slices(const Bonds& bonds, const Real* reference, const LawNeeds& needs);
};

extern template struct BondConstants<float>;
extern template struct BondConstants<double>;

}  // namespace perimpm
