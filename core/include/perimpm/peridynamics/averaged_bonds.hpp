#pragma once

#include <vector>

#include "perimpm/math/pseudo_inverse.hpp"
#include "perimpm/model/constitutive_law.hpp"
#include "perimpm/peridynamics/averaged_bond_params.hpp"
#include "perimpm/peridynamics/averaged_forces.hpp"
#include "perimpm/peridynamics/averaged_sweep.hpp"
#include "perimpm/peridynamics/kept_fields.hpp"
#include "perimpm/peridynamics/weights.hpp"

/*! The kernel of the laws of Lyu et al. 2019: bond springs and averaged bonds. Equations (4) to (7) are in the header of
    plugins/constitutive/pd_elastic.cpp. With S = w_pq V_p V_q/|X|^2 and w^ the influence:
      paper        f_p = sum_q 2 mu [S_pq (|Y-_p| - |X|) dir Y-_p + S_qp (|Y-_q| - |X|) dir Y-_q] + springs
      variational  G_p = sum_q 2 mu S_pq (|Y-_p| - |X|) dir Y-_p (x) X,  H_p = G_p K_p^+ / V_p
                   f_p = sum_q w^ V_p V_q (H_p + H_q) X + springs        minus the gradient of (5), since dF- = dA K^+
      springs      sum_q lambda (S_pq + S_qp) (|Y| - |X|) dir Y
    `Flow` makes bonds yield: their permanent strain e_p<p,q> takes e_p |X| off both extensions of p's share. */
namespace perimpm::peridynamics {

/// Bonds that never yield.
struct NoFlow {
    static constexpr bool kMayYield = false;
    struct Fields {
        int strain = -1;
    };
    explicit NoFlow(const Params&, double /*modulus*/, double /*lambda*/) {}
};

template <class Real, class Flow = NoFlow>
class AveragedBonds : public ConstitutiveLaw<Real> {
    using P = Pack<Real>;
    enum class Form { springs, paper, variational };

public:
    explicit AveragedBonds(const Params& p)
        : density_{p.context().density},
          horizon_{horizon_of(p)},
          influence_{p, horizon_},
          moduli_{springs_of(p)},
          form_{moduli_.mu == 0                ? Form::springs
                : p.is("formulation", "paper") ? Form::paper
                                               : Form::variational},
          lattice_{p.context()},
          weights_{surface_of(p), lattice_.sum_of_modulus(), p.context(), influence_.reach(), influence_},
          opening_energy_{peridynamics::opening_energy(influence_.reach(), p.context(), influence_,
                                                       lattice_.sum_of_modulus() * moduli_.sum() / 2)},
          flow_{p, moduli_.sum(), moduli_.lambda} {
        declare_fields(surface_of(p));
    }
    LawNeeds needs() const noexcept override {
        LawNeeds n{.bonds = true,
                   .prepare = form_ != Form::springs || yields(),
                   .reports_stretch = true,
                   .stores_in_bonds = true,
                   .horizon = influence_.reach(),
                   .rounds = 2,
                   .lanes = form_ == Form::paper ? 0 : static_cast<std::uint32_t>(kLanes<Real>),
                   .axial = form_ == Form::variational ? at_.own : -1,
                   .shared = at_.influence,
                   .rows = form_ == Form::variational,
                   .moduli = {moduli_.sum() / lattice_.modulus_of_young(), lattice_.poisson_ratio()},
                   .volumes = influence_.volumes(),
                   .opening_energy = opening_energy_};
        n.particle_state = kept(particle_fields_);
        n.bond_state = kept(bond_fields_);
        n.bond_constants = kept(constants_);
        return n;
    }

    void initialise(Block<Real>& b, std::uint32_t round) const override {
        for (std::uint32_t i = 0; i < b.size && round == 0 && form_ != Form::springs; ++i)
            set_influence(b, i), set_moments(b, i);
        weights_.initialise(b, round, {.normalisation = kNormalisation, .stiffness = at_.stiffness, .own = at_.own});
        if constexpr (Flow::kMayYield)
            if (yields() && round == 1) flow_.initialise(b, flow_fields_);
    }
    void renew(Block<Real>& b) const override {
        for (std::uint32_t i = 0; i < b.size && form_ != Form::springs; ++i)
            if (b.family.damage[i] > 0) set_moments(b, i);
    }

    void prepare(Block<Real>& b) const override {
        if constexpr (Flow::kMayYield)
            if (yields()) flow_.advance(b, flow_fields_);
        if (form_ != Form::springs) average_families(b, at_, moduli_, form_ == Form::paper);
    }

    void evaluate(Block<Real>& b, Real) const override {
        if (form_ == Form::springs) force_of_springs(b, at_, moduli_.lambda);
        if (form_ == Form::paper) force_as_printed(b, at_, moduli_.mu);
        if (form_ == Form::variational) force_of_energy(b, at_);
        if constexpr (Flow::kMayYield)  // apart, so that what has not yielded has the elastic forces bit for bit
            if (yields()) add_yielded(b, at_, moduli_, flow_, flow_fields_, form_ == Form::paper);
    }

