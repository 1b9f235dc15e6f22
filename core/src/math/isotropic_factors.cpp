#include "perimpm/math/isotropic_factors.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "math/fourth_moment.hpp"

namespace perimpm {

namespace {

class IsotropicFactors {
public:
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
    ///   f = max(kLeastFactor, 1 + m.y),  sum a f m + ridge y = wanted.
    Eigen::VectorXd solve() const {
        Vec y = Vec::Zero();
        for (int step = 0; step < kMostSteps; ++step) {
            const Eigen::VectorXd free = free_factors(y), f = free.cwiseMax(kLeastFactor);
            const Vec slope = m_ * (a_.array() * f.array()).matrix() + ridge_ * y - wanted_;
            if (slope.norm() <= kTolerance * wanted_.norm()) break;
            const Eigen::VectorXd active = (free.array() > kLeastFactor).select(a_, 0);
            Eigen::Matrix<double, 15, 15> curvature = m_ * active.asDiagonal() * m_.transpose();
            curvature.diagonal().array() += ridge_;
            y = descend(y, -curvature.ldlt().solve(slope), slope);
        }
        const Eigen::VectorXd f = free_factors(y).cwiseMax(kLeastFactor);
        return a_.sum() / a_.dot(f) * f;
    }

private:
    using Vec = Eigen::Matrix<double, 15, 1>;
    static constexpr double kFlat = 1e-4;  // of second moments: a family as flat as this is a sheet or a strand
    static constexpr double kRidge = 1e-7, kTolerance = 1e-13, kDescent = 1e-4;
    static constexpr int kMostSteps = 100;

    Eigen::VectorXd free_factors(const Vec& y) const { return (1 + (m_.transpose() * y).array()).matrix(); }
    double dual(const Vec& y) const {
        const Eigen::ArrayXd free = free_factors(y).array(), f = free.max(kLeastFactor);
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

}  // namespace

void isotropic_factors(std::span<const double> directions, std::span<const double> weights, std::span<double> factors) {
    const auto count = static_cast<Eigen::Index>(weights.size());
    const Eigen::Matrix3Xd n = Eigen::Map<const Eigen::Matrix3Xd>(directions.data(), 3, count).colwise().normalized();
    const Eigen::VectorXd a = Eigen::Map<const Eigen::VectorXd>(weights.data(), count);
    Eigen::Map<Eigen::VectorXd>(factors.data(), count) = IsotropicFactors(n, a).solve();
}

}  // namespace perimpm
