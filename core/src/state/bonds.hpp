#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perimpm/geometry/shape.hpp"
#include "perimpm/model/block.hpp"
#include "state/array.hpp"

namespace perimpm {

/// Families of one material in compressed rows; fixed at the start, bonds only ever get marked as broken.
struct Bonds {
    AlignedArray<std::uint32_t> row;        ///< particles + 1
    AlignedArray<std::uint32_t> neighbour;  ///< ascending inside a row
    AlignedArray<std::uint64_t> broken;     ///< one bit per bond, and a word more; empty when nothing can break
    AlignedArray<std::uint32_t> damage;     ///< broken bonds per particle; empty likewise
    AlignedArray<float> share;              ///< the same over the particle's bonds at the start; empty likewise
    bool is_cut = false;                    ///< some bond is broken

    std::uint64_t size() const { return neighbour.size(); }
    /// Slot of the opposite direction (q, p) of the bond (p, q).
    std::uint32_t opposite(std::uint32_t particle, std::uint32_t slot) const;
    /// Marks one direction; false when it was broken before.
    bool break_direction(std::uint32_t particle, std::uint32_t slot);
    bool is_broken(std::uint32_t slot) const { return broken[slot >> 6] >> (slot & 63) & 1; }
};

/// All pairs of the same body at distance <= horizon [m], to a billionth. `bodies`: first particle of each body, then the
/// total.
/// Throws InputError for two particles at one place; more than 2^32 - 1 bonds.
Bonds build_bonds(std::span<const Vec3> X, std::span<const std::size_t> bodies, double horizon, bool can_break);

}  // namespace perimpm
