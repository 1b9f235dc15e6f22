/*! Prototype microelastic brittle solid: one central spring per bond (Silling & Askari 2005, doi:10.1016/j.compstruc.2004.11.026).
      (1) f<p,q> = c s dir(Y),  s = (|Y| - |X|)/|X|                  pair force per volume squared [N/m^6]
      (2) c = 18 K / (pi delta^4)                                    their eq. 22, `calibration = "continuum"`
      (3) c = 18 K / sum_q |X| beta V_q                              the same with the discrete family, exact for isotropic strain
      (4) beta = clip((delta - |X|)/h + 1/2, 0, 1)                   share of q's volume inside (Parks et al. 2008), above 0
                                                                    up to |X| = delta + h/2, or delta ("centred")
    Poisson's ratio is 1/4. In d < 3 dimensions, sheets of thickness t and strands of section A, d^2 K_d stands for 9 K, with
    d K_d (1 - (d - 1) nu) = E and nu = 1/(d + 1); c = 2 d^2 K_d / sum_q |X| beta V_q; (2) is 9 E/(pi delta^3 t), 2 E/(A delta^2)
    (SpringLattice in perimpm/peridynamics/family.hpp). (3) sums over the full lattice (`surface = "none"`) or over each particle's own family, a pair
    taking the mean of its two constants (`surface = "family"`); the other ways: perimpm/peridynamics/weights.hpp. */
#include <numbers>

#include "perimpm/math/elasticity.hpp"
#include "perimpm/peridynamics/family_slice.hpp"
#include "perimpm/peridynamics/influence.hpp"
#include "perimpm/peridynamics/weights.hpp"
#include "perimpm/plugin/plugin.hpp"

namespace {
using namespace perimpm;
using namespace perimpm::peridynamics;

constexpr ParamSpec kParams[] = {
    {.key = "youngs_modulus", .unit = "Pa", .range = above(0), .doc = "Young's modulus, the stiffness in tension"},
    horizon_param(),
    horizon_length_param(),
    {.key = "calibration",
     .kind = ParamKind::choice,
     .default_text = "lattice",
     .choices = "lattice|continuum",
     .doc = "bond stiffness that meets youngs_modulus on the particles' lattice, or for infinitely many particles"},
    surface_param("moment"),
    volume_correction_param(),
};
enum ParticleState { kNormalisation };
constexpr FieldSpec kParticleState[] = {
    {.name = "normalisation", .unit = "N/m^6", .doc = "half the micromodulus c of the particle's family"}};
enum BondConstants { kStiffness, kOwn };
constexpr FieldSpec kBondConstants[] = {
    {.name = "stiffness", .unit = "N/m", .doc = "c beta V_p V_q / |X|"},
    {.name = "own_stiffness", .unit = "N/m", .doc = "the particle's share of it; surface \"moment\" and \"ghost\""}};

template <class Real>
class PdBond final : public ConstitutiveLaw<Real> {
    using P = Pack<Real>;

public:
    explicit PdBond(const Params& p)
        : youngs_modulus_{p["youngs_modulus"]},
          density_{p.context().density},
          horizon_{horizon_of(p)},
          springs_{p.context()},
          beta_{p, horizon_},
          surface_{surface_of_bonds(p)},
          weights_{surface_, sum_of_weights(p), p.context(), beta_.reach(), weight()},
          opening_energy_{opening_energy(beta_.reach(), p.context(), weight(), sum_of_weights(p) / 2)} {}
    LawNeeds needs() const noexcept override {
        LawNeeds n{.bonds = true,
                   .reports_stretch = true,
                   .stores_in_bonds = true,
                   .horizon = beta_.reach(),
                   .rounds = 2,
                   .lanes = kLanes<Real>,
                   .particle_state = kParticleState,
                   .bond_constants = kBondConstants,
                   .moduli = {youngs_modulus_, springs_.poisson_ratio()},
                   .volumes = beta_.volumes(),
                   .opening_energy = opening_energy_};
        if (!weighs_by_bond(surface_)) n.bond_constants.size = kOwn;
        return n;
    }

