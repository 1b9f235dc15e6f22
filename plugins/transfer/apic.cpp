/*! Affine particle-in-cell (Jiang, Schroeder, Selle, Teran, Stomakhin 2015, doi:10.1145/2766996).
      (1) m_I v_I = sum_p w_Ip m_p (v_p + C_p (x_I - x_p))         particles to grid, their eq. 8
      (2) v_p = sum_I w_Ip v_I                                     grid to particles
      (3) C_p = B_p D^-1,  B_p = sum_I w_Ip v_I (x_I - x_p)^T,  D = dx^2/4 (quadratic), dx^2/3 (cubic)   their eq. 9-10
          linear splines, whose D is singular at nodes: particles carry B_p, and w_Ip C_p (x_I - x_p) is B_p grad w_Ip
    Conserves linear and angular momentum. */
#include "perimpm/plugin/plugin.hpp"
#include "perimpm/transfer/bspline_transfer.hpp"

namespace {
using namespace perimpm;

constexpr ParamSpec kParams[] = {bspline::kOrder, bspline::kDivergence};

struct Scheme {
    static constexpr bool affine = true;  // (1), (3)
    static constexpr bool increment = false;

    explicit Scheme(const Params&) {}
    template <class T>
    T velocity(const T&, const T& grid, const T&) const {
        return grid;
    }  // (2)
};

template <class Real>
using Apic = bspline::Transfer<Real, Scheme>;
}  // namespace

PERIMPM_PLUGIN(TransferKernel, Apic, kParams, "affine particle-in-cell: conserves linear and angular momentum")