    double max_wave_speed(const Block<Real>& b) const override {
        return std::sqrt(moduli_.sum() / density_) * largest_stretch(b);
    }
    StableStep stable_step(const Block<Real>& b) const override {
        return spring_bound(b, b.bond_constants[at_.stiffness], moduli_.sum());
    }

    double energy(const Block<Real>& b) const override {
        double total = 0;
        for (std::uint32_t i = 0; i < b.size; ++i) {
            Real F[9];
            if (form_ != Form::springs) load_mean_deformation(b, i, F);
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                P Y[3];
                bonds.difference(b.family.position, b.family.position + 4 * std::size_t{b.first + i}, Y);
                const P rest = rest_length(b, bonds);
                const P extension = norm(Y) - rest;
                P twice = real(moduli_.lambda) * own_stiffness(b, i, bonds) * extension * extension;
                if (form_ != Form::springs) {
                    P X[3], mean[3];
                    bonds.difference(b.family.reference, b.family.reference + 4 * std::size_t{b.first + i}, X);
                    deform(X, mean, F);
                    const P averaged = norm(mean) - rest;
                    twice += real(2 * moduli_.mu) * bonds.constant(b.bond_constants[at_.own]) * averaged * averaged;
                }
                total += 0.5 * static_cast<double>(reduce(live * twice));  // (5)
            });
        }
        return total;
    }

    /// The terms of (5) at both ends.
    void bond_energy(const Block<Real>& b) const override {
        const P half_lambda = real(0.5 * moduli_.lambda), mu = real(moduli_.mu);
        for (std::uint32_t i = 0; i < b.size; ++i) {
            const std::size_t p = std::size_t{b.first + i};
            Real F[9];
            if (form_ != Form::springs) load_mean_deformation(b, i, F);
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                P Y[3];
                bonds.difference(b.family.position, b.family.position + 4 * p, Y);
                const P rest = rest_length(b, bonds), rest_there = rest_length_there(b, bonds, rest), y = norm(Y);
                P here = half_lambda * (y - rest) * (y - rest),
                  there = half_lambda * (y - rest_there) * (y - rest_there);
                if (form_ != Form::springs) {
                    P X[3], mean[3], mean_there[3], other[9];
                    for (std::size_t c = 0; c < 9; ++c) other[c] = bonds.gather(b.family_state[kMeanDeformation][c]);
                    bonds.difference(b.family.reference, b.family.reference + 4 * p, X);
                    deform(X, mean, F), deform(X, mean_there, other);
                    const P averaged = norm(mean) - rest, averaged_there = norm(mean_there) - rest_there;
                    here += mu * averaged * averaged, there += mu * averaged_there * averaged_there;
                }
                const P own = own_stiffness(b, i, bonds), both = bonds.constant(b.bond_constants[at_.stiffness]);
                store_energy(b, bonds, live * own * here, live * (both - own) * there);
            });
        }
    }

protected:
    bool yields() const {
        if constexpr (Flow::kMayYield) return flow_.active();
        return false;
    }