    void initialise(Block<Real>& b, std::uint32_t round) const override {
        weights_.initialise(
            b, round,
            {.normalisation = kNormalisation, .stiffness = kStiffness, .own = weighs_by_bond(surface_) ? kOwn : -1});
    }

    void evaluate(Block<Real>& b, Real) const override {
        P largest(0);
        for_each_family(b, [&](const auto& family) PERIMPM_INLINE_LAMBDA {
            P f[3] = {}, extension(0);
            const auto pull = [&](const auto& bonds, const P&, const P* Y, const Root<P>& y) PERIMPM_INLINE_LAMBDA {
                const P relative = relative_extension(y, bonds.length());
                const P t = bonds.constant(b.bond_constants[kStiffness]) * relative;  // (1)
                extension = larger(extension, relative);
                for (int c = 0; c < 3; ++c) f[c] += t * Y[c];
            };
            family.for_each_length(fetch_only, pull);
            family.write(f, b.force);
            largest = larger(largest, extension);
        });
        b.largest_stretch = stretch_of(hmax(largest));
    }

    double max_wave_speed(const Block<Real>& b) const override {
        return std::sqrt(springs_.modulus_of_young() * youngs_modulus_ / density_) * largest_stretch(b);
    }
    StableStep stable_step(const Block<Real>& b) const override {
        return spring_bound(b, b.bond_constants[kStiffness], 1.0);
    }

    double energy(const Block<Real>& b) const override {
        double total = 0;
        for (std::uint32_t i = 0; i < b.size; ++i)
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                P Y[3];
                bonds.difference(b.family.position, b.family.position + 4 * std::size_t{b.first + i}, Y);
                const P extension = norm(Y) - bonds.length();
                // a quarter: half the spring energy, half for each of the pair's two entries
                total += 0.25 * static_cast<double>(reduce(live * bonds.constant(b.bond_constants[kStiffness]) *
                                                           extension * extension));
            });
        return total;
    }

    /// Both ends hold half of the spring's energy.
    void bond_energy(const Block<Real>& b) const override {
        for (std::uint32_t i = 0; i < b.size; ++i) {
            const Real* own = b.family.position + 4 * std::size_t{b.first + i};
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                P Y[3];
                bonds.difference(b.family.position, own, Y);
                const P extension = norm(Y) - bonds.length();
                const P half =
                    P(Real(0.25)) * live * bonds.constant(b.bond_constants[kStiffness]) * extension * extension;
                store_energy(b, bonds, half, half);
            });
        }
    }

private:
    /// d^2 K_d [Pa].
    double isotropic() const {
        return springs_.d * springs_.d * bulk_modulus(youngs_modulus_, springs_.poisson_ratio(), springs_.d);
    }

    static Surface surface_of_bonds(const Params& p) {
        if (!p.is("calibration", "continuum")) return surface_of(p);
        if (p.given("surface") && surface_of(p) != Surface::none)
            throw InvalidParameter("surface",
                                   "contradicts calibration = \"continuum\", which uses one constant for all");
        return Surface::none;
    }
    FamilyWeights<Real>::Weight weight() const {
        return [beta = beta_](double X) { return X * beta(X); };
    }
    /// Of a family that fills the lattice: d^2 K_d, as in (3), or what (2) makes of it.
    double sum_of_weights(const Params& p) const {
        if (!p.is("calibration", "continuum")) return isotropic();
        constexpr double kIntegral[] = {1, 2 * std::numbers::pi / 3, std::numbers::pi};  // of |X| over the family
        const double continuum =
            kIntegral[p.context().dimension - 1] * p.context().across * std::pow(horizon_, springs_.d + 1);
        return isotropic() * lattice_sum(beta_.reach(), p.context(), weight()) / continuum;
    }

    double youngs_modulus_, density_, horizon_;
    SpringLattice springs_;
    VolumeShare beta_;  ///< (4)
    Surface surface_;
    FamilyWeights<Real> weights_;
    double opening_energy_;
};
}  // namespace

PERIMPM_PLUGIN(ConstitutiveLaw, PdBond, kParams,
               "prototype microelastic peridynamics: one central spring per bond, nu = 1/4 (sheets: 1/3)")
