/*! Linear peridynamic solid (Silling, Epton, Weckner, Xu, Askari 2007, doi:10.1007/s10659-007-9125-1, section 15): ordinary
    state-based, any Poisson's ratio. x = |X|, e = |Y| - |X|, w the influence function.
      (1) m = sum_q w x^2 V_q                                        weighted volume [m^5]
      (2) theta = (3/m) sum_q w x e V_q                              dilatation
      (3) W = K theta^2/2 + (15 mu / 2 m) sum_q w (e - theta x/3)^2 V_q              energy density [Pa]
      (4) t<p,q> = (3 K theta/m) w x + (15 mu/m) w (e - theta x/3)   force state [N/m^6], along dir(Y)
      (5) f_p = V_p sum_q (t<p,q> + t<q,p>) V_q dir(Y)               force of the particle [N]
      (6) w takes the factor clip((delta - x)/h + 1/2, 0, 1): share of q's cell inside (`volume_correction`)
    With S<p,q> = V_p V_q w/m, (4) is V_p V_q t<p,q> = 15 mu S<p,q> (e + pi_p x), pi = (3 K - 5 mu (2 - s)) theta / (15 mu),
    s = sum_q w x^2 V_q / m over the live bonds. s = 1 in print. With s, forces remain the gradient of (3) where bonds
    broke or where m is that of the full lattice (`surface = "none"`). Bonds that break do not change m (as in Peridigm):
    a family that loses bonds softens.
    In d < 3 dimensions (sheets in plane stress, strands) d stands for 3, d (d + 2) for 15 and K_d = E/(d (1 - (d - 1) nu)) for K:
    theta = (d/m) sum w x e V, W = K_d theta^2/2 + (d (d + 2) mu/2 m) sum w (e - theta x/d)^2 V, hence
    pi_p = (K_d/((d + 2) mu) - (2 - s)/d) theta; sheets as in Le, Chan & Schwartz 2014, doi:10.1002/nme.4642. In a strand
    Poisson's ratio has no meaning; mu = E/3 makes it one spring per bond.
    `surface = "moment"` makes sum w x^2 V n n n n of each family isotropic, so that (3) has K and mu for any affine strain.
      (7) w<p,q> = V_p V_q (t<p,q> e - (15 mu w/m) (e - 2 theta x/3 - e_p x) e_p x)/2    energy at p's end of a bond [J]
    (7) is half the force state times the extension, as Foster, Silling & Chen 2011, doi:10.1615/IntJMultCompEng.2011002407,
    sum it over a proportional load, less what yielded bonds do not give back; over a family it sums to V_p W, since (3) is
    quadratic. A bond that shortens in a family that grows stores less than nothing.
    With `yield_stress` bonds yield in shear (Mitchell 2011, SAND2011-3166): t loses 15 mu S e_p x, and (3) has
    e - theta x/3 - e_p x. The rules are in perimpm/peridynamics/bond_flow.hpp; his psi_0 = 25 sigma_y^2/(8 pi delta^5), for full
    continuum families of constant w, can be given as `yield_psi`. */
#include "perimpm/math/elasticity.hpp"
#include "perimpm/peridynamics/bond_flow.hpp"
#include "perimpm/peridynamics/family_slice.hpp"
#include "perimpm/peridynamics/influence.hpp"
#include "perimpm/peridynamics/kept_fields.hpp"
#include "perimpm/peridynamics/weights.hpp"
#include "perimpm/plugin/plugin.hpp"

