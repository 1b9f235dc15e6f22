/*! Metal plasticity: von Mises yield surface (J2), logarithmic strain, isotropic linear hardening (Simo 1992,
    doi:10.1016/0045-7825(92)90123-2; de Souza Neto, Peric, Owen 2008, box 14.3). F is the elastic deformation gradient: what
    flows leaves it, as in Klar et al. 2016 (doi:10.1145/2897824.2925906).
      (1) F F^T = sum_k s_k^2 n_k n_k^T,  eps_k = ln s_k       trial elastic strain [1], spatial directions n_k
      (2) tau_k = 2 mu e_k + K tr(eps),   e = dev eps          Kirchhoff stress [Pa]
      (3) q = sqrt(6) mu |e| <= Y = yield_stress + H alpha     von Mises stress, yield stress [Pa]
      (4) da = (q - Y)/(3 mu + H) when q > Y, else 0           alpha: equivalent plastic strain [1]
      (5) e <- e (1 - 3 mu da/q),  alpha <- alpha + da         radial return, lands on (3) exactly
      (6) F <- sum_k exp(de_k) n_k n_k^T F                     de: change of e in (5); its trace is 0: det F stays
      (7) W = mu |e|^2 + K/2 tr(eps)^2 + H/2 alpha^2           stored energy density [Pa]; yield_stress da becomes heat
      (8) rho c^2 <= lambda + 2 mu + 2 max |tau_k|             elastic waves; rho of the reference
    Until (3) is reached this is Hencky's elasticity, and neither F nor alpha is touched. Energy and wave speed are those of
    the returned state. Not defined for det F <= 0: such a particle ends the run with an error that says where it is. */
#include "perimpm/math/svd3.hpp"
#include "perimpm/model/inversion.hpp"
#include "perimpm/model/isotropic.hpp"
#include "perimpm/plugin/plugin.hpp"

namespace {
using namespace perimpm;

constexpr ParamSpec kParams[] = {
    kYoungsModulusParam,
    kPoissonRatioParam,
    {.key = "yield_stress",
     .unit = "Pa",
     .range = above(0),
     .per_particle = true,
     .doc = "tension at which a bar that never flowed begins to"},
    {.key = "hardening",
     .unit = "Pa",
     .range = at_least(0),
     .default_value = 0.0,
     .doc = "H: how much the yield stress grows per plastic strain; 0: perfect plasticity"},
};
enum Varying { kYoungsModulus, kYieldStress };

constexpr FieldSpec kState[] = {
    {.name = "plastic_strain", .doc = "equivalent plastic strain, accumulated: alpha in (4)"},
};
enum State { kPlasticStrain };

template <class Real>
class VonMises final : public ConstitutiveLaw<Real> {
    using P = Pack<Real>;

public:
    explicit VonMises(const Params& p)
        : moduli_{p}, yield_stress_{p["yield_stress"]}, hardening_{p["hardening"]}, density_{p.context().density} {}
    LawNeeds needs() const noexcept override {
        return {.deformation_gradient = true,
                .flows = true,
                .may_refuse = true,
                .particle_state = kState,
                .moduli = {moduli_.youngs_modulus, moduli_.poisson_ratio}};
    }

