/*! Fluid-implicit-particle (Brackbill & Ruppel 1986; blend as in Stomakhin et al. 2013, step 8).
      (1) m_I v_I = sum_p w_Ip m_p v_p                                  particles to grid
      (2) v_p = b (v_p + sum_I w_Ip (v_I - v_I^n)) + (1 - b) sum_I w_Ip v_I      v_I^n: before forces
    b = 1 keeps all velocity modes, also those the grid cannot see; b = 0 is particle-in-cell. */
#include "perimpm/plugin/plugin.hpp"
#include "perimpm/transfer/bspline_transfer.hpp"

namespace {
using namespace perimpm;

constexpr ParamSpec kParams[] = {
    bspline::kOrder,
    bspline::kDivergence,
    {.key = "blend",
     .range = closed(0, 1),
     .default_value = 0.99,
     .doc = "share of FLIP, which keeps motion; the rest is PIC, which calms it"},
};

struct Scheme {
    static constexpr bool affine = false;
    static constexpr bool increment = true;

    explicit Scheme(const Params& params) : blend(params["blend"]) {}
    template <class T>
    T velocity(const T& v, const T& grid, const T& before) const {
        const auto b = static_cast<Scalar<T>>(blend);
        return b * (v + (grid - before)) + (1 - b) * grid;  // (2)
    }
    double blend;
};

template <class Real>
using Flip = bspline::Transfer<Real, Scheme>;
}  // namespace

PERIMPM_PLUGIN(TransferKernel, Flip, kParams,
               "fluid-implicit-particle, blended with PIC: lively, keeps invisible modes")
