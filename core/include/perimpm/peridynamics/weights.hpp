#pragma once

#include <functional>
#include <map>
#include <vector>

#include "perimpm/math/isotropic_factors.hpp"
#include "perimpm/model/params.hpp"
#include "perimpm/peridynamics/family.hpp"
#include "perimpm/peridynamics/ghost_layer.hpp"

/*! Weights of bonds and what surfaces do to them. A law gives the weight w(|X|) of a bond and the sum that a family's
    weights must have; for springs, sum_q w_pq V_q n n n n, n = X/|X|, is the stiffness.
      none    w_pq = w * total / (sum over the full lattice): particles at surfaces stay soft
      family  w_pq = w * total / sum_q w V_q: each family has the whole sum
      ghost   the same of the family completed by ghosts (ghost_layer.hpp), whose share is added to bonds of the family
      moment  the least change of these, in relative terms, that makes sum_q w_pq V_q n n n n isotropic in the span of the
              family (after Trask et al. 2019, doi:10.1016/j.cma.2018.08.016; 15 equations per particle). No weight falls
              below a tenth of the family's: where that forbids isotropy, as at edges of bodies, the tensor comes as near
              as it can. Without this bound edges and irregular particles get weights of -40 to 50 times the mean, and the
              stiffness that the grid sees has negative eigenvalues; bonds of positive weight cannot do that */
namespace perimpm::peridynamics {

enum class Surface { none, family, moment, ghost };

constexpr ParamSpec surface_param(const char* standard) {
    return {.key = "surface",
            .kind = ParamKind::choice,
            .default_text = standard,
            .choices = "none|family|moment|ghost",
            .doc =
                "how particles near a surface make up for missing neighbours: not at all, by one factor per family, by "
                "a factor per bond that makes the family's stiffness as nearly isotropic as can be (inside bodies, "
                "too, where the others leave the lattice's own), or with ghost particles"};
}
inline Surface surface_of(const Params& p) {
    if (!p.is("surface", "ghost"))
        return p.is("surface", "moment")   ? Surface::moment
               : p.is("surface", "family") ? Surface::family
                                           : Surface::none;
    if (p.context().dimension < 3)
        throw InvalidParameter("surface", "\"ghost\" is for solids: sheets and strands take none, family or moment");
    return Surface::ghost;
}
/// Whether the two ends of a bond may give it weights that differ by more than their families' factors.
inline bool weighs_by_bond(Surface surface) { return surface == Surface::moment || surface == Surface::ghost; }

/// Slot of the bond from its other end, for the bond in `slot` of the block's particle i.
template <class Real>
std::uint32_t opposite_slot(const Block<Real>& b, std::uint32_t i, std::uint32_t slot) {
    const Families<Real>& f = b.family;
    const std::uint32_t* row = f.row - b.first;  // of the whole material
    const std::uint32_t other = f.neighbour[slot];
    const std::uint32_t* end = f.neighbour + row[other + 1];
    return static_cast<std::uint32_t>(std::lower_bound(f.neighbour + row[other], end, b.first + i) - f.neighbour);
}

/// Where a law keeps what its weights become: fields among its particle state and its constants of bonds.
struct WeightFields {
    std::uint32_t normalisation;  ///< of particles: factor of w
    std::uint32_t stiffness;      ///< constant: (w_pq + w_qp) V_p V_q / |X|^2
    int own = -1;                 ///< constant: w_pq V_p V_q / |X|^2; -1: not kept, where weighs_by_bond() is false
};

template <class Real>
class FamilyWeights {
public:
    using Weight = std::function<double(double)>;

    /// `total` is what the weights of a family sum to that fills the lattice up to `reach`.
    FamilyWeights(Surface surface, double total, const ModelContext& c, double reach, Weight weight)
        : surface_{surface},
          total_{total},
          full_sum_{lattice_sum(reach, c, weight)},
          weight_{std::move(weight)},
          ghosts_{c.particle_spacing, reach} {}

    /// The law's `initialise`, in two rounds. Weights are those of whole families: broken bonds do not change them.
    void initialise(Block<Real>& b, std::uint32_t round, const WeightFields& fields) const {
        FactorsFound found;
        for (std::uint32_t i = 0; i < b.size; ++i)
            round == 0 ? normalise(b, i, fields, found) : add_both_ends(b, i, fields);
    }

private:
    /// By directions and weights: families of a lattice are mostly alike.
    using FactorsFound = std::map<std::vector<double>, std::vector<double>>;