    void evaluate(Block<Real>& b, Real) const override {
        for_each_pack(b, [&](std::size_t i, std::size_t count, const Mat3<P>& F, const Return& r) {
            P direction2[3][6];
            r.directions(direction2);
            for (int c = 0; c < 6; ++c) {
                P tau(0);
                for (int k = 0; k < 3; ++k) tau += r.tau[k] * direction2[k][c];
                store(b.tau[c] + i, tau, count);  // (2)
            }
            if (all(r.flow == P(0))) return;
            store(b.particle_state[kPlasticStrain][0] + i, r.alpha, count);
            constexpr int at[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
            P growth[6];  // exp(de) - 1, so that what does not flow keeps its bits
            for (P& g : growth) g = P(0);
            for (int k = 0; k < 3; ++k) {
                const P change = expm1(P(-r.flow * r.deviator[k]));
                for (int c = 0; c < 6; ++c) growth[c] += change * direction2[k][c];
            }
            for (int row = 0; row < 3; ++row)
                for (int column = 0; column < 3; ++column) {
                    P returned = F(row, column);
                    for (int k = 0; k < 3; ++k) returned += growth[at[row][k]] * F(k, column);
                    store(b.F[3 * row + column] + i, returned, count);  // (6)
                }
        });
    }

    double max_wave_speed(const Block<Real>& b) const override {
        P fastest(0);
        for_each_pack(b, [&](std::size_t, std::size_t, const Mat3<P>&, const Return& r) {
            const P stress = larger(larger(abs(r.tau[0]), abs(r.tau[1])), P(abs(r.tau[2])));
            fastest = larger(fastest, P(r.lame.lambda + P(2) * (r.lame.mu + stress)));  // (8)
        });
        return std::sqrt(static_cast<double>(hmax(fastest)) / density_);
    }

    double energy(const Block<Real>& b) const override {
        double total = 0;
        for_each_pack(b, [&](std::size_t i, std::size_t count, const Mat3<P>&, const Return& r) {
            P strain2(0);
            for (int k = 0; k < 3; ++k) strain2 += r.deviator[k] * r.deviator[k];
            const P kept = P(1) - r.flow;
            const P W = r.lame.mu * kept * kept * strain2 + P(Real(0.5)) * r.bulk * r.volumetric * r.volumetric +
                        P(static_cast<Real>(0.5 * hardening_)) * r.alpha * r.alpha;  // (7)
            for (std::size_t lane = 0; lane < count; ++lane) total += double(W[lane]) * double(b.volume[i + lane]);
        });
        return total;
    }

private:
    /// The state after (1) to (5).
    struct Return {
        Lame<P> lame;
        P bulk;                                  ///< K [Pa]
        Mat3<P> B;                               ///< columns s_k n_k
        P stretch2[3], deviator[3], volumetric;  ///< s_k^2, trial e_k, tr(eps)
        P flow;                                  ///< share of e that flows, 3 mu da/q
        P alpha, tau[3];

        Return(const Mat3<P>& F, const Lame<P>& moduli, const P& yield_stress, Real hardening, const P& plastic_strain)
            : lame{moduli}, bulk{moduli.lambda + P(Real(2) / 3) * moduli.mu}, B{F} {
            orthogonalise_columns(B);
            volumetric = P(0);
            for (int k = 0; k < 3; ++k) {
                stretch2[k] = B(0, k) * B(0, k) + B(1, k) * B(1, k) + B(2, k) * B(2, k);
                deviator[k] = P(Real(0.5)) * log(stretch2[k]);
                volumetric += deviator[k];
            }
            P norm2(0);
            for (P& e : deviator) e -= P(Real(1) / 3) * volumetric, norm2 += e * e;
            const P q = lame.mu * sqrt(Real(6) * norm2);
            const P excess = larger(P(q - (yield_stress + hardening * plastic_strain)), P(0));  // (3)
            const P increment = excess / (Real(3) * lame.mu + hardening);                       // (4)
            const auto flows = excess > P(0);
            flow = select(flows, P(Real(3) * lame.mu * increment / select(flows, q, P(1))), P(0));
            alpha = plastic_strain + increment;
            for (int k = 0; k < 3; ++k)
                tau[k] = P(2) * lame.mu * (P(1) - flow) * deviator[k] + bulk * volumetric;  // (5), (2)
        }

        /// n_k n_k^T, components xx xy xz yy yz zz.
        void directions(P out[3][6]) const {
            for (int k = 0; k < 3; ++k) {
                const P inverse2 = P(1) / stretch2[k];
                int component = 0;
                for (int row = 0; row < 3; ++row)
                    for (int column = row; column < 3; ++column)
                        out[k][component++] = inverse2 * B(row, k) * B(column, k);
            }
        }
    };

    /// body(first particle, count, trial F, returned state).
    template <class Body>
    void for_each_pack(const Block<Real>& b, Body body) const {
        const Real *yield = b.param[kYieldStress], *plastic_strain = b.particle_state[kPlasticStrain][0];
        perimpm::for_each_pack(
            b, moduli_, b.param[kYoungsModulus],
            [&](std::size_t i, std::size_t count, const Mat3<P>& F, const Lame<P>& lame) {
                require_upright("von_mises", b, i, determinant(F));
                body(i, count, F,
                     Return(F, lame, yield ? load(yield + i, count, Real(1)) : P(static_cast<Real>(yield_stress_)),
                            static_cast<Real>(hardening_), load(plastic_strain + i, count)));
            });
    }

    IsotropicModuli moduli_;
    double yield_stress_, hardening_, density_;
};
}  // namespace

PERIMPM_PLUGIN(ConstitutiveLaw, VonMises, kParams,
               "metal plasticity: von Mises yield, logarithmic strain, linear hardening; any Poisson's ratio")
