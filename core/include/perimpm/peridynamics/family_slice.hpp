#pragma once

#include <algorithm>

#include "perimpm/peridynamics/family.hpp"

/*! Families several at a time. With one of them in each lane (Slice) the same loop over bonds runs without gathering,
    transposing and summing over lanes. Laws write it once, for `OneFamily` (lanes are bonds) and `FamilySlice` (lanes
    are particles). */
namespace perimpm::peridynamics {

/// What for_each_length need not do while it fetches.
inline constexpr auto fetch_only = [](const auto&, const auto*) {};

/// The bonds of the block's particle i, a pack of them at a time. What sums over them is spread over the lanes.
template <class Real>
class OneFamily {
    using P = Pack<Real>;

public:
    OneFamily(const Block<Real>& b, std::uint32_t i) : b_{b}, i_{i} {}
    std::uint32_t index() const { return static_cast<std::uint32_t>(i_); }

    template <class Body>
    PERIMPM_INLINE void for_each_bond(Body body) const {
        peridynamics::for_each_bond(b_, static_cast<std::uint32_t>(i_), body);
    }
    /// Y of the bonds.
    PERIMPM_INLINE void deformed(const BondPack<Real>& bonds, P Y[3]) const {
        bonds.difference(b_.family.position, b_.family.position + 4 * (b_.first + i_), Y);
    }
    /// Calls near(bonds, Y), then far(bonds, live, Y, |Y|), a pack of bonds at a time. Y is 0 for broken bonds and in lanes
    /// without a bond.
    template <class Near, class Far>
    PERIMPM_INLINE void for_each_length(Near near, Far far) const {
        for_each_bond([&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P Y[3];
            deformed(bonds, Y);
            for (P& y : Y) y *= live;
            near(bonds, Y);
            far(bonds, live, Y, length_of(Y));
        });
    }
    /// Writes the sums over the family.
    PERIMPM_INLINE void write(const P sums[3], const Field<Real>& to) const {
        const P four[4] = {sums[0], sums[1], sums[2], P(0)};
        Real sum[4];
        reduce_four(four, sum);
        for (std::size_t c = 0; c < 3; ++c) to[c][i_] = sum[c];
    }
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

/// An entry of a slice: lane l shows the bond of the l-th family. A lane whose family lacks it shows a particle that is no
/// neighbour, with the entry's X: what it gives must be multiplied by `live` or by a constant, which is 0 there.
template <class Real>
struct SliceEntry {
    std::size_t neighbour;  ///< of the first family
    std::size_t first_constant;
    Real reference_length;
    const Real* seen;    ///< X and V
    const Real* moment;  ///< w V X, w the constant LawNeeds::shared

    /// Value of a constant, 0 in lanes without the bond.
    PERIMPM_INLINE Pack<Real> constant(const Real* numbers) const {
        return Pack<Real>(numbers + first_constant, std::experimental::element_aligned);
    }
    /// |X|, a component of X, and the neighbour's V.
    PERIMPM_INLINE Pack<Real> length() const { return Pack<Real>(reference_length); }
    PERIMPM_INLINE Pack<Real> reference(std::size_t component) const { return Pack<Real>(seen[component]); }
    PERIMPM_INLINE Pack<Real> volume() const { return Pack<Real>(seen[3]); }
    /// Value of a field of the neighbours, indexed over the whole material.
    PERIMPM_INLINE Pack<Real> gather(const Real* field) const {
        return Pack<Real>(field + neighbour, std::experimental::element_aligned);
    }
};
/// An entry with the slots of its bonds.
template <class Real>
struct SlicePack : SliceEntry<Real> {
    const std::uint32_t* slots;  ///< by lane