    static double volume(const Block<Real>& b, std::uint32_t slot) {
        return static_cast<double>(b.family.volume[b.family.neighbour[slot]]);
    }
    static double length(const Block<Real>& b, std::uint32_t i, std::uint32_t slot) {
        return static_cast<double>(b.family.length[constant_of(b.family, i, slot)]);
    }
    /// V_p V_q / |X|^2 times the weight before normalisation.
    double raw_stiffness(const Block<Real>& b, std::uint32_t i, std::uint32_t slot) const {
        const double X = length(b, i, slot);
        return weight_(X) * static_cast<double>(b.volume[i]) * volume(b, slot) / (X * X);
    }

    void normalise(Block<Real>& b, std::uint32_t i, const WeightFields& fields, FactorsFound& found) const {
        const std::uint32_t begin = b.family.row[i], end = b.family.row[i + 1];
        double sum = surface_ == Surface::none ? full_sum_ : 0;
        for (std::uint32_t slot = begin; slot < end && surface_ != Surface::none; ++slot)
            sum += weight_(length(b, i, slot)) * volume(b, slot);
        std::vector<Ghost> ghosts;
        if (surface_ == Surface::ghost) ghosts = ghosts_.of(b, i);
        for (const Ghost& ghost : ghosts) sum += weight_(ghost.length) * ghosts_.volume();
        const double factor = sum > 0 ? total_ / sum : 0;
        b.particle_state[fields.normalisation][0][i] = static_cast<Real>(factor);
        if (fields.own < 0) return;
        Real* own = b.bond_constants[fields.own] + b.family.shape[i];
        for (std::uint32_t slot = begin; slot < end; ++slot)
            own[slot - begin] = static_cast<Real>(factor * raw_stiffness(b, i, slot));
        if (surface_ == Surface::moment && sum > 0) make_isotropic(b, i, factor, own, found);
        for (const Ghost& ghost : ghosts) add_share(b, i, ghost, factor, own);
    }

    /// w V_p V / |X|^2 of a ghost, at its length, for a bond that is stretched alike, at its own.
    void add_share(const Block<Real>& b, std::uint32_t i, const Ghost& ghost, double factor, Real* own) const {
        const double weighted = factor * weight_(ghost.length) * static_cast<double>(b.volume[i]) * ghosts_.volume();
        for (const std::size_t k : ghost.bonds) {
            const double X = length(b, i, b.family.row[i] + static_cast<std::uint32_t>(k));
            own[k] += static_cast<Real>(weighted / (X * X * static_cast<double>(ghost.bonds.size())));
        }
    }

    void make_isotropic(const Block<Real>& b, std::uint32_t i, double factor, Real* own, FactorsFound& found) const {
        const std::uint32_t begin = b.family.row[i], end = b.family.row[i + 1];
        std::vector<double> directions, weights;
        const Real* at = b.family.reference + 4 * std::size_t{b.first + i};
        for (std::uint32_t slot = begin; slot < end; ++slot) {
            const Real* other = b.family.reference + 4 * std::size_t{b.family.neighbour[slot]};
            for (int c = 0; c < 3; ++c) directions.push_back(other[c] - at[c]);
            weights.push_back(factor * weight_(length(b, i, slot)) * volume(b, slot));
        }
        std::vector<double> key = directions;
        key.insert(key.end(), weights.begin(), weights.end());
        const auto [known, is_new] = found.try_emplace(std::move(key), weights.size());
        std::vector<double>& factors = known->second;
        if (is_new) isotropic_factors(directions, weights, factors);
        for (std::size_t k = 0; k < factors.size(); ++k) own[k] *= static_cast<Real>(factors[k]);
    }

    void add_both_ends(Block<Real>& b, std::uint32_t i, const WeightFields& fields) const {
        const Field<Real>& factor = b.family_state[fields.normalisation];
        const std::uint32_t* shape = b.family.shape - b.first;  // of the whole material, as row
        const std::uint32_t* row = b.family.row - b.first;
        for (std::uint32_t slot = b.family.row[i]; slot < b.family.row[i + 1]; ++slot) {
            const std::uint32_t here = constant_of(b.family, i, slot), q = b.family.neighbour[slot];
            double both;
            if (weighs_by_bond(surface_)) {
                const Real* own = b.bond_constants[fields.own];
                both = static_cast<double>(own[here]) +
                       static_cast<double>(own[shape[q] + opposite_slot(b, i, slot) - row[q]]);
            } else {
                both = raw_stiffness(b, i, slot) *
                       (static_cast<double>(factor[0][b.first + i]) + static_cast<double>(factor[0][q]));
            }
            b.bond_constants[fields.stiffness][here] = static_cast<Real>(both);
        }
    }

    Surface surface_;
    double total_, full_sum_;
    Weight weight_;
    GhostLayer ghosts_;
};

}  // namespace perimpm::peridynamics
