#pragma once

#include <Eigen/Core>
#include <cmath>

namespace perimpm {

/// Components of n n n n, each once, scaled so that the inner product of two is (n . m)^4.
inline Eigen::Matrix<double, 15, 1> fourth_moment(const Eigen::Vector3d& n) {
    const double x = n[0], y = n[1], z = n[2], xx = x * x, yy = y * y, zz = z * z;
    const double six = std::sqrt(6.0), twelve = std::sqrt(12.0);  // roots of multiplicities, as 2 is of 4
    Eigen::Matrix<double, 15, 1> m;
    m << xx * xx, 2 * xx * x * y, 2 * xx * x * z, six * xx * yy, twelve * xx * y * z, six * xx * zz, 2 * x * yy * y,
        twelve * x * yy * z, twelve * x * y * zz, 2 * x * zz * z, yy * yy, 2 * yy * y * z, six * yy * zz,
        2 * y * zz * z, zz * zz;
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
