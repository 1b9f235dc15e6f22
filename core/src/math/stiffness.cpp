#include "perimpm/math/stiffness.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <numbers>

namespace perimpm {

namespace {
/// Shear components times sqrt(2) make the double contraction a product of vectors (Mandel).
VoigtStrain mandel_scale() {
    VoigtStrain s;
    s << 1, 1, 1, std::numbers::sqrt2, std::numbers::sqrt2, std::numbers::sqrt2;
    return s;
}
}  // namespace

IsotropicAverage isotropic_average(const Stiffness& C, int dimension) {
    const double d = dimension;
    const double A = C.topLeftCorner<3, 3>().sum();                                              // C_iijj
    const double B = C.topLeftCorner<3, 3>().trace() + 2 * C.bottomRightCorner<3, 3>().trace();  // C_ijij
    if (dimension == 1) return {0, A / 2, 1};
    const double scale = d * (d - 1) * (d + 2);
    return {((d + 1) * A - 2 * B) / scale, (d * B - A) / scale, dimension};
}

Eigen::Matrix3Xd resisting_directions(const Stiffness& C) {
    Eigen::Matrix3d stress;
    const VoigtStrain s = C.leftCols<3>().rowwise().sum();
    stress << s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2];
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(stress);
    Eigen::Index count = 0;
    for (int c = 0; c < 3; ++c) count += axes.eigenvalues()[c] > 1e-4 * axes.eigenvalues()[2] ? 1 : 0;
    return axes.eigenvectors().rightCols(count);
}

DirectionalModulus::DirectionalModulus(const Stiffness& C) {
    const Stiffness mandel = mandel_scale().asDiagonal() * C * mandel_scale().asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Stiffness> eigen(mandel);
    modes_ = eigen.eigenvectors(), stiffness_ = eigen.eigenvalues();
    cut_ = 1e-8 * stiffness_[5];
}

double DirectionalModulus::operator()(const Eigen::Vector3d& n) const {
    if (stiffness_[0] < -cut_) return -std::numeric_limits<double>::infinity();
    VoigtStrain strain;
    for (std::size_t c = 0; c < 6; ++c)
        strain[static_cast<int>(c)] = n[kVoigt[c][0]] * n[kVoigt[c][1]] * (c < 3 ? 1 : std::numbers::sqrt2);
    const VoigtStrain along = modes_.transpose() * strain;
    double compliance = 0;
    for (int c = 0; c < 6; ++c) {
        if (stiffness_[c] > cut_)
            compliance += along[c] * along[c] / stiffness_[c];
        else if (along[c] * along[c] > 1e-6)
            return 0;
    }
    return 1 / compliance;
}

std::vector<Eigen::Vector3d> directions_in(const Eigen::Matrix3Xd& basis) {
    std::vector<Eigen::Vector3d> found;
    if (basis.cols() == 1) found.emplace_back(basis.col(0));
    constexpr int kMany = 180;
    for (int k = 0; k < kMany && basis.cols() == 2; ++k) {
        const double angle = k * std::numbers::pi / kMany;
        found.emplace_back(std::cos(angle) * basis.col(0) + std::sin(angle) * basis.col(1));
    }
    for (int k = 0; k < kMany && basis.cols() == 3; ++k) {  // Fibonacci's spiral
        const double z = (k + 0.5) / kMany, angle = k * std::numbers::pi * (3 - std::sqrt(5.0)),
                     r = std::sqrt(1 - z * z);
        found.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    }
    for (int i = 0; i < 27 && basis.cols() == 3; ++i)
        if (const Eigen::Vector3d n(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1); i > 13) found.push_back(n.normalized());
    return found;
}

}  // namespace perimpm
