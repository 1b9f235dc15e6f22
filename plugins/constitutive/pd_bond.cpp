/*! Prototype microelastic brittle solid: one central spring per bond (Silling & Askari 2005, doi:10.1016/j.compstruc.2004.11.026).
      (1) f<p,q> = c s dir(Y),  s = (|Y| - |X|)/|X|                  pair force per volume squared [N/m^6]
      (2) c = 18 K / (pi delta^4)                                    their eq. 22, `calibration = "continuum"`
      (3) c = 18 K / sum_q |X| beta V_q                              the same with the discrete family, exact for isotropic strain
      (4) beta = clip((delta - |X|)/h + 1/2, 0, 1)                   share of q's volume inside (Parks et al. 2008)
    Poisson's ratio is 1/4. (3) sums over the full lattice (`surface = "none"`) or over each particle's own family, a pair
    taking the mean of its two constants (`surface = "family"`). */
#include <numbers>

#include "perimpm/math/elasticity.hpp"
#include "perimpm/peridynamics/family.hpp"
#include "perimpm/plugin/plugin.hpp"

namespace {
using namespace perimpm;
using namespace perimpm::peridynamics;

constexpr ParamSpec kParams[] = {
    {.key = "youngs_modulus", .unit = "Pa", .range = above(0), .doc = "Young's modulus, the stiffness in tension"},
    {.key = "horizon", .unit = "spacings", .range = above(1), .default_value = 3.015, .doc = "how far bonds reach"},
    {.key = "calibration",
     .kind = ParamKind::choice,
     .default_text = "lattice",
     .choices = "lattice|continuum",
     .doc = "bond stiffness that meets youngs_modulus on the particles' lattice, or for infinitely many particles"},
    {.key = "surface",
     .kind = ParamKind::choice,
     .default_text = "family",
     .choices = "none|family",
     .doc = "\"family\" stiffens the bonds of particles near a surface for the neighbours they lack; \"none\" leaves "
            "them soft"},
    {.key = "volume_correction",
     .kind = ParamKind::choice,
     .default_text = "none",
     .choices = "none|linear",
     .doc = "\"linear\" counts of neighbours at the rim of the horizon only the share that lies inside"},
};
enum ParticleState { kMicromodulus };
constexpr FieldSpec kParticleState[] = {{.name = "micromodulus", .unit = "N/m^6", .doc = "c of the particle's family"}};
enum BondState { kStiffness };
constexpr FieldSpec kBondState[] = {{.name = "stiffness", .unit = "N/m", .doc = "c beta V_p V_q / |X|"}};
constexpr double kPoissonRatio = 0.25;

template <class Real>
class PdBond final : public ConstitutiveLaw<Real> {
    using P = Pack<Real>;

public:
    explicit PdBond(const Params& p)
        : youngs_modulus_{p["youngs_modulus"]},
          density_{p.context().density},
          spacing_{p.context().particle_spacing},
          horizon_{p["horizon"] * spacing_},
          own_family_{p.is("surface", "family")},
          partial_{p.is("volume_correction", "linear")} {
        const double eighteen_K = 18 * bulk_modulus(youngs_modulus_, kPoissonRatio);
        const bool continuum = p.is("calibration", "continuum");
        if (continuum && p.given("surface") && own_family_)
            throw InvalidParameter(
                "surface", "\"family\" contradicts calibration = \"continuum\", which uses one constant for all");
        own_family_ = own_family_ && !continuum;
        full_c_ =
            eighteen_K / (continuum ? std::numbers::pi * std::pow(horizon_, 4)                                  // (2)
                                    : lattice_sum(horizon_, spacing_, [&](double X) { return X * beta(X); }));  // (3)
    }
    LawNeeds needs() const noexcept override {
        return {.bonds = true,
                .reports_stretch = true,
                .horizon = horizon_,
                .rounds = 2,
                .particle_state = kParticleState,
                .bond_state = kBondState,
                .moduli = {average_modulus(), kPoissonRatio}};
    }