private:
    static constexpr auto kNormalisation = AveragedState::normalisation, kShapeInverse = AveragedState::shape_inverse,
                          kMoment = AveragedState::moment, kMeanDeformation = AveragedState::mean_deformation;
    static constexpr double kSingular = 1e-4;  // eigenvalues of K below this share of the largest count as zero

    static P real(double value) { return P(static_cast<Real>(value)); }

    void declare_fields(Surface surface) {
        particle_fields_ = {
            {.name = "normalisation", .unit = "1/m^3", .doc = "5 / sum w^ V; sheets 8/3, strands 1 instead of 5"}};
        constants_ = {{.name = "stiffness", .unit = "m", .doc = "(w_pq + w_qp) V_p V_q / |X|^2; times lambda: N/m"}};
        if (form_ != Form::springs) {
            particle_fields_.push_back(
                {.name = "shape_inverse", .components = 6, .unit = "1/m^5", .doc = "K^+ of (4): xx xy xz yy yz zz"});
            particle_fields_.push_back(
                {.name = "moment", .components = 3, .unit = "m^4", .doc = "sum w^ V X over the live bonds"});
            particle_fields_.push_back({.name = "mean_deformation", .components = 9, .doc = "F- of (4), row-major"});
            particle_fields_.push_back({.name = "known_force",
                                        .components = 3,
                                        .unit = "N",
                                        .doc = "the part of the force that needs no neighbour's F-"});
            particle_fields_.push_back(
                {.name = "extension", .doc = "largest (|Y| - |X|)/|Y| of the bonds, at least 0"});
            particle_fields_.push_back({.name = "record",
                                        .components = 9,
                                        .unit = form_ == Form::paper ? "1" : "N/m^4",
                                        .doc =
                                            "what neighbours that go alone read, side by side: F- (as printed) or V H; "
                                            "not kept where none do",
                                        .packed = kSumRecord});
        }
        if (form_ == Form::variational)
            particle_fields_.push_back(
                {.name = "averaged_stress",
                 .components = 9,
                 .unit = "N/m^7",
                 .doc = "H, the stress of the averaged bonds times K^+, row-major; only on a lattice"});
        const auto add_constant = [&](const FieldSpec& spec) {
            constants_.push_back(spec);
            return static_cast<int>(constants_.size()) - 1;
        };
        if (form_ != Form::springs || weighs_by_bond(surface) || yields())
            at_.own = add_constant({.name = "own_stiffness", .unit = "m", .doc = "w_pq V_p V_q / |X|^2"});
        if (form_ != Form::springs && !influence_.is_constant())
            at_.influence = add_constant({.name = "influence", .doc = "w^(|X|)"});
        if constexpr (Flow::kMayYield)
            if (yields()) {
                flow_fields_ = flow_.declare(at_.own, particle_fields_, bond_fields_);
                at_.strain = flow_fields_.strain, at_.has_yielded = flow_fields_.has_yielded;
            }
    }

    /// |X|, and what the bond has yielded.
    P rest_length(const Block<Real>& b, const BondPack<Real>& bonds) const {
        const P length = bonds.length();
        return at_.strain < 0 ? length : length + length * bonds.load(b.bond_state[at_.strain]);
    }
    /// The same at the bond's other end.
    P rest_length_there(const Block<Real>& b, const BondPack<Real>& bonds, const P& rest) const {
        if constexpr (Flow::kMayYield) {
            const P length = bonds.length();
            if (at_.strain >= 0) return length + length * flow_.at_other_end(b, bonds, flow_fields_);
        }
        return rest;
    }
    P own_stiffness(const Block<Real>& b, std::uint32_t i, const BondPack<Real>& bonds) const {
        if (at_.own >= 0) return bonds.constant(b.bond_constants[at_.own]);
        const Real* factor = b.family_state[kNormalisation][0];
        return bonds.constant(b.bond_constants[at_.stiffness]) * factor[b.first + i] /
               (factor[b.first + i] + bonds.gather(factor));
    }
    static void load_mean_deformation(const Block<Real>& b, std::uint32_t i, Real F[9]) {
        for (std::size_t c = 0; c < 9; ++c) F[c] = b.particle_state[kMeanDeformation][c][i];
    }
    void set_influence(Block<Real>& b, std::uint32_t i) const {
        if (at_.influence < 0) return;
        const std::uint32_t first = b.family.shape[i], count = b.family.row[i + 1] - b.family.row[i];
        for (std::uint32_t k = first; k < first + count; ++k)
            b.bond_constants[at_.influence][k] = static_cast<Real>(influence_(static_cast<double>(b.family.length[k])));
    }
    /// K^+ and the moment of the live bonds.
    void set_moments(Block<Real>& b, std::uint32_t i) const {
        Eigen::Vector3d moment = Eigen::Vector3d::Zero();
        Eigen::Matrix3d K = Eigen::Matrix3d::Zero();
        const Real* own = b.family.reference + 4 * std::size_t{b.first + i};
        for (std::uint32_t slot = b.family.row[i]; slot < b.family.row[i + 1]; ++slot) {
            const Real* other = b.family.reference + 4 * std::size_t{b.family.neighbour[slot]};
            const Eigen::Vector3d X(other[0] - own[0], other[1] - own[1], other[2] - own[2]);
            if (b.family.is_broken(slot)) continue;
            const double w = influence_(static_cast<double>(b.family.length[constant_of(b.family, i, slot)]));
            const Eigen::Vector3d weighted = w * static_cast<double>(other[3]) * X;
            moment += weighted;
            K += weighted * X.transpose();
        }
        const Eigen::Matrix3d pseudo = pseudo_inverse(K, kSingular);
        constexpr int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};
        for (int c = 0; c < 6; ++c)
            b.particle_state[kShapeInverse][c][i] = static_cast<Real>(pseudo(row[c], column[c]));
        for (int c = 0; c < 3; ++c) b.particle_state[kMoment][c][i] = static_cast<Real>(moment[c]);
    }

    double density_, horizon_;
    Influence influence_;
    SpringModuli moduli_;
    Form form_;
    SpringLattice lattice_;
    FamilyWeights<Real> weights_;
    double opening_energy_;
    Flow flow_;
    std::vector<FieldSpec> particle_fields_, bond_fields_, constants_;
    BondFields at_;
    typename Flow::Fields flow_fields_;
};

}  // namespace perimpm::peridynamics
