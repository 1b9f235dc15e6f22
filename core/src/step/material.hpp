#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "perimpm/model/constitutive_law.hpp"
#include "perimpm/model/fracture_criterion.hpp"
#include "perimpm/plugin/registry.hpp"
#include "state/array.hpp"
#include "state/bond_constants.hpp"
#include "state/bonds.hpp"

namespace perimpm {

/// Particles of a grid block that law and transfer see together: usually all of them.
inline constexpr std::uint32_t kRun = 512;
inline constexpr std::uint32_t kChunk = 128;  ///< particles of other passes that one task takes, in cache

/// A declared state field of a law, allocated.
template <class Real>
struct StateField {
    FieldSpec spec;
    FieldArray<Real> values;
};

/// All particles of one material: a contiguous range of the common arrays, and what its law asked for.
template <class Real>
struct Material {
    std::string name, law_name, criterion_name;
    double density;
    std::uint32_t dimension;  ///< of its bodies: 3 solids, 2 sheets, 1 strands
    ModelPtr<ConstitutiveLaw, Real> law;
    LawNeeds needs;
    ModelPtr<FractureCriterion, Real> criterion;  ///< null: nothing breaks
    std::size_t begin = 0, size = 0;
    std::uint32_t number = 0;           ///< in the scene
    std::vector<std::uint32_t> bodies;  ///< first particle of each, within the material
    double spacing = 0;                 ///< of its particles [m]
    double lightness = 1;               ///< wave speed over that of its density, where masses or volumes were written
    double contact_stiffness = 0;       ///< of two of its particles that touch [N/m]
    bool frees_crack_surfaces = false;  ///< particles with broken bonds leave the grid
    bool parts_fragments = false;       ///< fragments of bodies in pieces have velocity fields of their own

    std::vector<StateField<Real>> particle_state;
    std::vector<AlignedArray<Real>> bond_state;
    std::vector<std::pair<const ParamSpec*, AlignedArray<Real>>>
        varying;                                    ///< by declared per-particle parameter; empty: uniform
    FieldArray<Real> F;                             ///< local laws
    FieldArray<Real> force, stress;                 ///< bond laws: one of the two
    Bonds bonds;                                    ///< bond laws
    AlignedArray<Real> position, reference;         ///< bond laws: x and X packed by four
    BondConstants<Real> constants;                  ///< bond laws
    AlignedArray<std::uint32_t> order;              ///< bond laws: particle indices in grid order
    std::vector<std::vector<BondCandidate>> found;  ///< criteria: what screening found, by chunk
    std::vector<BondCandidate> candidates, cuts;    ///< the same, joined; those that break
    std::vector<std::uint32_t> freed;               ///< criteria: particles that lost their first bond
    std::vector<double> stretch;                    ///< bond laws: largest stretch by chunk, infinite where unknown
    std::vector<char> touched;                      ///< criteria: chunks whose forces a cut changes
    std::vector<std::uint32_t> piece;               ///< by particle, where the material has pieces: its piece
    std::vector<std::uint32_t> block_begin;  ///< by particle block: its first particle in grid order, then the total

    bool has_bonds() const { return needs.bonds; }
    /// Whether the material allows a bond between two of its particles to break.
    bool may_part(std::uint32_t p, std::uint32_t q) const { return piece.empty() || piece[p] != piece[q]; }
    bool can_break() const { return !bonds.broken.empty(); }
    /// Of bond laws: whether two particles, counted within the material, are of one body.
    bool same_body(std::uint32_t p, std::uint32_t q) const {
        const auto body = [&](std::uint32_t n) { return std::upper_bound(bodies.begin(), bodies.end(), n); };
        return bodies.size() == 1 || body(p) == body(q);
    }
    bool has_own_fields() const { return parts_fragments && bonds.is_cut; }
    /// Whether particle p, counted within the material, moves by its own forces instead of with the grid.
    bool is_free(std::size_t p) const { return frees_crack_surfaces && bonds.damage[p] > 0; }
    std::size_t chunks() const { return (size + kChunk - 1) / kChunk; }
};

}  // namespace perimpm
