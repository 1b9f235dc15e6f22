#pragma once

#include <cstdint>

#include "perimpm/model/field.hpp"

namespace perimpm {

inline constexpr std::uint32_t kMaxStateFields = 12;
inline constexpr std::uint32_t kMaxVaryingParams = 8;
inline constexpr std::uint32_t kSlotPadding = 16;

/// As many families side by side as a register has lanes (the SELL-C format of Kreutzer et al. 2014,
/// doi:10.1137/130930352). An entry is a bond that some of them have: neighbours at one distance in memory, with the
/// same X, V and shared constant, bit by bit. Families without it have constants 0 there. An axis is a line through the
/// particles on which one or more of the entries lie, as X, -X and 2 X do.
struct Slice {
    static constexpr std::uint32_t kWhole = ~0u;
    std::uint32_t first = 0;      ///< its first entry
    std::uint32_t size = 0;       ///< entries; 0: families go one by one
    std::uint32_t masks = 0;      ///< its first mask, or kWhole: every family has every bond
    std::uint64_t constants = 0;  ///< its first constant: that of lane l and entry k is lanes k + l further
    std::uint32_t axis = 0;       ///< its first axis
    std::uint32_t axes = 0;       ///< how many
    std::uint64_t sums = 0;       ///< its first sum: that of lane l and axis k is lanes k + l further
    bool read_alone = false;      ///< families that are in no slice have neighbours in this one
};

/// Slices of one material, entries and masks that are the same kept once.
template <class Real>
struct Slices {
    static constexpr std::uint32_t kMostLanes = 16;
    std::uint32_t lanes = 0;               ///< families of a slice, LawNeeds::lanes
    const Slice* slice = nullptr;          ///< by particle over lanes, of the whole material; null: none
    const std::int32_t* offset = nullptr;  ///< by entry: from a family's particle to the neighbour
    const Real* bond = nullptr;            ///< by entry: X and V, packed by four [m], [m^3]
    const Real* length = nullptr;          ///< by entry: |X| [m]
    const Real* moment = nullptr;          ///< by entry: w V X, packed by four, w the constant LawNeeds::shared, else 1
    const std::uint32_t* mask = nullptr;   ///< which lanes have the bond, the first lane's bit lowest
    const Real* axis = nullptr;            ///< by axis: n n of its direction n, xx xy xz yy yz zz
    const Real* sum = nullptr;             ///< sum S |X|^2 over the bonds on an axis, S the constant LawNeeds::axial
};

/// Particles of a lattice side by side in memory and along an axis, all of whose bonds its RowNeighbours show.
struct LatticeRow {
    std::uint32_t first = 0, size = 0;            ///< its particles: places 0 to size - 1
    std::uint32_t axis = 0;                       ///< 0, 1 or 2: along it; the next two, modulo 3, are across
    std::uint32_t neighbours = 0;                 ///< its first RowNeighbour, by falling reach
    std::uint32_t count = 0;                      ///< how many
    std::int32_t begin = 0, end = 0;              ///< places of the row and of every RowNeighbour of reach > 0
    std::int32_t whole_begin = 0, whole_end = 0;  ///< places at which all of these have a particle
};

/// A row beside another, or the same: the particle at place z of the one has bonds with those at places z - reach to
/// z + reach of the other, as far as there are any, but not with itself.
template <class Real>
struct RowNeighbour {
    static constexpr std::uint32_t kMostReach = 2;
    std::int32_t offset = 0;          ///< in memory, to the particle at the same place
    std::int32_t begin = 0, end = 0;  ///< places at which there is one
    std::uint32_t reach = 0;
    Real across[3] = {};               ///< X at the same place, along the row last: 0; reach 0: w V X of the bond
    Real weight[kMostReach + 1] = {};  ///< w V of the bonds d places along, w the constant LawNeeds::shared, else 1
    Real along[kMostReach + 1] = {};   ///< w V times X along the row
};

/// Rows of one material in the order of their particles, each RowNeighbour of the same bits kept once.
template <class Real>
struct LatticeRows {
    const LatticeRow* row = nullptr;
    std::uint32_t count = 0;
    const RowNeighbour<Real>* neighbour = nullptr;
};

/// Bond families of one material in compressed rows. Indices count from the material's first particle.
/// Positions are packed by four so that a neighbour costs one load: x of entry j is position[4 j .. 4 j + 2], likewise
/// X, which V follows in reference[4 j + 3].
/// Constants are numbers of bonds that never change. Families that have the same, bit by bit, share them: those of the
/// block's particle i begin at shape[i], in the order of its bonds.
/// Arrays by slot and by constant may be read up to kSlotPadding entries past their end, where neighbours are valid indices.
template <class Real>
struct Families {
    const std::uint32_t* row = nullptr;        ///< bonds of the block's particle i: slots row[i] .. row[i + 1] - 1
    const std::uint32_t* neighbour = nullptr;  ///< by slot, ascending inside a row
    const std::uint64_t* broken = nullptr;     ///< one bit per slot; null when no criterion can break bonds
    const std::uint32_t* damage = nullptr;     ///< broken bonds of the block's particle i; null like `broken`
    const Real* position = nullptr;            ///< y of every particle of the material [m]
    const Real* reference = nullptr;           ///< X and V of every particle of the material [m], [m^3]
    const Real* volume = nullptr;              ///< V of every particle of the material [m^3]
    const std::uint32_t* shape = nullptr;      ///< first constant of the block's particle i
    const Real* length = nullptr;              ///< constant: |X|, from `reference` in the same precision [m]
    Slices<Real> slices;                       ///< the same families side by side, for laws that ask for them
    LatticeRows<Real> rows;                    ///< the same families as rows of a lattice, likewise
    bool is_cut = false;  ///< bonds of the material broke: families of slices and rows may go one by one
    Field<const Real> y;  ///< position of every particle again, by component

