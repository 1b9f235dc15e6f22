#pragma once

#include <Eigen/Cholesky>
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

/// Factors f >= kLeast of positive weights a with which sum a f n n n n comes nearest to isotropic in the span of the unit
/// vectors n, sum a kept; among those the least change, sum a (f - 1)^2. Exact wherever such factors exist.
class IsotropicFactors {
public:
    static constexpr double kLeast = 0.1;  ///< negative weights would make the family's energy indefinite

    IsotropicFactors(const Eigen::Matrix3Xd& n, const Eigen::VectorXd& a) : a_{a}, m_(15, n.cols()) {
        const Eigen::Matrix3d second = n * a.asDiagonal() * n.transpose();
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(second);
        Eigen::Index span = 0;
        for (int c = 0; c < 3; ++c) span += axes.eigenvalues()[c] > kFlat * axes.eigenvalues()[2] ? 1 : 0;
        for (Eigen::Index k = 0; k < n.cols(); ++k) m_.col(k) = fourth_moment(n.col(k));
        wanted_ = a.sum() * isotropic_fourth_moment(axes.eigenvectors().rightCols(span));
        ridge_ = kRidge * a.sum();
    }

    /// By Newton's method on the dual problem, convex and piecewise quadratic in 15 multipliers y:
    ///   f = max(kLeast, 1 + m.y),  sum a f m + ridge y = wanted.
    Eigen::VectorXd solve() const {
        Vec y = Vec::Zero();
        for (int step = 0; step < kMostSteps; ++step) {
            const Eigen::VectorXd free = free_factors(y), f = free.cwiseMax(kLeast);
            const Vec slope = m_ * (a_.array() * f.array()).matrix() + ridge_ * y - wanted_;
            if (slope.norm() <= kTolerance * wanted_.norm()) break;
            const Eigen::VectorXd active = (free.array() > kLeast).select(a_, 0);
            Eigen::Matrix<double, 15, 15> curvature = m_ * active.asDiagonal() * m_.transpose();
            curvature.diagonal().array() += ridge_;
            y = descend(y, -curvature.ldlt().solve(slope), slope);
        }
        const Eigen::VectorXd f = free_factors(y).cwiseMax(kLeast);
        return a_.sum() / a_.dot(f) * f;
    }

private:
    using Vec = Eigen::Matrix<double, 15, 1>;
    static constexpr double kFlat = 1e-4;  // of second moments: a family as flat as this is a sheet or a strand
    static constexpr double kRidge = 1e-7, kTolerance = 1e-13, kDescent = 1e-4;
    static constexpr int kMostSteps = 100;

    Eigen::VectorXd free_factors(const Vec& y) const { return (1 + (m_.transpose() * y).array()).matrix(); }
    double dual(const Vec& y) const {
        const Eigen::ArrayXd free = free_factors(y).array(), f = free.max(kLeast);
        return 0.5 * (a_.array() * f * (2 * free - f)).sum() + 0.5 * ridge_ * y.squaredNorm() - wanted_.dot(y);
    }
    /// Halves the step until it descends as its slope promises.
    Vec descend(const Vec& y, const Vec& step, const Vec& slope) const {
        const double start = dual(y), promise = kDescent * slope.dot(step);
        double share = 1;
        while (share > 1e-6 && dual(y + share * step) > start + share * promise) share /= 2;
        return y + share * step;
    }

    const Eigen::VectorXd& a_;
    Eigen::Matrix<double, 15, Eigen::Dynamic> m_;
    Vec wanted_;
    double ridge_;
};

}  // namespace perimpm
