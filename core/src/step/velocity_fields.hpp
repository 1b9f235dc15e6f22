#pragma once

#include <cstdint>
#include <vector>

#include "state/array.hpp"

namespace perimpm {

/// A fragment, or all that move with the common velocity field, and the blocks that its particles are in.
struct FieldOwner {
    std::uint32_t field = 0;
    std::vector<std::uint64_t> blocks;  ///< sorted keys
};

/// Velocity fields of fragments on the grid: nodes of different fields are different nodes. Fragments whose tiles overlap
/// have different fields, those that lie apart share them, so that until the next sort no two of a field meet at a node.
template <class Real>
struct VelocityFields {
    bool is_stale = true;                              ///< bonds broke since fragments were found
    std::vector<FieldOwner> owners;                    ///< the common one, then fragments, largest first
    std::vector<std::uint32_t> owner;                  ///< by particle: index into `owners`
    std::vector<std::vector<std::uint64_t>> occupied;  ///< by field: sorted keys of its owners' blocks
    std::vector<Real> full_mass;                       ///< by grid block: of a node amid its densest material [kg]

    std::size_t bytes() const {
        std::size_t keys = 0;
        for (const FieldOwner& one : owners) keys += one.blocks.capacity();
        for (const std::vector<std::uint64_t>& blocks : occupied) keys += blocks.capacity();
        return 8 * keys + 4 * owner.capacity() + sizeof(Real) * full_mass.capacity();
    }
};

}  // namespace perimpm
