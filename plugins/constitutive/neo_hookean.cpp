/*! Compressible Neo-Hookean elasticity (Simo & Pister 1984, doi:10.1016/0045-7825(84)90062-8): the other usual local law,
    whose energy grows without bound as a particle is crushed.
      (1) W = mu/2 (tr b - 3) - mu ln J + lambda/2 (ln J)^2     energy density [Pa], b = F F^T, J = det F
      (2) tau = mu (b - I) + lambda ln J I                      Kirchhoff stress [Pa]
      (3) rho c^2 = mu n.b n + max(0, mu + lambda (1 - ln J))   fastest wave along n, rho of the reference
    Not defined for J <= 0: such a particle ends the run with an error that says where it is. A stable step cannot get there,
    since (1) would need infinite energy. */
#include "perimpm/math/stretch3.hpp"
#include "perimpm/model/inversion.hpp"
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
class NeoHookean final : public ConstitutiveLaw<Real> {
    using P = Pack<Real>;

public:
    explicit NeoHookean(const Params& p) : moduli_{p}, density_{p.context().density} {}
    LawNeeds needs() const noexcept override {
        return {.deformation_gradient = true,
                .may_refuse = true,
                .moduli = {moduli_.youngs_modulus, moduli_.poisson_ratio}};
    }

    void evaluate(Block<Real>& b, Real) const override {
        for_each_pack(b, [&](std::size_t i, std::size_t count, const P FFt[6], const P& J, const Lame<P>& lame) {
            const P pressure = lame.lambda * log(J) - lame.mu;
            for (int c = 0; c < 6; ++c)
                store(b.tau[c] + i, P(lame.mu * FFt[c] + (c == 0 || c == 3 || c == 5 ? pressure : P(0))),
                      count);  // (2)
        });
    }

    double max_wave_speed(const Block<Real>& b) const override {
        P fastest(0);
        for_each_pack(b, [&](std::size_t, std::size_t, const P FFt[6], const P& J, const Lame<P>& lame) {
            // the largest row sum bounds the largest eigenvalue
            const P stretch2 = larger(larger(FFt[0] + abs(FFt[1]) + abs(FFt[2]), abs(FFt[1]) + FFt[3] + abs(FFt[4])),
                                      P(abs(FFt[2]) + abs(FFt[4]) + FFt[5]));
            const P along = lame.mu + lame.lambda * (P(1) - log(J));
            fastest = larger(fastest, P(lame.mu * stretch2 + larger(along, P(0))));  // (3)
        });
        return std::sqrt(static_cast<double>(hmax(fastest)) / density_);
    }

    /// In double, and near rest in H = F - I, where the terms of (1) cancel to second order.
    double energy(const Block<Real>& b) const override {
        double total = 0;
        for (std::size_t i = 0; i < b.size; ++i) {
            Mat3<double> F, H;
            double norm2 = 0;
            for (int c = 0; c < 9; ++c) {
                F.m[c] = static_cast<double>(b.F[c][i]);
                H.m[c] = F.m[c] - (c % 4 == 0);
                norm2 += H.m[c] * H.m[c];
            }
            const double J = determinant(F), trace = H(0, 0) + H(1, 1) + H(2, 2);
            require_upright("neo_hookean", b, i, J);
            const double minors = H(0, 0) * H(1, 1) - H(0, 1) * H(1, 0) + H(1, 1) * H(2, 2) - H(1, 2) * H(2, 1) +
                                  H(2, 2) * H(0, 0) - H(2, 0) * H(0, 2);
            const double log_J = std::abs(J - 1) < 0.5 ? std::log1p(trace + minors + determinant(H)) : std::log(J);
            const Lame<double> lame(
                b.param[kYoungsModulus] ? double(b.param[kYoungsModulus][i]) : moduli_.youngs_modulus,
                moduli_.poisson_ratio);
            const double W = lame.mu * (0.5 * norm2 + trace - log_J) + 0.5 * lame.lambda * log_J * log_J;  // (1)
            total += W * static_cast<double>(b.volume[i]);
        }
        return total;
    }

private:
    /// body(first particle, count, F F^T, det F, Lame's constants).
    template <class Body>
    void for_each_pack(const Block<Real>& b, Body body) const {
        perimpm::for_each_pack(b, moduli_, b.param[kYoungsModulus],
                               [&](std::size_t i, std::size_t count, const Mat3<P>& F, const Lame<P>& lame) {
                                   const P J = determinant(F);
                                   require_upright("neo_hookean", b, i, J);
                                   P FFt[6];
                                   left_cauchy_green(F, FFt);
                                   body(i, count, FFt, J, lame);
                               });
    }

    IsotropicModuli moduli_;
    double density_;
};
}  // namespace

PERIMPM_PLUGIN(ConstitutiveLaw, NeoHookean, kParams,
               "compressible Neo-Hookean elasticity: resists crushing without bound; det F > 0 only")