namespace {
using namespace perimpm;
using namespace perimpm::peridynamics;

constexpr ParamSpec kParams[] = {
    {.key = "youngs_modulus", .unit = "Pa", .range = above(0), .doc = "Young's modulus, the stiffness in tension"},
    {.key = "poisson_ratio",
     .range = open(-1, 0.5),
     .default_value = 0.25,
     .doc = "Poisson's ratio: how much a stretched bar thins; 0.5 would keep its volume"},
    horizon_param(),
    horizon_length_param(),
    influence_param(),
    surface_param("moment"),
    volume_correction_param(),
    yield_stress_param(),
    {.key = "yield_psi",
     .unit = "N^2/m^9",
     .range = at_least(0),
     .optional = true,
     .doc = "half the squared norm of the deviatoric force state at which it yields, instead of yield_stress"},
    yield_rule_param("family"),
    hardening_param(),
};
enum ParticleState { kNormalisation, kDilatation, kPressure, kRecord };
constexpr FieldSpec kParticleState[] = {
    {.name = "normalisation", .unit = "1/m^5", .doc = "1/m of (1)"},
    {.name = "dilatation", .doc = "theta of (2), the relative change of volume"},
    {.name = "pressure_state", .doc = "pi of the header comment"},
    {.name = "pressure_record", .doc = "pi again, and y beside it: one load per neighbour", .packed = 4},
};
enum BondConstants { kStiffness, kOwn };
constexpr FieldSpec kBondConstants[] = {
    {.name = "stiffness", .unit = "m", .doc = "S<p,q> + S<q,p>; times 15 mu: N/m"},
    {.name = "own_stiffness", .unit = "m", .doc = "S<p,q> = V_p V_q w/m"},
};
constexpr WeightFields kWeights{.normalisation = kNormalisation, .stiffness = kStiffness, .own = kOwn};

template <class Real>
class PdLps final : public ConstitutiveLaw<Real> {
    using P = Pack<Real>;

public:
    explicit PdLps(const Params& p)
        : youngs_modulus_{p["youngs_modulus"]},
          poisson_ratio_{poisson_ratio_of(p)},
          d_{static_cast<double>(p.context().dimension)},
          bulk_{bulk_modulus(youngs_modulus_, poisson_ratio_, d_)},
          shear_{youngs_modulus_ / (2 * (1 + poisson_ratio_))},
          density_{p.context().density},
          influence_{p, horizon_of(p)},
          weights_{weights_of(p)},
          opening_energy_{
              peridynamics::opening_energy(influence_.reach(), p.context(), moment(), deviatoric() / 2,
                                           (d_ * d_ * bulk_ - deviatoric()) / 2)},  // (3) of r stretched bonds
          flow_{p, deviatoric(), 3 * shear_, 1.0, "yield_psi"},
          particle_fields_(std::begin(kParticleState), std::end(kParticleState)) {
        if (flow_.active()) flow_fields_ = flow_.declare(kOwn, particle_fields_, bond_fields_, kDilatation);
    }
    LawNeeds needs() const noexcept override {
        return {.bonds = true,
                .prepare = true,
                .reports_stretch = true,
                .stores_in_bonds = true,
                .horizon = influence_.reach(),
                .rounds = 2,
                .lanes = kLanes<Real>,
                .particle_state = kept(particle_fields_),
                .bond_state = kept(bond_fields_),
                .bond_constants = kBondConstants,
                .moduli = {youngs_modulus_, poisson_ratio_},
                .volumes = influence_.volumes(),
                .opening_energy = opening_energy_};
    }

    void initialise(Block<Real>& b, std::uint32_t round) const override {
        weights_.initialise(b, round, kWeights);
        if (flow_.active() && round == 1) flow_.initialise(b, flow_fields_);
    }