    void initialise(Block<Real>& b, std::uint32_t round) const override {
        for (std::uint32_t i = 0; i < b.size; ++i) round == 0 ? set_micromodulus(b, i) : set_stiffness(b, i);
    }

    void evaluate(Block<Real>& b, Real) const override {
        const Real* stiffness = b.bond_state[kStiffness];
        P extension(0);
        for (std::uint32_t i = 0; i < b.size; ++i) {
            const Real* own = b.family.position + 4 * std::size_t{b.first + i};
            P f[3] = {P(0), P(0), P(0)};
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                P Y[3];
                bonds.difference(b.family.position, own, Y);
                const P relative = live * relative_extension(Y, bonds.load(b.family.length));
                const P pull = bonds.load(stiffness) * relative;  // (1)
                extension = larger(extension, relative);
                for (int c = 0; c < 3; ++c) f[c] += pull * Y[c];
            });
            for (int c = 0; c < 3; ++c) b.force[c][i] = reduce(f[c]);
        }
        b.largest_stretch = stretch_of(hmax(extension));
    }

    double max_wave_speed(const Block<Real>& b) const override {
        return std::sqrt(1.2 * youngs_modulus_ / density_) * largest_stretch(b);
    }
    double stable_time_step(const Block<Real>& b) const override {
        return silling_askari_bound(b, b.bond_state[kStiffness], 1.0);
    }

    double energy(const Block<Real>& b) const override {
        double total = 0;
        for (std::uint32_t i = 0; i < b.size; ++i)
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                P Y[3];
                bonds.difference(b.family.position, b.family.position + 4 * std::size_t{b.first + i}, Y);
                const P extension = norm(Y) - bonds.load(b.family.length);
                // a quarter: half the spring energy, half for each of the pair's two entries
                total += 0.25 * static_cast<double>(
                                    reduce(live * bonds.load(b.bond_state[kStiffness]) * extension * extension));
            });
        return total;
    }

private:
    /// Young's modulus of the isotropic average over a full family [Pa].
    double average_modulus() const {
        const double weight = lattice_sum(horizon_, spacing_, [&](double X) { return X * beta(X); });
        return youngs_modulus_ * full_c_ * weight / (18 * bulk_modulus(youngs_modulus_, kPoissonRatio));
    }
    double beta(double X) const {
        return partial_ ? std::clamp((horizon_ - X) / spacing_ + 0.5, 0.0, 1.0) : 1.0;
    }  // (4)

    void set_micromodulus(Block<Real>& b, std::uint32_t i) const {
        double sum = 0;
        for (std::uint32_t slot = b.family.row[i]; slot < b.family.row[i + 1]; ++slot) {
            const double X = static_cast<double>(b.family.length[slot]);
            sum += X * beta(X) * static_cast<double>(b.family.volume[b.family.neighbour[slot]]);
        }
        const double own = sum > 0 ? 18 * bulk_modulus(youngs_modulus_, kPoissonRatio) / sum : 0;
        b.particle_state[kMicromodulus][0][i] = static_cast<Real>(own_family_ ? own : full_c_);
    }
    void set_stiffness(Block<Real>& b, std::uint32_t i) const {
        const Real* c = b.family_state[kMicromodulus][0];
        for (std::uint32_t slot = b.family.row[i]; slot < b.family.row[i + 1]; ++slot) {
            const std::uint32_t j = b.family.neighbour[slot];
            const double X = static_cast<double>(b.family.length[slot]);
            const double mean_c = 0.5 * (static_cast<double>(c[b.first + i]) + static_cast<double>(c[j]));
            b.bond_state[kStiffness][slot] = static_cast<Real>(mean_c * beta(X) * static_cast<double>(b.volume[i]) *
                                                               static_cast<double>(b.family.volume[j]) / X);
        }
    }

    double youngs_modulus_, density_, spacing_, horizon_;
    bool own_family_, partial_;
    double full_c_;
};
}  // namespace

PERIMPM_PLUGIN(ConstitutiveLaw, PdBond, kParams,
               "prototype microelastic peridynamics: one central spring per bond, nu = 1/4")
