#pragma once

#include <Eigen/Core>
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

}  // namespace perimpm
