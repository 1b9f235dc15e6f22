#pragma once

#include <cstdint>

#include "perimpm/export.hpp"
#include "perimpm/model/field.hpp"
#include "perimpm/model/params.hpp"

namespace perimpm {

/// Private piece of the grid around one 4x4x4-cell block: 8x8x8 nodes, z fastest, four numbers per node.
/// Scatter: (momentum [kg m/s], mass [kg]); gather: (velocity [m/s], mass).
inline constexpr int kTileNodes = 8;
inline constexpr int kTileOffset = 2;  ///< the tile starts two nodes below the block's first node
inline constexpr int kTileValues = 4 * kTileNodes * kTileNodes * kTileNodes;
inline constexpr int kTilePadding = 16;  ///< numbers past the tile's end that kernels may read and write: stencils of
                                         ///< low degree are taken four nodes wide along z

/// What a transfer kernel sees: particles of one material inside one grid block, and the tile around them.
template <class Real>
struct TransferBlock {
    std::uint32_t size = 0;
    Real dt = 0;                  ///< [s]
    Real spacing = 0;             ///< dx [m]
    std::int32_t origin[3] = {};  ///< index of the tile's first node
    Field<Real> x, v;             ///< [m], [m/s]
    Field<Real> C;  ///< affine velocity [1/s], 9, row-major (kCarriedMoment, bspline.hpp): in to scatter, out
                    ///< of gather; null unless the kernel asks for it
    Field<Real> F;  ///< deformation gradient, 9; null unless the law asks for it
    const Real* mass = nullptr;    ///< [kg]; scatter
    const Real* volume = nullptr;  ///< reference volume [m^3]; scatter
    Field<const Real> tau;         ///< Kirchhoff stress [Pa], 6; scatter, null for laws of force
    Field<const Real> force;       ///< internal force [N], 3; scatter, null for laws of stress
    Real* tile = nullptr;          ///< kTileValues + kTilePadding numbers, 64-byte aligned
    Real* increment = nullptr;     ///< second tile: scatter (impulse, -), gather (velocity before forces, -)
    Real fastest2 = 0;             ///< out of gather: largest squared grid velocity at a particle [m^2/s^2]
    Real sum2 = 0;                 ///< out of gather: sum of the same, not finite when any velocity is not
};

struct TransferNeeds {
    bool grid = true;
    bool affine = false;        ///< an affine velocity field C per particle
    bool increment = false;     ///< the grid keeps the velocity before forces (FLIP)
    bool own_velocity = false;  ///< gather reads the velocities that particles had (FLIP); else they may hold anything
    std::uint32_t order = 0;    ///< B-spline degree; 0 without grid
    double courant = 0;         ///< largest stable (c + |v|) dt / dx
};

/// Carries mass, momentum and forces between particles and grid, or moves particles without one.
/// Calls are safe in parallel on disjoint blocks.
template <class Real>
class PERIMPM_API TransferKernel {
public:
    virtual ~TransferKernel();
    virtual TransferNeeds needs() const noexcept = 0;
    /// Adds the particles' mass, momentum and dt times their internal force to the tile.
    virtual void scatter(TransferBlock<Real>& b) const = 0;
    /// Reads the tile's velocities: new v, C, x, and F by the velocity gradient. C is written only, and v, too, unless
    /// `own_velocity` is declared.
    virtual void gather(TransferBlock<Real>& b) const = 0;
};

/// Moves particles by their own forces: `kick` before and after, `drift` between (velocity Verlet).
template <class Real>
class PERIMPM_API ParticleIntegrator : public TransferKernel<Real> {
public:
    ~ParticleIntegrator() override;
    void scatter(TransferBlock<Real>&) const final {}
    void gather(TransferBlock<Real>&) const final {}
    virtual void kick(TransferBlock<Real>& b, const Real gravity[3]) const = 0;
    virtual void drift(TransferBlock<Real>& b) const = 0;
};

extern template class TransferKernel<float>;
extern template class TransferKernel<double>;
extern template class ParticleIntegrator<float>;
extern template class ParticleIntegrator<double>;

}  // namespace perimpm
