/*! Particle-in-cell (Harlow 1964; notation of Jiang et al. 2016, section 10.1).
      (1) m_I v_I = sum_p w_Ip m_p v_p       particles to grid
      (2) v_p = sum_I w_Ip v_I               grid to particles
    Very stable and very dissipative: rotation and waves die out within a few cells per period. */
#include "perimpm/plugin/plugin.hpp"
#include "perimpm/transfer/bspline_transfer.hpp"

namespace {
using namespace perimpm;

constexpr ParamSpec kParams[] = {bspline::kOrder, bspline::kDivergence};

struct Scheme {
    static constexpr bool affine = false;
    static constexpr bool increment = false;

    explicit Scheme(const Params&) {}
    template <class T>
    T velocity(const T&, const T& grid, const T&) const {
        return grid;
    }  // (2)
};

template <class Real>
using Pic = bspline::Transfer<Real, Scheme>;
}  // namespace

PERIMPM_PLUGIN(TransferKernel, Pic, kParams, "particle-in-cell: stable, strongly dissipative")