    void prepare(Block<Real>& b) const override {
        Real* dilatation = b.particle_state[kDilatation][0];
        for_each_family(b, [&](const auto& family) PERIMPM_INLINE_LAMBDA {
            P expansion(0), whole(0);
            const auto expand = [&](const auto& bonds, const P& live, const P*, const Root<P>& y)
                                    PERIMPM_INLINE_LAMBDA {
                                        const P x = bonds.length();
                                        const P moment = live * bonds.constant(b.bond_constants[kOwn]) * x;
                                        expansion += moment * (y.root - x);
                                        whole += moment * x;
                                    };
            family.for_each_length(fetch_only, expand);
            using T = decltype(family.total(whole));  // a number, or one in each lane
            const T theta = T(static_cast<Real>(d_)) * family.total(expansion) / family.at(b.volume);  // (2)
            const T s = family.total(whole) / family.at(b.volume);
            const T pressure = theta * T(static_cast<Real>(bulk_ / ((d_ + 2) * shear_) - 2 / d_)) +
                               theta * s / T(static_cast<Real>(d_));
            const T record[4] = {pressure, family.at(b.x[0]), family.at(b.x[1]), family.at(b.x[2])};
            family.put(dilatation, theta);
            family.put(b.particle_state[kPressure][0], pressure);
            family.put_quad(b.particle_state[kRecord].data, record);
            if (flow_.active()) flow_.yield(b, family, flow_fields_);
        });
    }

    void evaluate(Block<Real>& b, Real) const override {
        P largest(0);
        for (std::uint32_t i = 0; i < b.size;) {
            if (FamilySlice<Real>::begins_at(b, i)) {
                const FamilySlice<Real> slice(b, i);
                if (!flow_.active() || flow_.is_elastic(b, slice, flow_fields_)) {
                    pull<false>(b, slice, largest);
                    i += FamilySlice<Real>::kSize;
                    continue;
                }
            }
            const OneFamily<Real> family(b, i++);
            flow_.active() ? pull<true>(b, family, largest) : pull<false>(b, family, largest);
        }
        b.largest_stretch = stretch_of(hmax(largest));
    }

    double max_wave_speed(const Block<Real>& b) const override {
        return std::sqrt((bulk_ + 2 * (d_ - 1) * shear_ / d_) / density_) * largest_stretch(b);
    }
    /// By Cauchy's inequality (3) is at most the energy of springs d^2 K S (d (d + 2) mu S where that is more) of the families.
    StableStep stable_step(const Block<Real>& b) const override {
        return spring_bound(b, b.bond_constants[kStiffness], std::max(d_ * d_ * bulk_, deviatoric()));
    }

    double energy(const Block<Real>& b) const override {
        double total = 0;
        for (std::uint32_t i = 0; i < b.size; ++i) {
            const double theta = static_cast<double>(b.particle_state[kDilatation][0][i]);
            double shape = 0;
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                P Y[3];
                bonds.difference(b.family.position, b.family.position + 4 * std::size_t{b.first + i}, Y);
                const P x = bonds.length();
                P deviatoric = norm(Y) - x - P(static_cast<Real>(theta / d_)) * x;
                if (flow_.active()) deviatoric -= x * bonds.load(b.bond_state[flow_fields_.strain]);
                shape += static_cast<double>(
                    reduce(live * bonds.constant(b.bond_constants[kOwn]) * deviatoric * deviatoric));
            });
            total +=
                0.5 * bulk_ * static_cast<double>(b.volume[i]) * theta * theta + 0.5 * deviatoric() * shape;  // (3)
        }
        return total;
    }

    void bond_energy(const Block<Real>& b) const override { flow_.active() ? store_as<true>(b) : store_as<false>(b); }

