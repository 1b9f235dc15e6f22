#pragma once

#include <vector>

#include "perimpm/math/pseudo_inverse.hpp"
#include "perimpm/model/constitutive_law.hpp"
#include "perimpm/peridynamics/averaged_bond_params.hpp"
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
          weights_{surface_of(p), lattice_.sum_of_modulus(), lattice_sum(influence_.reach(), p.context(), influence_),
                   influence_},
          flow_{p, moduli_.sum(), moduli_.lambda} {
        declare_fields(surface_of(p));
    }
    LawNeeds needs() const noexcept override {
        LawNeeds n{.bonds = true,
                   .prepare = form_ != Form::springs || yields(),
                   .reports_stretch = true,
                   .horizon = influence_.reach(),
                   .rounds = 2,
                   .moduli = {moduli_.sum() / lattice_.modulus_of_young(), lattice_.poisson_ratio()}};
        n.particle_state = kept(particle_fields_);
        n.bond_state = kept(bond_fields_);
        return n;
    }

    void initialise(Block<Real>& b, std::uint32_t round) const override {
        weights_.initialise(b, round, {.normalisation = kNormalisation, .stiffness = kStiffness, .own = own_});
        for (std::uint32_t i = 0; i < b.size && round == 0 && form_ != Form::springs; ++i) set_shape_inverse(b, i);
        if constexpr (Flow::kMayYield)
            if (yields() && round == 1) flow_.initialise(b, flow_fields_);
    }

    void prepare(Block<Real>& b) const override {
        if constexpr (Flow::kMayYield)
            if (yields()) flow_.advance(b, flow_fields_);
        for (std::uint32_t i = 0; i < b.size && form_ != Form::springs; ++i) {
            influence_field_ < 0 ? set_mean_deformation<false>(b, i) : set_mean_deformation<true>(b, i);
            if (form_ == Form::variational)
                yields() ? set_averaged_stress<true>(b, i) : set_averaged_stress<false>(b, i);
        }
    }

    void evaluate(Block<Real>& b, Real) const override {
        if (form_ == Form::springs) evaluate_as<Form::springs, false>(b);
        if (form_ == Form::paper) evaluate_as<Form::paper, false>(b);
        if (form_ == Form::variational)
            influence_field_ < 0 ? evaluate_as<Form::variational, false>(b) : evaluate_as<Form::variational, true>(b);
        if constexpr (Flow::kMayYield)
            if (yields()) add_yielded(b);  // apart, so that what has not yielded has the elastic forces bit for bit
    }

    double max_wave_speed(const Block<Real>& b) const override {
        return std::sqrt(moduli_.sum() / density_) * largest_stretch(b);
    }
    double stable_time_step(const Block<Real>& b) const override {
        return silling_askari_bound(b, b.bond_state[kStiffness], moduli_.sum());
    }

    double energy(const Block<Real>& b) const override {
        double total = 0;
        for (std::uint32_t i = 0; i < b.size; ++i)
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                P Y[3];
                bonds.difference(b.family.position, b.family.position + 4 * std::size_t{b.first + i}, Y);
                const P rest = rest_length(b, bonds);
                const P extension = norm(Y) - rest;
                P twice = real(moduli_.lambda) * extension * extension;
                if (form_ != Form::springs) {
                    P X[3], mean[3];
                    bonds.difference(b.family.reference, b.family.reference + 4 * std::size_t{b.first + i}, X);
                    deform(X, mean, b.particle_state[kMeanDeformation].data + kRecord * i);
                    const P averaged = norm(mean) - rest;
                    twice += real(2 * moduli_.mu) * averaged * averaged;
                }
                total += 0.5 * static_cast<double>(reduce(live * own_stiffness(b, i, bonds) * twice));  // (5)
            });
        return total;
    }

protected:
    bool yields() const {
        if constexpr (Flow::kMayYield) return flow_.active();
        return false;
    }

