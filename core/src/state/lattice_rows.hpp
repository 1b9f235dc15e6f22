#pragma once

#include <cstdint>
#include <vector>

#include "perimpm/model/block.hpp"
#include "state/array.hpp"
#include "state/bonds.hpp"

namespace perimpm {

/// Families as rows of a lattice: LatticeRows and what they show.
template <class Real>
struct BondRows {
    AlignedArray<LatticeRow> row;
    AlignedArray<RowNeighbour<Real>> neighbour;

    LatticeRows<Real> view() const { return {row.data(), static_cast<std::uint32_t>(row.size()), neighbour.data()}; }
    std::size_t bytes() const { return row.bytes() + neighbour.bytes(); }
};

/// Rows of at least `shortest` > 1 particles with neighbours that reach along them, by `least_reach` or more on average.
/// Rows whose bonds cannot be shown, all of them and bit by bit, are left out. `reference`: X and V packed by four.
/// `shape`, `shared`: Families::shape and the constant LawNeeds::shared; null: none.
template <class Real>
BondRows<Real> find_lattice_rows(const Bonds& bonds, const Real* reference, const std::uint32_t* shape,
                                 const Real* shared, std::uint32_t shortest, double least_reach);

extern template BondRows<float> find_lattice_rows(const Bonds&, const float*, const std::uint32_t*, const float*,
                                                  std::uint32_t, double);
extern template BondRows<double> find_lattice_rows(const Bonds&, const double*, const std::uint32_t*, const double*,
                                                   std::uint32_t, double);

}  // namespace perimpm
