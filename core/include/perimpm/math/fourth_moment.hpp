#pragma once

#include <Eigen/Eigenvalues>
#include <cmath>

namespace perimpm {

/// Components of n n n n, each once, scaled so that the inner product of two is (n . m)^4.
inline Eigen::Matrix<double, 15, 1> fourth_moment(const Eigen::Vector3d& n) {
    Eigen::Matrix<double, 15, 1> m;
    constexpr double factorial[5] = {1, 1, 2, 6, 24};
    int at = 0;
    for (int i = 4; i >= 0; --i)
        for (int j = 4 - i; j >= 0; --j) {
            const int k = 4 - i - j;
            m[at++] = std::sqrt(24 / (factorial[i] * factorial[j] * factorial[k])) * std::pow(n[0], i) *
                      std::pow(n[1], j) * std::pow(n[2], k);
        }
    return m;
}

/// Mean of n n n n over the unit sphere of a subspace of dimension d, given an orthonormal basis as columns:
/// (1 1 + 1 1 + 1 1)/(d (d + 2)) with 1 the identity of the subspace. By a quadrature of degree 4 over pairs of axes.
inline Eigen::Matrix<double, 15, 1> isotropic_fourth_moment(const Eigen::Matrix3Xd& basis) {
    const auto d = static_cast<double>(basis.cols());
    Eigen::Matrix<double, 15, 1> m = Eigen::Matrix<double, 15, 1>::Zero();
    for (Eigen::Index a = 0; a < basis.cols(); ++a) {
        m += (4 - d) * fourth_moment(basis.col(a));  // sum of e^4 (4 - d) + 2 (e_a +- e_b)^4/4 over pairs: 3 sym(1 1)
        for (Eigen::Index c = 0; c < a; ++c)
            for (const double sign : {1.0, -1.0}) m += 0.5 * fourth_moment(basis.col(a) + sign * basis.col(c));
    }
    return m / (d * (d + 2));
}

/// Relative changes r of positive weights a, least in sum a r^2, with which sum a (1 + r) n n n n is isotropic in the
/// span of the unit vectors n, sum a kept. `cut`: combinations that the n resolve worse than this share of the best stay
/// as they are, so that edges do not get weights of a hundred times the mean.
inline Eigen::VectorXd isotropic_change(const Eigen::Matrix3Xd& n, const Eigen::VectorXd& a, double cut = 1e-2) {
    constexpr double kSingular = 1e-4;  // of second moments: a family as flat as this is a sheet or a strand
    const Eigen::Matrix3d second = n * a.asDiagonal() * n.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(second);
    Eigen::Index span = 0;
    for (int c = 0; c < 3; ++c) span += axes.eigenvalues()[c] > kSingular * axes.eigenvalues()[2] ? 1 : 0;
    Eigen::Matrix<double, 15, Eigen::Dynamic> m(15, n.cols());
    for (Eigen::Index k = 0; k < n.cols(); ++k) m.col(k) = fourth_moment(n.col(k));
    const Eigen::Matrix<double, 15, 1> missing =
        a.sum() * isotropic_fourth_moment(axes.eigenvectors().rightCols(span)) - m * a;
    const Eigen::Matrix<double, 15, 15> gram = m * a.asDiagonal() * m.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 15, 15>> eigen(gram);
    Eigen::Matrix<double, 15, 1> along = eigen.eigenvectors().transpose() * missing;
    for (int c = 0; c < 15; ++c)
        along[c] = eigen.eigenvalues()[c] > cut * cut * eigen.eigenvalues()[14] ? along[c] / eigen.eigenvalues()[c] : 0;
    const Eigen::VectorXd change = m.transpose() * (eigen.eigenvectors() * along);
    const double kept = a.sum() / (a.sum() + a.dot(change));  // 1 unless combinations were left out
    return (kept * (1 + change.array()) - 1).matrix();
}

}  // namespace perimpm
