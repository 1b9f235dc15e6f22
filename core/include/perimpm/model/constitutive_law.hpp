#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "perimpm/export.hpp"
#include "perimpm/model/block.hpp"
#include "perimpm/model/params.hpp"

namespace perimpm {

/// Small-strain moduli that the law was asked for, in plane stress for sheets; NaN where it has none.
struct EffectiveModuli {
    double youngs_modulus = std::numeric_limits<double>::quiet_NaN();  ///< [Pa]
    double poisson_ratio = std::numeric_limits<double>::quiet_NaN();   ///< [1]
};

/// Stable steps [s] of symplectic Euler and Verlet, infinite where nothing bounds them.
struct StableStep {
    double small_strains = std::numeric_limits<double>::infinity();
    double any_stretch = small_strains;  ///< however far bonds are stretched

    /// For bonds of relative extensions (|Y| - |X|)/|Y| up to `extension`: 1/dt^2 in between as a spring's stiffness across
    /// itself is, k (|Y| - |X|)/|Y|, beside k along itself.
    double at(double extension) const {
        return 1 /
               std::sqrt((1 - extension) / (small_strains * small_strains) + extension / (any_stretch * any_stretch));
    }
    StableStep smaller(const StableStep& other) const {
        return {std::min(small_strains, other.small_strains), std::min(any_stretch, other.any_stretch)};
    }
};

/// What a law declares to core. It asks for a deformation gradient (then it writes tau) or for bonds (force, or tau).
struct LawNeeds {
    bool deformation_gradient = false;
    bool flows = false;  ///< local laws: `evaluate` leaves the elastic part in b.F
    bool bonds = false;
    bool stress = false;   ///< bond laws: `evaluate` writes tau, whose divergence the grid takes, and no force
    bool prepare = false;  ///< bond laws: `prepare` does something and must run before `evaluate`
    bool reports_stretch =
        false;  ///< bond laws: `evaluate` fills Block::largest_stretch; else steps are those of any stretch
    bool stores_in_bonds = false;  ///< bond laws: `bond_energy` says how much energy each bond stores
    bool may_refuse = false;       ///< local laws: `evaluate` throws for some deformation gradients
    double horizon = 0;            ///< bond laws: family radius, rim included [m]
    std::uint32_t rounds = 1;      ///< how often `initialise` runs, with a barrier between
    std::uint32_t lanes = 0;       ///< bond laws: families of a slice, kLanes<Real>; 0: the law needs no slices
    int axial = -1;                ///< bond laws: constant of bonds that slices sum by axis; -1: none
    int shared = -1;  ///< bond laws: constant that families with the same X and V share, which slices show in
                      ///< `moment` alone; -1: none
    bool rows =
        false;  ///< bond laws: whether `evaluate` takes rows of a lattice together; with `lanes`, where slices exist
    FieldSpecs particle_state = {};
    FieldSpecs bond_state = {};
    FieldSpecs bond_constants = {};  ///< numbers of bonds that `initialise` sets and nothing changes
    EffectiveModuli moduli = {};
    BondVolumes volumes = {};  ///< bond laws: what counts of a neighbour's volume
    /// Bond laws: energy per area of the bonds across a plane of the lattice, all stretched alike, over the square of the
    /// stretch; NaN where the law does not know it [J/m^2].
    double opening_energy = std::numeric_limits<double>::quiet_NaN();
};

/// Response of a solid; one object serves all particles of one material. Real: float or double.
/// Calls are safe in parallel on disjoint blocks.
template <class Real>
class PERIMPM_API ConstitutiveLaw {
public:
    virtual ~ConstitutiveLaw();
    virtual LawNeeds needs() const noexcept = 0;
    /// Reference quantities of the declared fields at the start, when all bonds are whole. A later round may read what an
    /// earlier one wrote for the neighbours.
    virtual void initialise(Block<Real>&, std::uint32_t /*round*/) const {}
    /// Bond laws: reference quantities of particles that depend on which bonds are whole, after some broke.
    virtual void renew(Block<Real>&) const {}
    /// Bond laws: per-particle family quantities, before any neighbour reads them. May run more than once in a step, when
    /// bonds break and when energies are asked for: twice must be as once.
    virtual void prepare(Block<Real>&) const {}
    /// In: b.F (trial) or b.family. Out: b.tau [Pa] or b.force [N]. dt in s. Runs once per step, and may write b.F and the
    /// declared fields: a law that flows leaves the elastic part of F there, which the grid moves on.
    virtual void evaluate(Block<Real>& b, Real dt) const = 0;
    /// Bound of the wave speed in the block as it is now [m/s]; grid transfers take the time step from it.
    virtual double max_wave_speed(const Block<Real>& b) const = 0;
    /// Largest stable steps of the block when forces move the particles without a grid; bond laws.
    virtual StableStep stable_step(const Block<Real>& b) const;
    /// Stored energy of the block [J]; NaN where the law has none.
    virtual double energy(const Block<Real>& b) const = 0;
    /// Laws that declare `stores_in_bonds`, after `prepare` of every block: energy of each bond of the block into b.stored,
    /// 0 where broken. A particle's bonds hold, with what they store at its own end, all of its stored energy.
    virtual void bond_energy(const Block<Real>& b) const;
};

extern template class ConstitutiveLaw<float>;
extern template class ConstitutiveLaw<double>;

}  // namespace perimpm
