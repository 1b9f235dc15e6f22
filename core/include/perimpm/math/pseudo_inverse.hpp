#pragma once

#include <Eigen/Eigenvalues>

namespace perimpm {

/// Moore-Penrose inverse of a symmetric positive semidefinite 3x3 matrix: eigenvalues below `cut` of the largest count
/// as zero.
inline Eigen::Matrix3d pseudo_inverse(const Eigen::Matrix3d& symmetric, double cut) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(symmetric);
    const Eigen::Vector3d k = eigen.eigenvalues();  // ascending
    Eigen::Vector3d inverse;
    for (int c = 0; c < 3; ++c) inverse[c] = k[c] > cut * k[2] ? 1 / k[c] : 0;
    return eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

}  // namespace perimpm