private:
    /// (7)
    template <bool Yields>
    void store_as(const Block<Real>& b) const {
        const P half(static_cast<Real>(0.5 * deviatoric())), per_dimension(static_cast<Real>(1 / d_));
        for (std::uint32_t i = 0; i < b.size; ++i) {
            const Real* record = b.particle_state[kRecord].data + 4 * std::size_t{i};
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                P other[4], Y[3];
                bonds.template gather_packed<4>(b.family_state[kRecord].data, other);
                for (int c = 0; c < 3; ++c) Y[c] = other[1 + c] - record[1 + c];
                const P x = bonds.length(), both = bonds.constant(b.bond_constants[kStiffness]),
                        own = bonds.constant(b.bond_constants[kOwn]), e = norm(Y) - x;
                P here = (e + x * record[0]) * e, there = (e + x * other[0]) * e;
                if constexpr (Yields) {
                    const auto less = [&](const P& yielded, const P& theta) {
                        return yielded * (P(Real(2)) * (e - theta * x * per_dimension) - yielded);
                    };
                    const Field<Real>& theta = b.family_state[kDilatation];
                    here -= less(x * bonds.load(b.bond_state[flow_fields_.strain]), P(theta[0][b.first + i]));
                    there -= less(x * flow_.at_other_end(b, bonds, flow_fields_), bonds.gather(theta[0]));
                }
                store_energy(b, bonds, live * half * own * here, live * half * (both - own) * there);
            });
        }
    }

    /// Forces of a family or a slice; `largest`: of the relative extensions.
    template <bool Yields, class Family>
    void pull(Block<Real>& b, const Family& family, P& largest) const {
        const P stiffness(static_cast<Real>(deviatoric()));
        P f[3] = {}, extension(0);
        const P pressure(family.at(b.particle_state[kPressure][0]));
        const P own_y[3] = {P(family.at(b.x[0])), P(family.at(b.x[1])), P(family.at(b.x[2]))};
        family.for_each_bond([&](const auto& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P other[4], Y[3];
            neighbour(b, bonds, other);
            for (int c = 0; c < 3; ++c) Y[c] = other[1 + c] - own_y[c];
            const P x = bonds.length(), both = bonds.constant(b.bond_constants[kStiffness]),
                    own = bonds.constant(b.bond_constants[kOwn]);
            const Root<P> y = length_of(Y);
            const P e = y.root - x;
            P t = both * e + x * (own * pressure + (both - own) * other[0]);  // (4), both directions
            if constexpr (Yields)
                t -= x * (own * bonds.load(b.bond_state[flow_fields_.strain]) +
                          (both - own) * flow_.at_other_end(b, bonds, flow_fields_));
            const P pull = live * stiffness * t * y.inverse;
            extension = larger(extension, P(live * e * y.inverse));
            for (int c = 0; c < 3; ++c) f[c] += pull * Y[c];  // (5)
        });
        family.write(f, b.force);
        largest = larger(largest, extension);
    }
    /// pi and y of the neighbours.
    PERIMPM_INLINE static void neighbour(const Block<Real>& b, const BondPack<Real>& bonds, P other[4]) {
        bonds.template gather_packed<4>(b.family_state[kRecord].data, other);
    }
    PERIMPM_INLINE static void neighbour(const Block<Real>& b, const SlicePack<Real>& bonds, P other[4]) {
        other[0] = bonds.gather(b.family_state[kPressure][0]);
        for (std::size_t c = 0; c < 3; ++c) other[1 + c] = bonds.gather(b.family.y[c]);
    }

    static double poisson_ratio_of(const Params& p) {
        if (p.context().dimension > 1) return p["poisson_ratio"];
        if (p.given("poisson_ratio"))
            throw InvalidParameter("poisson_ratio", "has no meaning in a strand, which cannot thin: leave it out");
        return 0.5;  // mu = E/3
    }
    /// 15 mu in solids [Pa].
    double deviatoric() const { return d_ * (d_ + 2) * shear_; }

    FamilyWeights<Real>::Weight moment() const {
        return [w = influence_](double x) { return w(x) * x * x; };
    }
    FamilyWeights<Real> weights_of(const Params& p) const {
        return {surface_of(p), 1.0, p.context(), influence_.reach(), moment()};  // (1): sum w x^2 V / m = 1
    }

    double youngs_modulus_, poisson_ratio_, d_, bulk_, shear_, density_;
    Influence influence_;
    FamilyWeights<Real> weights_;
    double opening_energy_;
    BondFlow flow_;
    std::vector<FieldSpec> particle_fields_, bond_fields_;
    BondFlow::Fields flow_fields_;
};
}  // namespace

PERIMPM_PLUGIN(ConstitutiveLaw, PdLps, kParams,
               "linear peridynamic solid: ordinary state-based elasticity, any Poisson's ratio")
