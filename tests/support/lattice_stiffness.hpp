#pragma once

#include "perimpm/math/stiffness.hpp"
#include "support/particles.hpp"

using perimpm::isotropic_average;
using perimpm::IsotropicAverage;
using perimpm::Stiffness;
using perimpm::strain_of;

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
    Stiffness C = Stiffness::Zero();
    for (std::uint32_t s = particles.bonds().row[p]; s < particles.bonds().row[p + 1]; ++s) {
        const perimpm::Vec3 X = particles.reference()[particles.bonds().neighbour[s]] - particles.reference()[p];
        const perimpm::Vec3 n = X.normalized();
        Eigen::Matrix<double, 6, 1> nn;
        for (std::size_t i = 0; i < 6; ++i)
            nn[static_cast<int>(i)] = n[perimpm::kVoigt[i][0]] * n[perimpm::kVoigt[i][1]];
        C += weight(X.norm()) * nn * nn.transpose();
    }
    return C;
}
