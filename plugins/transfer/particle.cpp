/*! No grid: bond forces move the particles directly, by velocity Verlet (Swope et al. 1982), as peridynamics codes do.
      (1) v += dt/2 (f/m + g)      kick, before and after the forces are computed anew
      (2) x += dt v                drift
    Bodies do not feel each other; colliders act on the particles. */
#include "perimpm/plugin/plugin.hpp"

namespace {
using namespace perimpm;

template <class Real>
class Particle final : public ParticleIntegrator<Real> {
public:
    explicit Particle(const Params&) {}
    TransferNeeds needs() const noexcept override { return {.grid = false}; }
    void kick(TransferBlock<Real>& b, const Real gravity[3]) const override {
        const Real half = b.dt / 2;
        for (int c = 0; c < 3; ++c)
            for (std::size_t p = 0; p < b.size; ++p)
                b.v[c][p] += half * (b.force[c][p] / b.mass[p] + gravity[c]);  // (1)
    }
    void drift(TransferBlock<Real>& b) const override {
        for (int c = 0; c < 3; ++c)
            for (std::size_t p = 0; p < b.size; ++p) b.x[c][p] += b.dt * b.v[c][p];  // (2)
    }
};
}  // namespace

PERIMPM_PLUGIN_WITHOUT_PARAMS(TransferKernel, Particle,
                              "no grid: particles move by their own bond forces, velocity Verlet")