    /// Value of a per-bond field. Lanes without the bond show that of a lane that has it.
    PERIMPM_INLINE Pack<Real> load(const Real* field) const {
        return Pack<Real>([&](std::size_t lane) { return field[slots[lane]]; });
    }
};

/// The families of a slice, one in each lane: no transposes, no sums over lanes, and a neighbour's numbers are read in
/// a row.
template <class Real>
class FamilySlice {
    using P = Pack<Real>;

public:
    static constexpr std::uint32_t kSize = kLanes<Real>;

    /// Whether the block's families from particle i on are a slice, and none of them lost bonds.
    static bool begins_at(const Block<Real>& b, std::uint32_t i) {
        const Families<Real>& f = b.family;
        if (!exist_in(b) || (b.first + i) % kSize != 0 || i + kSize > b.size || slice_of(b, i).size == 0) return false;
        return !f.damage ||
               std::all_of(f.damage + i, f.damage + i + kSize, [](std::uint32_t lost) { return lost == 0; });
    }

    /// Whether families of the material may be in slices.
    static bool exist_in(const Block<Real>& b) { return b.family.slices.lanes == kSize; }

    FamilySlice(const Block<Real>& b, std::uint32_t i) : b_{b}, i_{i}, slice_{slice_of(b, i)} {}
    std::uint32_t first() const { return i_; }
    /// Whether a family that goes alone, as those that lost bonds do, may have a neighbour among these particles.
    bool is_read_alone() const { return slice_.read_alone || b_.family.is_cut; }

    /// Calls body(pack, live) for the entries; `live` is 1 in the lanes that have the bond.
    template <class Body>
    PERIMPM_INLINE void for_each_bond(Body body) const {
        with_masks([&](auto live, auto has) PERIMPM_INLINE_LAMBDA {
            std::uint32_t next[kSize], shown[kSize];
            std::copy_n(b_.family.row + i_, kSize, next);
            for (std::uint32_t k = 0; k < slice_.size; ++k) {
                std::uint32_t owner = 0;
                while (has(k, owner) == 0) ++owner;
                for (std::uint32_t lane = 0; lane < kSize; ++lane) shown[lane] = next[has(k, lane) ? lane : owner];
                body(SlicePack<Real>{entry(k), shown}, live(k));
                for (std::uint32_t lane = 0; lane < kSize; ++lane) next[lane] += has(k, lane);
            }
        });
    }
    /// Calls body(entry) for the entries.
    template <class Body>
    PERIMPM_INLINE void for_each_entry(Body body) const {
        for (std::uint32_t k = 0; k < slice_.size; ++k) body(entry(k));
    }
    /// OneFamily::for_each_length with live = 1: there is no Y, and no constant, in lanes without a bond. Some entries in
    /// turns: a single loop would be a chain of operations that each wait for the last, longer than what a processor looks
    /// ahead.
    template <class Near, class Far>
    PERIMPM_INLINE void for_each_length(Near near, Far far) const {
        constexpr std::uint32_t kTurn = 16;
        alignas(P) Real kept[kTurn][4 * kSize];
        with_masks([&](auto live, auto) PERIMPM_INLINE_LAMBDA {
            for (std::uint32_t begin = 0; begin < slice_.size; begin += kTurn) {
                const std::uint32_t end = std::min(begin + kTurn, slice_.size);
                for (std::uint32_t k = begin; k < end; ++k) {
                    P Y[3];
                    deformed(entry(k), Y);
                    for (P& y : Y) y *= live(k);
                    near(entry(k), Y);
                    const P square = square_of(Y);
                    for (std::uint32_t c = 0; c < 3; ++c)
                        Y[c].copy_to(kept[k - begin] + c * kSize, std::experimental::vector_aligned);
                    square.copy_to(kept[k - begin] + 3 * kSize, std::experimental::vector_aligned);
                }
                for (std::uint32_t k = begin; k < end; ++k) {
                    P Y[4];
                    for (std::uint32_t c = 0; c < 4; ++c)
                        Y[c].copy_from(kept[k - begin] + c * kSize, std::experimental::vector_aligned);
                    far(entry(k), P(1), Y, root_of(Y[3]));
                }
            }
        });
    }
    /// Calls body(n n of the direction, as xx xy xz yy yz zz; sums of the families' axial constant times |X|^2) by axis.
    template <class Body>
    PERIMPM_INLINE void for_each_axis(Body body) const {
        const Slices<Real>& all = b_.family.slices;
        const Real *axis = all.axis + 6 * std::size_t{slice_.axis}, *sums = all.sum + slice_.sums;
        for (std::uint32_t k = 0; k < slice_.axes; ++k, axis += 6, sums += kSize)
            body(axis, P(sums, std::experimental::element_aligned));
    }
    PERIMPM_INLINE void deformed(const SliceEntry<Real>& bonds, P Y[3]) const {
        for (std::size_t c = 0; c < 3; ++c)
            Y[c] = bonds.gather(b_.family.y[c]) - P(b_.family.y[c] + b_.first + i_, std::experimental::element_aligned);
    }
    PERIMPM_INLINE void write(const P sums[3], const Field<Real>& to) const {
        for (std::size_t c = 0; c < 3; ++c) put(to[c], sums[c]);
    }
    PERIMPM_INLINE P total(const P& sum) const { return sum; }
    PERIMPM_INLINE P at(const Real* of_block) const { return P(of_block + i_, std::experimental::element_aligned); }
    PERIMPM_INLINE void put(Real* of_block, const P& values) const {
        values.copy_to(of_block + i_, std::experimental::element_aligned);
    }
    PERIMPM_INLINE void put_quad(Real* of_block, const P quad[4]) const {
        store_quads_apart<4>(of_block + 4 * std::size_t{i_}, quad);
    }

private:
    static const Slice& slice_of(const Block<Real>& b, std::uint32_t i) {
        return b.family.slices.slice[(b.first + i) / kSize];
    }
    PERIMPM_INLINE std::uint32_t mask(std::uint32_t k) const { return b_.family.slices.mask[slice_.masks + k]; }

