#pragma once

#include <cstdint>
#include <vector>

#include "perimpm/model/field.hpp"
#include "state/array.hpp"
#include "state/bonds.hpp"

namespace perimpm {

/// Numbers of bonds that never change. Families that have the same share them, as the inner families of a lattice
/// do: then they take no memory and no bandwidth.
template <class Real>
struct BondConstants {
    AlignedArray<std::uint32_t> shape;         ///< by particle: index of its first bond's numbers
    AlignedArray<std::uint32_t> twin;          ///< by particle: Families::twin
    AlignedArray<std::uint8_t> run;            ///< by particle: Families::run; empty before `share`
    AlignedArray<Real> length;                 ///< |X| [m]
    std::vector<AlignedArray<Real>> declared;  ///< the law's, in the order of declaration

    /// Lengths, and every declared number at its initial value; nothing is shared yet. `reference`: positions packed by
    /// four in the precision that forces are computed in: a bond in its reference state then has no extension, not even
    /// by rounding.
    BondConstants(const Bonds& bonds, const Real* reference, const FieldSpecs& declared);
    BondConstants() = default;

    /// Once the law has set its numbers.
    void share(const Bonds& bonds, const Real* reference);
};

extern template struct BondConstants<float>;
extern template struct BondConstants<double>;

}  // namespace perimpm
