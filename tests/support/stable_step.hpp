#pragma once

#include <Eigen/Eigenvalues>
#include <cmath>

#include "support/catch.hpp"
#include "support/particles.hpp"

/// 2/omega of the largest frequency of equal particles, which are at F X, by the forces' central differences [s].
inline double largest_stable_step(Particles<double>& particles, const Eigen::Matrix3d& F) {
    const auto size = static_cast<Eigen::Index>(3 * particles.size());
    const perimpm::Block<double> block = particles.block();
    const double step = 1e-6 * std::cbrt(block.volume[0]);
    Eigen::MatrixXd K(size, size);
    for (Eigen::Index j = 0; j < size; ++j) {
        const auto p = static_cast<std::size_t>(j / 3);
        const perimpm::Vec3 at = F * particles.reference()[p];
        for (const double sign : {1.0, -1.0}) {
            particles.place(p, at + sign * step * perimpm::Vec3::Unit(j % 3));
            particles.evaluate();
            for (Eigen::Index i = 0; i < size; ++i) {
                const double share = -sign * particles.force(static_cast<std::size_t>(i / 3))[i % 3] / (2 * step);
                K(i, j) = sign > 0 ? share : K(i, j) + share;
            }
        }
        particles.place(p, at);
    }
    CHECK((K - K.transpose()).norm() <= 1e-5 * K.norm());
    const Eigen::MatrixXd symmetric = (K + K.transpose()) / 2;
    const double largest =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
    return 2 / std::sqrt(largest / block.mass[0]);
}