    /// Calls body(live, has): live(k) of entry k, and has(k, lane), 1 where a family has the bond of entry k.
    template <class Body>
    PERIMPM_INLINE void with_masks(Body body) const {
        if (slice_.masks == Slice::kWhole)
            body([](std::uint32_t) PERIMPM_INLINE_LAMBDA { return P(1); },
                 [](std::uint32_t, std::uint32_t) { return 1u; });
        else
            body([this](std::uint32_t k) PERIMPM_INLINE_LAMBDA { return ones_at<Real>(mask(k)); },
                 [this](std::uint32_t k, std::uint32_t lane) { return mask(k) >> lane & 1; });
    }
    PERIMPM_INLINE SliceEntry<Real> entry(std::uint32_t k) const {
        const Slices<Real>& all = b_.family.slices;
        const std::uint32_t at = slice_.first + k;
        const std::ptrdiff_t neighbour = static_cast<std::ptrdiff_t>(b_.first + i_) + all.offset[at];
        return {static_cast<std::size_t>(neighbour), slice_.constants + std::uint64_t{kSize} * k, all.length[at],
                all.bond + 4 * std::size_t{at}, all.moment + 4 * std::size_t{at}};
    }

    const Block<Real>& b_;
    std::uint32_t i_;
    Slice slice_;
};

/// Calls body(families) for the block's particles, several of them in lanes where they are slices, one by one
/// elsewhere; `families` is a OneFamily or a FamilySlice.
template <class Real, class Body>
PERIMPM_INLINE void for_each_family(const Block<Real>& b, Body body) {
    for (std::uint32_t i = 0; i < b.size;) {
        if (FamilySlice<Real>::begins_at(b, i)) {
            body(FamilySlice<Real>(b, i));
            i += FamilySlice<Real>::kSize;
        } else {
            body(OneFamily<Real>(b, i++));
        }
    }
}

}  // namespace perimpm::peridynamics
