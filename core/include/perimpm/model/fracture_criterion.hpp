#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "perimpm/export.hpp"
#include "perimpm/model/block.hpp"
#include "perimpm/model/params.hpp"

namespace perimpm {

/// A bond that a criterion singles out: slot `bond` in the row of `particle` (index within the material).
struct BondCandidate {
    std::uint32_t particle;
    std::uint32_t bond;
};

/// Collects what one block's screening found; room for every bond of the block.
struct CandidateList {
    BondCandidate* data;
    std::uint32_t size;

    void add(std::uint32_t particle, std::uint32_t bond) { data[size++] = {particle, bond}; }
};

/// Decides which bonds of one material break. Core applies the cuts to both directions of a bond at once, keeps them
/// broken for good and lets the law renew the reference quantities of the families that changed.
template <class Real>
class PERIMPM_API FractureCriterion {
public:
    virtual ~FractureCriterion();
    /// Every how many steps the criterion is asked.
    virtual std::uint32_t interval() const noexcept { return 1; }
    /// No bond with a stretch (|Y| - |X|)/|X| up to this is ever in question: blocks without longer ones are not screened,
    /// which saves a pass over their bonds. Default: every block is screened.
    virtual double harmless_stretch() const noexcept { return -std::numeric_limits<double>::infinity(); }
    /// Whether `screen` reads b.stored: core asks the law for the energies of the block's bonds first.
    virtual bool asks_bond_energy() const noexcept { return false; }
    /// Finds the live bonds in question; in parallel on disjoint blocks.
    virtual void screen(const Block<Real>& b, CandidateList& found) const = 0;
    /// Once for the whole material, when screening found something, in order of slot: puts the bonds to cut into `cuts`,
    /// which is empty; either direction of a bond will do. Default: all that was found.
    virtual void decide(const Block<Real>& all, std::span<const BondCandidate> found,
                        std::vector<BondCandidate>& cuts) const;
};

/// Of criteria that need not be asked in every step.
constexpr ParamSpec interval_param() {
    return {.key = "interval",
            .kind = ParamKind::integer,
            .unit = "steps",
            .range = at_least(1),
            .default_value = 1,
            .doc = "the criterion is asked every so many steps"};
}

extern template class FractureCriterion<float>;
extern template class FractureCriterion<double>;

}  // namespace perimpm
