#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "perimpm/export.hpp"

/*! Small-strain stiffness tensors C_ijkl as matrices over the strains 11 22 33 23 31 12, shear in engineering measure (Voigt). */
namespace perimpm {

using Stiffness = Eigen::Matrix<double, 6, 6>;  ///< [Pa]
using VoigtStrain = Eigen::Matrix<double, 6, 1>;

inline constexpr std::array<std::array<int, 2>, 6> kVoigt = {{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {2, 0}, {0, 1}}};

inline Eigen::Matrix3d strain_of(const VoigtStrain& e) {
    Eigen::Matrix3d m;
    m << e[0], e[5] / 2, e[4] / 2, e[5] / 2, e[1], e[3] / 2, e[4] / 2, e[3] / 2, e[2];
    return m;
}

/// The isotropic stiffness C_ijij and C_iijj of which are those of C: the average over all directions (Voigt; Hill 1952).
/// In d dimensions C_iijj = d^2 lambda + 2 d mu and C_ijij = d lambda + d (d + 1) mu; a sheet's are those of plane stress.
struct IsotropicAverage {
    double lambda, mu;
    int dimension = 3;

    double poisson_ratio() const { return lambda / ((dimension - 1) * lambda + 2 * mu); }
    double youngs_modulus() const { return 2 * mu * (1 + poisson_ratio()); }
    double bulk_modulus() const { return lambda + 2 * mu / dimension; }
    double longitudinal_modulus() const { return lambda + 2 * mu; }  ///< of uniaxial strain
};
PERIMPM_API IsotropicAverage isotropic_average(const Stiffness& C, int dimension = 3);

/// Orthonormal basis, as columns, of the directions in which C resists: all three, a sheet's two, a strand's one. From the
/// stresses C_ijkk of uniform expansion, directions below 1e-4 of the stiffest left out.
PERIMPM_API Eigen::Matrix3Xd resisting_directions(const Stiffness& C);

/// Stress over strain of a bar along a direction: E(n) = 1/(n n : C^-1 : n n). 0 where a mechanism yields without
/// resistance, minus infinity when C is not positive: such a body has no rest.
class PERIMPM_API DirectionalModulus {
public:
    explicit DirectionalModulus(const Stiffness& C);
    double operator()(const Eigen::Vector3d& n) const;

private:
    Stiffness modes_;
    VoigtStrain stiffness_;
    double cut_;
};

/// Directions to look in, half a turn of them, in the span of an orthonormal basis: evenly spread, for solids also along the
/// edges and diagonals of a cubic lattice, where its extremes are.
PERIMPM_API std::vector<Eigen::Vector3d> directions_in(const Eigen::Matrix3Xd& basis);

}  // namespace perimpm