    bool is_broken(std::uint32_t slot) const { return broken && (broken[slot >> 6] >> (slot & 63) & 1); }
    /// The flags of the 32 bonds from `slot` on, the first one's lowest; only where there are flags.
    std::uint32_t broken_from(std::uint32_t slot) const {
        const std::uint64_t *word = broken + (slot >> 6), low = word[0] >> (slot & 63);
        return static_cast<std::uint32_t>((slot & 63) == 0 ? low : low | word[1] << (64 - (slot & 63)));
    }
};

/// Energy that bonds store at their own and at their other end [J]. Bonds of a block, the first of its first particle
/// foremost; may be written up to kSlotPadding entries past its end.
template <class Real>
struct BondEnergy {
    Real* own = nullptr;
    Real* other = nullptr;
};

/// What a law sees: a run of particles of one material. `prepare` and `evaluate` get the same runs, which cut no slice. Fields start at the block's first particle, except those of
/// `family`, `bond_state` and `bond_constants`, which are indexed over the whole material. Plain data: it crosses library
/// borders.
template <class Real>
struct Block {
    std::uint32_t size = 0;
    std::uint32_t first = 0;                    ///< index of the first particle within the material
    Real dt = 0;                                ///< the step being taken [s]
    Field<const Real> x;                        ///< position [m], 3
    Field<const Real> v;                        ///< velocity [m/s], 3
    const Real* mass = nullptr;                 ///< [kg]
    const Real* volume = nullptr;               ///< reference volume [m^3]
    Field<Real> F;                              ///< deformation gradient, 9, row-major; local laws. In: trial;
                                                ///< `evaluate` may leave its elastic part, the others only read
    Field<Real> tau;                            ///< out: Kirchhoff stress [Pa], 6: xx xy xz yy yz zz; laws of stress
    Field<Real> force;                          ///< out: internal force [N], 3; laws of force
    const Real* param[kMaxVaryingParams] = {};  ///< values of the parameters that vary, else null
    Field<Real> particle_state[kMaxStateFields] = {};  ///< declared particle fields, in the order of declaration
    Real* bond_state[kMaxStateFields] = {};            ///< declared bond fields, by slot over the whole material
    Real* bond_constants[kMaxStateFields] = {};        ///< declared constants of bonds; only `initialise` writes them
    Field<Real> family_state[kMaxStateFields] = {};    ///< particle_state again, indexed over the whole material
    Families<Real> family;                             ///< bond laws
    BondEnergy<Real> stored;                           ///< out: of `bond_energy`; in: criteria that ask for it
    Real largest_stretch = 0;                          ///< out: (|Y| - |X|)/|X| of the block's live bonds, at least 0
};

}  // namespace perimpm
