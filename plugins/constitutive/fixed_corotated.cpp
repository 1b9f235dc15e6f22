/*! Fixed-corotated elasticity (Stomakhin, Howes, Schroeder, Teran 2012, doi:10.2312/SCA/SCA12/025-032): the local baseline
    that the paper compares with (Lyu et al. 2019, eq. 3).
      (1) F = U S V^T, proper rotations, the smallest singular value carries the sign of det F; R = U V^T
      (2) W = mu |F - R|^2 + lambda/2 (J - 1)^2                      energy density [Pa]
      (3) tau = P F^T = 2 mu (b - U S U^T) + lambda J (J - 1) I      Kirchhoff stress [Pa], b = F F^T
    Stress needs no rotation: U S U^T = R F^T is the left stretch of F, from the invariants of b for ordinary F. Where
    stretches nearly cancel or vanish it comes from the singular values: the one-sided Jacobi SVD turns F into B = F V = U S
    with orthogonal columns b_k, and U S U^T = sum_k b_k b_k^T / s_k, where vanishing singular values contribute nothing. */
#include "perimpm/math/stretch3.hpp"
#include "perimpm/math/svd3.hpp"
#include "perimpm/model/isotropic.hpp"
#include "perimpm/plugin/plugin.hpp"

namespace {
using namespace perimpm;

constexpr ParamSpec kParams[] = {
    kYoungsModulusParam,
    kPoissonRatioParam,
};
enum Varying { kYoungsModulus };

template <class Real>
class FixedCorotated final : public ConstitutiveLaw<Real> {
    using P = Pack<Real>;

public:
    explicit FixedCorotated(const Params& p) : moduli_{p}, density_{p.context().density} {}
    LawNeeds needs() const noexcept override {
        return {.deformation_gradient = true, .moduli = {moduli_.youngs_modulus, moduli_.poisson_ratio}};
    }

    void evaluate(Block<Real>& b, Real) const override {
        for_each_pack(b, [&](std::size_t i, std::size_t count, const Mat3<P>& F, const Lame<P>& lame) {
            const P J = determinant(F);
            P FFt[6], V[6];
            left_cauchy_green(F, FFt);
            if (!left_stretch(FFt, J, V)) Svd(F).left_stretch(V);
            const P pressure = lame.lambda * J * (J - 1);
            for (int c = 0; c < 6; ++c)
                store(b.tau[c] + i, P(2 * lame.mu * (FFt[c] - V[c]) + (c == 0 || c == 3 || c == 5 ? pressure : P(0))),
                      count);  // (3)
        });
    }

    /// Longitudinal speed of a principal direction: rho c^2 = 2 mu s^2 + lambda (J^2 + |J (J - 1)|).
    double max_wave_speed(const Block<Real>& b) const override {
        P fastest(0);
        for_each_pack(b, [&](std::size_t, std::size_t, const Mat3<P>& F, const Lame<P>& lame) {
            const Mat3<P> C = transpose(F) * F;
            P stretch2(0);  // largest row sum bounds the largest eigenvalue
            for (int r = 0; r < 3; ++r) {
                const P sum = abs(C(r, 0)) + abs(C(r, 1)) + abs(C(r, 2));
                stretch2 = select(sum > stretch2, sum, stretch2);
            }
            const P J = determinant(F);
            const P modulus = P(2) * lame.mu * stretch2 + lame.lambda * (J * J + abs(J * (J - 1)));
            fastest = select(modulus > fastest, modulus, fastest);
        });
        return std::sqrt(static_cast<double>(hmax(fastest)) / density_);
    }

    double energy(const Block<Real>& b) const override {
        double total = 0;
        for_each_pack(b, [&](std::size_t i, std::size_t count, const Mat3<P>& F, const Lame<P>& lame) {
            const Svd svd(F);
            P strain2 = P(0);
            for (int k = 0; k < 3; ++k) strain2 += (svd.sigma[k] - P(1)) * (svd.sigma[k] - P(1));
            const P W = lame.mu * strain2 + P(Real(0.5)) * lame.lambda * (svd.J - 1) * (svd.J - 1);  // (2)
            for (std::size_t lane = 0; lane < count; ++lane) total += double(W[lane]) * double(b.volume[i + lane]);
        });
        return total;
    }

private:
    /// (1) without the rotations: B = F V, signed singular values, 1/sigma (0 for vanishing ones), J = det F.
    struct Svd {
        Mat3<P> B;
        P sigma[3], inverse[3], J;

        explicit Svd(const Mat3<P>& F) : B{F}, J{determinant(F)} {
            orthogonalise_columns(B);
            for (int k = 0; k < 3; ++k) sigma[k] = sqrt(B(0, k) * B(0, k) + B(1, k) * B(1, k) + B(2, k) * B(2, k));
            const auto inverted = J < P(0);
            const auto first = sigma[0] <= sigma[1] && sigma[0] <= sigma[2];
            const auto second = !first && sigma[1] <= sigma[2];
            sigma[0] = select(inverted && first, -sigma[0], sigma[0]);
            sigma[1] = select(inverted && second, -sigma[1], sigma[1]);
            sigma[2] = select(inverted && !first && !second, -sigma[2], sigma[2]);
            for (int k = 0; k < 3; ++k) {
                const auto vanishing = abs(sigma[k]) <= P(std::numeric_limits<Real>::min());
                inverse[k] = select(vanishing, P(0), P(1) / select(vanishing, P(1), sigma[k]));
            }
        }

        /// U S U^T, components xx xy xz yy yz zz.
        void left_stretch(P V[6]) const {
            int component = 0;
            for (int r = 0; r < 3; ++r)
                for (int c = r; c < 3; ++c, ++component) {
                    V[component] = P(0);
                    for (int k = 0; k < 3; ++k) V[component] += B(r, k) * B(c, k) * inverse[k];
                }
        }
    };

    template <class Body>
    void for_each_pack(const Block<Real>& b, Body body) const {
        perimpm::for_each_pack(b, moduli_, b.param[kYoungsModulus], body);
    }

    IsotropicModuli moduli_;
    double density_;
};
}  // namespace

PERIMPM_PLUGIN(ConstitutiveLaw, FixedCorotated, kParams,
               "fixed-corotated elasticity from the polar decomposition of F (local baseline)")