private:
    enum ParticleState { kNormalisation, kShapeInverse, kMeanDeformation, kAveragedStress };
    enum BondState { kStiffness };
    // What neighbours read of a particle: F- or H, and what else a bond asks for, in one cache line of single precision.
    enum Record { kReference = 9, kPresent = 12, kVolume = 15, kRecord = 16 };
    static constexpr double kSingular = 1e-4;  // eigenvalues of K below this share of the largest count as zero

    static P real(double value) { return P(static_cast<Real>(value)); }

    void declare_fields(Surface surface) {
        particle_fields_ = {
            {.name = "normalisation", .unit = "1/m^3", .doc = "5 / sum w^ V; sheets 8/3, strands 1 instead of 5"}};
        bond_fields_ = {{.name = "stiffness", .unit = "m", .doc = "(w_pq + w_qp) V_p V_q / |X|^2; times lambda: N/m"}};
        if (form_ != Form::springs) {
            particle_fields_.push_back(
                {.name = "shape_inverse", .components = 6, .unit = "1/m^5", .doc = "K^+ of (4): xx xy xz yy yz zz"});
            particle_fields_.push_back(
                {.name = "mean_deformation", .components = 9, .doc = "F- of (4), row-major", .packed = kRecord});
        }
        if (form_ == Form::variational)
            particle_fields_.push_back({.name = "averaged_stress",
                                        .components = 9,
                                        .unit = "N/m^7",
                                        .doc = "H, the stress of the averaged bonds times K^+, row-major",
                                        .packed = kRecord});
        const auto add_bond_field = [&](const FieldSpec& spec) {
            bond_fields_.push_back(spec);
            return static_cast<int>(bond_fields_.size()) - 1;
        };
        if (form_ != Form::springs || surface == Surface::moment || yields())
            own_ = add_bond_field({.name = "own_stiffness", .unit = "m", .doc = "w_pq V_p V_q / |X|^2"});
        if (form_ != Form::springs && !influence_.is_constant())
            influence_field_ = add_bond_field({.name = "influence", .doc = "w^(|X|)"});
        if constexpr (Flow::kMayYield)
            if (yields()) flow_fields_ = flow_.declare(own_, particle_fields_, bond_fields_);
    }

    /// |X|, and what the bond has yielded.
    P rest_length(const Block<Real>& b, const BondPack<Real>& bonds) const {
        const P length = bonds.load(b.family.length);
        if constexpr (Flow::kMayYield)
            if (yields()) return length + length * bonds.load(b.bond_state[flow_fields_.strain]);
        return length;
    }
    P own_stiffness(const Block<Real>& b, std::uint32_t i, const BondPack<Real>& bonds) const {
        if (own_ >= 0) return bonds.load(b.bond_state[own_]);
        const Real* factor = b.family_state[kNormalisation][0];
        return bonds.load(b.bond_state[kStiffness]) * factor[b.first + i] /
               (factor[b.first + i] + bonds.gather(factor));
    }
    template <class Entry>
    PERIMPM_INLINE static void deform(const P X[3], P out[3], const Entry F[9]) {
        for (int r = 0; r < 3; ++r) out[r] = F[3 * r] * X[0] + F[3 * r + 1] * X[1] + F[3 * r + 2] * X[2];
    }
    /// A K^+ for the sums A over a family.
    void times_shape_inverse(const Block<Real>& b, std::uint32_t i, const P A[9], Real out[9]) const {
        const Field<Real>& K = b.particle_state[kShapeInverse];
        for (int r = 0; r < 3; ++r) {
            const Real x = reduce(A[3 * r]), y = reduce(A[3 * r + 1]), z = reduce(A[3 * r + 2]);
            out[3 * r] = x * K[0][i] + y * K[1][i] + z * K[2][i];
            out[3 * r + 1] = x * K[1][i] + y * K[3][i] + z * K[4][i];
            out[3 * r + 2] = x * K[2][i] + y * K[4][i] + z * K[5][i];
        }
    }

    template <bool Weighted>
    void set_mean_deformation(Block<Real>& b, std::uint32_t i) const {
        const Real* own = b.family.position + 4 * std::size_t{b.first + i};
        const Real* reference = b.family.reference + 4 * std::size_t{b.first + i};
        P A[9] = {};
        for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P X[4], Y[3];
            bonds.template gather_packed<4>(b.family.reference, X);
            bonds.difference(b.family.position, own, Y);
            P w = live * X[3];
            if constexpr (Weighted) w *= bonds.load(b.bond_state[influence_field_]);
            for (int c = 0; c < 3; ++c) X[c] = w * (X[c] - reference[c]);
            for (int c = 0; c < 9; ++c) A[c] += Y[c / 3] * X[c % 3];
        });
        Real* F = b.particle_state[kMeanDeformation].data + kRecord * i;
        times_shape_inverse(b, i, A, F);              // (4)
        const bool two = form_ == Form::variational;  // records, of which neighbours read the second
        for (int field = kMeanDeformation; field <= (two ? kAveragedStress : kMeanDeformation); ++field) {
            Real* record = b.particle_state[field].data + kRecord * i;
            for (int c = 0; c < 3; ++c) record[kReference + c] = reference[c], record[kPresent + c] = own[c];
            record[kVolume] = b.volume[i];
        }
    }

    template <bool Yields>
    void set_averaged_stress(Block<Real>& b, std::uint32_t i) const {
        const Real* F = b.particle_state[kMeanDeformation].data + kRecord * i;
        const P factor = real(2 * moduli_.mu / static_cast<double>(b.volume[i]));
        P G[9] = {};
        for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P X[3], mean[3];
            bonds.difference(b.family.reference, F + kReference, X);
            deform(X, mean, F);
            const P z = norm(mean), length = bonds.load(b.family.length);
            P extension = z - length;
            if constexpr (Yields) extension -= length * bonds.load(b.bond_state[flow_fields_.strain]);
            const P pull = live * factor * bonds.load(b.bond_state[own_]) * extension * inverse_length(z);
            for (int c = 0; c < 3; ++c) mean[c] *= pull;
            for (int c = 0; c < 9; ++c) G[c] += mean[c / 3] * X[c % 3];
        });
        times_shape_inverse(b, i, G, b.particle_state[kAveragedStress].data + kRecord * i);
    }

    template <Form kForm, bool Weighted>
    void evaluate_as(Block<Real>& b) const {
        constexpr bool records = kForm != Form::springs;
        const Field<Real>& records_of = b.family_state[kForm == Form::paper ? kMeanDeformation : kAveragedStress];
        const P lambda = real(moduli_.lambda), two_mu = real(2 * moduli_.mu);
        P largest(0);
        for (std::uint32_t i = 0; i < b.size; ++i) {
            const Real* position = b.family.position + 4 * std::size_t{b.first + i};
            const Real* mine = records ? records_of.data + kRecord * std::size_t{b.first + i} : nullptr;
            P f[3] = {P(0), P(0), P(0)};
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                P theirs[kRecord], X[3], Y[3];
                if constexpr (records) {
                    bonds.template gather_packed<kRecord>(records_of.data, theirs);
                    for (int c = 0; c < 3; ++c) {
                        X[c] = theirs[kReference + c] - mine[kReference + c];
                        Y[c] = theirs[kPresent + c] - mine[kPresent + c];
                    }
                } else {
                    bonds.difference(b.family.position, position, Y);
                }
                const P length = bonds.load(b.family.length), y = norm(Y), inverse = inverse_length(y);
                const P relative = live * ((y - length) * inverse);
                largest = larger(largest, relative);
                const P stiffness = bonds.load(b.bond_state[kStiffness]);
                const P spring = lambda * stiffness * relative;  // (6), second term
                for (int c = 0; c < 3; ++c) f[c] += spring * Y[c];
                if constexpr (kForm == Form::paper) {
                    const P own = bonds.load(b.bond_state[own_]);
                    P here[3], there[3];
                    deform(X, here, mine);
                    deform(X, there, theirs);
                    const P bending = live * two_mu;
                    const P from_own = bending * own * relative_extension(here, length);  // first term, of T<p,q>
                    const P from_other = bending * (stiffness - own) * relative_extension(there, length);  // of -T<q,p>
                    for (int c = 0; c < 3; ++c) f[c] += from_own * here[c] + from_other * there[c];
                }
                if constexpr (kForm == Form::variational) {
                    P w = live * mine[kVolume] * theirs[kVolume];
                    if constexpr (Weighted) w *= bonds.load(b.bond_state[influence_field_]);
                    for (int r = 0; r < 9; ++r) theirs[r] += mine[r];
                    P pull[3];
                    deform(X, pull, theirs);
                    for (int c = 0; c < 3; ++c) f[c] += w * pull[c];
                }
            });
            for (int c = 0; c < 3; ++c) b.force[c][i] = reduce(f[c]);  // (7)
        }
        b.largest_stretch = stretch_of(hmax(largest));
    }

    /// What permanent strains change in the forces. In the paper's form also |Y| for |Y-|, as (9) prints.
    void add_yielded(Block<Real>& b) const {
        const bool bending = form_ == Form::paper;
        const P lambda = real(moduli_.lambda), two_mu = real(2 * moduli_.mu);
        for (std::uint32_t i = 0; i < b.size; ++i) {
            const Real* position = b.family.position + 4 * std::size_t{b.first + i};
            P f[3] = {P(0), P(0), P(0)};
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                P Y[3];
                bonds.difference(b.family.position, position, Y);
                const P length = bonds.load(b.family.length), own = bonds.load(b.bond_state[own_]);
                const P other = bonds.load(b.bond_state[kStiffness]) - own, y = norm(Y);
                const P here = length * bonds.load(b.bond_state[flow_fields_.strain]);  // e_p |X| of both directions
                const P there = length * flow_.at_other_end(b, bonds, flow_fields_);
                const P spring = live * lambda * inverse_length(y) * (own * here + other * there);
                for (int c = 0; c < 3; ++c) f[c] -= spring * Y[c];
                if (!bending) return;  // the variational form has it in H
                const Real* mine = b.particle_state[kMeanDeformation].data + kRecord * i;
                P theirs[kRecord], X[3], mean[3];
                bonds.template gather_packed<kRecord>(b.family_state[kMeanDeformation].data, theirs);
                bonds.difference(b.family.reference, mine + kReference, X);
                const auto add = [&](const auto* F, const P& stiffness, const P& yielded) {
                    deform(X, mean, F);
                    const P z = norm(mean), pull = live * two_mu * stiffness * (y - z - yielded) * inverse_length(z);
                    for (int c = 0; c < 3; ++c) f[c] += pull * mean[c];
                };
                add(mine, own, here);
                add(theirs, other, there);
            });
            for (int c = 0; c < 3; ++c) b.force[c][i] += reduce(f[c]);
        }
    }

    void set_shape_inverse(Block<Real>& b, std::uint32_t i) const {
        Eigen::Matrix3d K = Eigen::Matrix3d::Zero();
        const Real* own = b.family.reference + 4 * std::size_t{b.first + i};
        for (std::uint32_t slot = b.family.row[i]; slot < b.family.row[i + 1]; ++slot) {
            const Real* other = b.family.reference + 4 * std::size_t{b.family.neighbour[slot]};
            const Eigen::Vector3d X(other[0] - own[0], other[1] - own[1], other[2] - own[2]);
            const double w = influence_(static_cast<double>(b.family.length[slot]));
            if (influence_field_ >= 0) b.bond_state[influence_field_][slot] = static_cast<Real>(w);
            if (!b.family.is_broken(slot)) K += w * static_cast<double>(other[3]) * X * X.transpose();
        }
        const Eigen::Matrix3d pseudo = pseudo_inverse(K, kSingular);
        constexpr int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};
        for (int c = 0; c < 6; ++c)
            b.particle_state[kShapeInverse][c][i] = static_cast<Real>(pseudo(row[c], column[c]));
    }

    double density_, horizon_;
    Influence influence_;
    SpringModuli moduli_;
    Form form_;
    SpringLattice lattice_;
    FamilyWeights<Real> weights_;
    Flow flow_;
    std::vector<FieldSpec> particle_fields_, bond_fields_;
    int own_ = -1, influence_field_ = -1;
    typename Flow::Fields flow_fields_;
};

}  // namespace perimpm::peridynamics
