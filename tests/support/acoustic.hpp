#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <functional>

/// Speed of the fastest wave at F along reference direction N, as seen in space [m/s]: with Q_ik = dP_iJ/dF_kL N_J N_L by
/// central differences of P = tau F^-T, rho C^2 is Q's largest eigenvalue and c = C / |F^-T N|. density: of the reference.
inline double fastest_wave(const std::function<Eigen::Matrix3d(const Eigen::Matrix3d&)>& tau, const Eigen::Matrix3d& F,
                           const Eigen::Vector3d& N, double density) {
    constexpr double step = 1e-6;
    const auto P = [&](const Eigen::Matrix3d& at) -> Eigen::Matrix3d { return tau(at) * at.inverse().transpose(); };
    Eigen::Matrix3d Q;
    for (int k = 0; k < 3; ++k) {
        const Eigen::Matrix3d by = step * Eigen::Vector3d::Unit(k) * N.transpose();
        Q.col(k) = (P(F + by) - P(F - by)) * N / (2 * step);
    }
    const double largest = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>((Q + Q.transpose()) / 2).eigenvalues()[2];
    return std::sqrt(largest / density) / (F.inverse().transpose() * N).norm();
}
