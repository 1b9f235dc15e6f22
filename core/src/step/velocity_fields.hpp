#pragma once

#include <cstdint>
#include <vector>

#include "perimpm/geometry/shape.hpp"
#include "state/grid.hpp"

namespace perimpm {

/// A fragment, or all that move with the common velocity field, and the blocks that its particles are in.
struct FieldOwner {
    std::uint32_t field = 0;
    std::vector<std::uint64_t> blocks;  ///< sorted keys
};

/// A field at a node where there are several.
template <class Real>
struct FieldAtNode {
    const SharedBlock* shared;
    double mass;     ///< [kg]
    Real* momentum;  ///< where impulses go
    Vec3 velocity = Vec3::Zero();
    Vec3 slope = Vec3::Zero();  ///< gradient of mass over mass [1/cells], once `has_slope`
    bool has_slope = false;
};

/*! Velocity fields of fragments on the grid: nodes of different fields are different nodes, as in the multi-velocity contact
    of Bardenhagen et al. 2001 (CMES 2, 509) and Nairn 2013 (CMES 92, 271); by fragment instead of by damage gradient (Homel &
    Herbold 2017, doi:10.1002/nme.5317), so that a crack must have gone through. Fragments whose tiles overlap have different
    fields, those that lie apart share them: until the next sort no two of a field meet at a node. */
template <class Real>
struct VelocityFields {
    bool is_stale = true;                              ///< bonds broke since fragments were found
    std::vector<std::uint32_t> label;                  ///< by particle: its fragment
    std::vector<FieldOwner> owners;                    ///< the common one, then fragments, largest first
    std::vector<std::uint32_t> owner;                  ///< by particle: index into `owners`
    std::vector<std::vector<std::uint64_t>> occupied;  ///< by field: sorted keys of its owners' blocks
    std::vector<std::uint64_t> merged;
    std::vector<Real> full_mass;  ///< by grid block: of a node amid its densest material [kg]

    std::size_t bytes() const {
        std::size_t keys = 0;
        for (const FieldOwner& one : owners) keys += one.blocks.capacity();
        for (const std::vector<std::uint64_t>& blocks : occupied) keys += blocks.capacity();
        return 8 * (keys + merged.capacity()) + 4 * (label.capacity() + owner.capacity()) +
               sizeof(Real) * full_mass.capacity();
    }
};

}  // namespace perimpm
