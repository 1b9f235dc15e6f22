/*! Integral-based elastic law of Lyu, Zhang, Chang, Guo, Zhang 2019, "Integrating Peridynamics with Material Point Method for
    Elastoplastic Material Modeling". Equation numbers are the paper's.
      (4) F- = [sum w^ Y (x) X] K^+,  K = sum w^ X (x) X             integral deformation gradient of the family
          Y- = F- X                                                  averaged bond
      (5) E = sum w (mu (|Y-|/|X| - 1)^2 + lambda/2 (|Y|/|X| - 1)^2)
      (6) T<p,q> = (2 mu w/|X|^2) (|Y-| - |X|) dir Y-  +  (lambda w/|X|^2) (|Y| - |X|) dir Y     force state [N/m^6]
      (7) f_p = V_p sum_q (T<p,q> - T<q,p>) V_q                      force of the particle [N]
          w = 5 w^ / sum_q w^ V_q,  w^ = 1 - |X|/delta (linear, the paper's) or constant, ...     weight [1/m^3]
    Differs from print: (4) has the X that print lost and the pseudo-inverse of K, so that coplanar and collinear families
    work and Y- stays exact inside their span; (7) without m_p and with w once, as dimensions demand; w on the reference
    length. Under homogeneous strain Y- = Y and the law is one spring of stiffness 2 mu + lambda: Poisson's ratio is 1/4 for
    every mu and lambda, and E = 5/6 (2 mu + lambda). mu resists bending, it is not a shear modulus.
    `formulation`: (6) is not the gradient of (5), since dF-/dy is dropped: linear momentum is exact, angular momentum and
    energy are not, under inhomogeneous strain with mu > 0. "variational" (default) is the gradient and conserves all three.
    `surface`: perimpm/peridynamics/weights.hpp, ghost_layer.hpp. The kernel, shared with deviatoric_plastic: averaged_bonds.hpp.
    Defaults by measurement (tests/verification/README.md): moment-exact weights, with which a horizon of 2.2 spacings
    (32 bonds) has the period and the loss of a local law; without them short horizons and linear w^ make E along a
    lattice's axes up to 22 % too large. mu = lambda/10. */
#include "perimpm/peridynamics/averaged_bonds.hpp"
#include "perimpm/plugin/plugin.hpp"

namespace {
template <class Real>
class PdElastic final : public perimpm::peridynamics::AveragedBonds<Real> {
    using perimpm::peridynamics::AveragedBonds<Real>::AveragedBonds;
};
}  // namespace

PERIMPM_PLUGIN(ConstitutiveLaw, PdElastic, perimpm::peridynamics::kAveragedBondParams,
               "peridynamic elasticity of Lyu et al. 2019: bond springs and averaged bonds, nu = 1/4")
