#pragma once

#include <array>

#include "support/particles.hpp"

/// Small-strain stiffness of one particle, in Voigt order 11 22 33 23 31 12 (engineering shear).
using Stiffness = Eigen::Matrix<double, 6, 6>;

inline Eigen::Matrix3d strain_of(const Eigen::Matrix<double, 6, 1>& e) {
    Eigen::Matrix3d m;
    m << e[0], e[5] / 2, e[4] / 2, e[5] / 2, e[1], e[3] / 2, e[4] / 2, e[3] / 2, e[2];
    return m;
}

/// From the energies of particle p under affine strains of +-1e-6, so that terms of odd order cancel [Pa].
inline Stiffness measure_stiffness(Particles<double>& particles, std::size_t p, double volume) {
    constexpr double size = 1e-6;
    const auto energy = [&](const Eigen::Matrix<double, 6, 1>& e) {
        double sum = 0;
        for (const double sign : {1.0, -1.0}) {
            particles.deform(Eigen::Matrix3d::Identity() + sign * size * strain_of(e));
            sum += particles.energy(p, 1) / 2;
        }
        return sum / (size * size * volume);
    };
    const Eigen::Matrix<double, 6, 6> unit = Eigen::Matrix<double, 6, 6>::Identity();
    Stiffness C;
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j <= i; ++j) {
            const double both = energy(unit.col(i) + unit.col(j));
            C(i, j) = C(j, i) = i == j ? both / 2 : both - energy(unit.col(i)) - energy(unit.col(j));
        }
    return C;
}

/// sum over the particle's family of weight(|X|) n n n n, n = X/|X|: the stiffness of central springs.
template <class Weight>
Stiffness lattice_stiffness(const Particles<double>& particles, std::size_t p, Weight weight) {
    constexpr std::array<std::array<int, 2>, 6> pair = {{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {2, 0}, {0, 1}}};
    Stiffness C = Stiffness::Zero();
    for (std::uint32_t s = particles.bonds().row[p]; s < particles.bonds().row[p + 1]; ++s) {
        const perimpm::Vec3 X = particles.reference()[particles.bonds().neighbour[s]] - particles.reference()[p];
        const perimpm::Vec3 n = X.normalized();
        Eigen::Matrix<double, 6, 1> nn;
        for (std::size_t i = 0; i < 6; ++i) nn[static_cast<int>(i)] = n[pair[i][0]] * n[pair[i][1]];
        C += weight(X.norm()) * nn * nn.transpose();
    }
    return C;
}

/// Isotropic (Voigt) average over all directions: 15 lambda = C_iijj + 2 (C_iijj - C_ijij) ..., Hill 1952.
struct IsotropicAverage {
    double lambda, mu;
    double youngs_modulus() const { return mu * (3 * lambda + 2 * mu) / (lambda + mu); }
    double poisson_ratio() const { return lambda / (2 * (lambda + mu)); }
    double bulk_modulus() const { return lambda + 2 * mu / 3; }
};
inline IsotropicAverage isotropic_average(const Stiffness& C) {
    const double A = C.topLeftCorner<3, 3>().sum();                                              // C_iijj
    const double B = C.topLeftCorner<3, 3>().trace() + 2 * C.bottomRightCorner<3, 3>().trace();  // C_ijij
    return {(2 * A - B) / 15, (3 * B - A) / 30};
}
