/*! Integral-based elastic law of Lyu, Zhang, Chang, Guo, Zhang 2019, "Integrating Peridynamics with Material Point Method for
    Elastoplastic Material Modeling". Equation numbers are the paper's.
      (4) F- = [sum w Y (x) X] K^+,  K = sum w X (x) X               integral deformation gradient of the family
          Y- = F- X                                                  averaged bond
      (5) E = sum w (mu (|Y-|/|X| - 1)^2 + lambda/2 (|Y|/|X| - 1)^2)
      (6) T<p,q> = (2 mu w/|X|^2) (|Y-| - |X|) dir Y-  +  (lambda w/|X|^2) (|Y| - |X|) dir Y     force state [N/m^6]
      (7) f_p = V_p sum_q (T<p,q> - T<q,p>) V_q                      force of the particle [N]
          w = 5 w^ / sum_q w^ V_q,  w^ = 1 - |X|/delta (linear, the paper's) or 1     weight [1/m^3]
    Differs from print: (4) has the X that print lost and the pseudo-inverse of K (relative cut kSingular), so that coplanar
    and collinear families work and Y- stays exact inside their span; (7) without m_p and with w once, as dimensions demand;
    w on the reference length. Under homogeneous strain Y- = Y and the law is one spring of stiffness 2 mu + lambda: Poisson's
    ratio is 1/4 for every mu and lambda, and E = 5/6 (2 mu + lambda). mu resists bending, it is not a shear modulus.
    `surface`: sum_q w^ V_q over the full lattice ("none") or over the particle's own family ("family").
    Linear momentum is exact; angular momentum and energy are not, under inhomogeneous strain with mu > 0.
    Defaults by measurement (tests/verification/README.md): constant w^ instead of the paper's linear one, horizon 3.015 and
    `surface = "family"`, because on a lattice linear w^ and short horizons make E along the axes up to 22 % too large;
    mu = lambda/10, because ratios near 1 feed energy where no grid damps it. */
#include "perimpm/math/pseudo_inverse.hpp"
#include "perimpm/peridynamics/family.hpp"
#include "perimpm/plugin/plugin.hpp"

namespace {
using namespace perimpm;
using namespace perimpm::peridynamics;

constexpr ParamSpec kParams[] = {
    {.key = "youngs_modulus",
     .unit = "Pa",
     .range = above(0),
     .optional = true,
     .doc = "Young's modulus, the stiffness in tension; required by calibration \"modulus\""},
    {.key = "bending_ratio",
     .range = at_least(0),
     .default_value = 0.1,
     .doc = "stiffness of the averaged bonds, which resist bending, over that of the plain springs; 0: springs only"},
    {.key = "mu",
     .unit = "Pa",
     .range = at_least(0),
     .optional = true,
     .doc = "stiffness of the averaged bonds, as the paper prints it; calibration \"paper\""},
    {.key = "lambda",
     .unit = "Pa",
     .range = at_least(0),
     .optional = true,
     .doc = "stiffness of the plain springs, as the paper prints it; calibration \"paper\""},
    {.key = "calibration",
     .kind = ParamKind::choice,
     .default_text = "modulus",
     .choices = "modulus|paper",
     .doc = "what gives the stiffness: youngs_modulus and bending_ratio, or mu and lambda"},
    {.key = "poisson_ratio", .range = open(-1, 0.5), .default_value = 0.25, .doc = "this law has 1/4 and no other"},
    {.key = "horizon", .unit = "spacings", .range = above(1), .default_value = 3.015, .doc = "how far bonds reach"},
    {.key = "influence",
     .kind = ParamKind::choice,
     .default_text = "constant",
     .choices = "linear|constant",
     .doc = "weight of a bond: falling linearly to 0 at the horizon (the paper's), or the same for all"},
    {.key = "surface",
     .kind = ParamKind::choice,
     .default_text = "family",
     .choices = "none|family",
     .doc = "\"family\" stiffens the bonds of particles near a surface for the neighbours they lack; \"none\" leaves "
            "them soft"},
};
enum ParticleState { kNormalisation, kShapeInverse, kMeanDeformation };
constexpr FieldSpec kParticleState[] = {
    {.name = "normalisation", .unit = "1/m^3", .doc = "5 / sum w^ V"},
    {.name = "shape_inverse", .components = 6, .unit = "1/m^5", .doc = "K^+ of (4): xx xy xz yy yz zz"},
    {.name = "mean_deformation", .components = 9, .doc = "F- of (4), row-major", .packed = 16},
};
// What follows F-, so that all that bonds ask of a neighbour is one cache line of single precision.
enum Record { kNormal = 9, kReference = 10, kPresent = 13, kRecord = 16 };
enum BondState { kStiffness };
constexpr FieldSpec kBondState[] = {
    {.name = "stiffness", .unit = "m", .doc = "(w_p + w_q) V_p V_q / |X|^2; times lambda: N/m"},
};
constexpr double kSingular = 1e-4;  // eigenvalues of K below this share of the largest count as zero
constexpr double kPoissonRatio = 0.25;

template <class Real>
class PdElastic final : public ConstitutiveLaw<Real> {
    using P = Pack<Real>;

public:
    explicit PdElastic(const Params& p)
        : density_{p.context().density},
          horizon_{p["horizon"] * p.context().particle_spacing},
          linear_{p.is("influence", "linear")},
          own_family_{p.is("surface", "family")} {
        if (p["poisson_ratio"] != kPoissonRatio)
            throw InvalidParameter(
                "poisson_ratio",
                "must be 1/4, which this law has whatever mu and lambda; another ratio needs a local law, such as "
                "fixed_corotated");
        const bool paper = p.is("calibration", "paper");
        for (const char* key : {"mu", "lambda"})
            if (p.given(key) != paper)
                throw InvalidParameter(
                    key, paper ? "is required by calibration = \"paper\"" : "belongs to calibration = \"paper\"");
        for (const char* key : {"youngs_modulus", "bending_ratio"})
            if (paper && p.given(key)) throw InvalidParameter(key, "belongs to calibration = \"modulus\"");
        if (!paper && !p.given("youngs_modulus"))
            throw InvalidParameter("youngs_modulus", "is required by calibration = \"modulus\"");
        lambda_ = paper ? p["lambda"] : 1.2 * p["youngs_modulus"] / (1 + 2 * p["bending_ratio"]);
        mu_ = paper ? p["mu"] : p["bending_ratio"] * lambda_;
        if (mu_ + lambda_ <= 0) throw InvalidParameter("lambda", "mu and lambda must not both be 0");
        full_weight_ = lattice_sum(horizon_, p.context().particle_spacing, [&](double X) { return influence(X); });
    }
    LawNeeds needs() const noexcept override {
        LawNeeds n{.bonds = true,
                   .prepare = mu_ > 0,
                   .reports_stretch = true,
                   .horizon = horizon_,
                   .rounds = 2,
                   .particle_state = kParticleState,
                   .bond_state = kBondState,
                   .moduli = {modulus() * 5 / 6, kPoissonRatio}};
        if (linear_) n.horizon *= 1 - 1e-9;                   // the rim has w^ = 0: not a bond
        if (mu_ == 0) n.particle_state.size = kShapeInverse;  // one spring per bond needs no F-
        return n;
    }

    void initialise(Block<Real>& b, std::uint32_t round) const override {
        for (std::uint32_t i = 0; i < b.size; ++i) {
            if (round == 0)
                set_normalisation(b, i);
            else
                set_stiffness(b, i);
            if (round == 1 && mu_ > 0) set_shape_inverse(b, i);
        }
    }

    void prepare(Block<Real>& b) const override {
        for (std::uint32_t i = 0; i < b.size; ++i) {
            const Real* own = b.family.position + 4 * std::size_t{b.first + i};
            const Real* own_reference = b.family.reference + 4 * std::size_t{b.first + i};
            P A[9] = {};
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                P X[4], Y[3];
                bonds.template gather_packed<4>(b.family.reference, X);
                bonds.difference(b.family.position, own, Y);
                P w = live * X[3];
                if (linear_) w *= influence(bonds.load(b.family.length));
                for (int c = 0; c < 3; ++c) X[c] = w * (X[c] - own_reference[c]);
                for (int c = 0; c < 9; ++c) A[c] += Y[c / 3] * X[c % 3];
            });
            const Field<Real>& K = b.particle_state[kShapeInverse];
            Real* F = mean_deformation(b, i);
            for (int r = 0; r < 3; ++r) {  // (4)
                const Real x = reduce(A[3 * r]), y = reduce(A[3 * r + 1]), z = reduce(A[3 * r + 2]);
                F[3 * r] = x * K[0][i] + y * K[1][i] + z * K[2][i];
                F[3 * r + 1] = x * K[1][i] + y * K[3][i] + z * K[4][i];
                F[3 * r + 2] = x * K[2][i] + y * K[4][i] + z * K[5][i];
            }
            F[kNormal] = b.particle_state[kNormalisation][0][i];
            for (int c = 0; c < 3; ++c) F[kReference + c] = own_reference[c], F[kPresent + c] = own[c];
        }
    }

    void evaluate(Block<Real>& b, Real) const override {
        P extension(0);
        for (std::uint32_t i = 0; i < b.size; ++i) {
            P f[3] = {P(0), P(0), P(0)};
            if (mu_ > 0)
                add_both_terms(b, i, f, extension);
            else
                add_spring_term(b, i, f, extension);
            for (int c = 0; c < 3; ++c) b.force[c][i] = reduce(f[c]);
        }
        b.largest_stretch = stretch_of(hmax(extension));
    }

    double max_wave_speed(const Block<Real>& b) const override {
        return std::sqrt(modulus() / density_) * largest_stretch(b);
    }
    double stable_time_step(const Block<Real>& b) const override {
        return silling_askari_bound(b, b.bond_state[kStiffness], modulus());
    }

    double energy(const Block<Real>& b) const override {
        double total = 0;
        for (std::uint32_t i = 0; i < b.size; ++i)
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                P Y[3];
                bonds.difference(b.family.position, b.family.position + 4 * std::size_t{b.first + i}, Y);
                const P length = bonds.load(b.family.length);
                const P extension = norm(Y) - length;
                P twice = real(lambda_) * extension * extension;
                if (mu_ > 0) {
                    P X[3], mean[3];
                    bonds.difference(b.family.reference, b.family.reference + 4 * std::size_t{b.first + i}, X);
                    deform(X, mean, mean_deformation(b, i));
                    const P averaged = norm(mean) - length;
                    twice += real(2 * mu_) * averaged * averaged;
                }
                const Real* normalisation = b.family_state[kNormalisation][0];
                const P share = own_share(normalisation[b.first + i], bonds.gather(normalisation));
                total += 0.5 * static_cast<double>(
                                   reduce(live * share * bonds.load(b.bond_state[kStiffness]) * twice));  // (5)
            });
        return total;
    }

private:
    double modulus() const { return 2 * mu_ + lambda_; }
    static P real(double value) { return P(static_cast<Real>(value)); }
    template <class T>
    T influence(const T& X) const {
        return linear_ ? T(1) - X * T(Scalar<T>(1 / horizon_)) : T(1);
    }

    /// w_p / (w_p + w_q), from the normalisations.
    P own_share(Real own, const P& other) const { return own_family_ ? own / (own + other) : P(Real(0.5)); }
    static Real* mean_deformation(const Block<Real>& b, std::uint32_t i) {
        return b.particle_state[kMeanDeformation].data + kRecord * i;
    }
    template <class Entry>
    PERIMPM_INLINE static void deform(const P X[3], P out[3], const Entry F[9]) {
        for (int r = 0; r < 3; ++r) out[r] = F[3 * r] * X[0] + F[3 * r + 1] * X[1] + F[3 * r + 2] * X[2];
    }

    void add_spring_term(const Block<Real>& b, std::uint32_t i, P f[3], P& extension) const {
        const Real* position = b.family.position + 4 * std::size_t{b.first + i};
        const P lambda = real(lambda_);
        for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P Y[3];
            bonds.difference(b.family.position, position, Y);
            const P relative = live * relative_extension(Y, bonds.load(b.family.length));
            const P pull = lambda * bonds.load(b.bond_state[kStiffness]) * relative;  // (6), second term, (7)
            extension = larger(extension, relative);
            for (int c = 0; c < 3; ++c) f[c] += pull * Y[c];
        });
    }

    void add_both_terms(const Block<Real>& b, std::uint32_t i, P f[3], P& extension) const {
        const Real* mean = mean_deformation(b, i);
        const P lambda = real(lambda_), two_mu = real(2 * mu_);
        for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P other_mean[kRecord], X[3], Y[3], own[3], other[3];
            bonds.template gather_packed<kRecord>(b.family_state[kMeanDeformation].data, other_mean);
            for (int c = 0; c < 3; ++c) {
                X[c] = other_mean[kReference + c] - mean[kReference + c];
                Y[c] = other_mean[kPresent + c] - mean[kPresent + c];
            }
            deform(X, own, mean);
            deform(X, other, other_mean);
            const P length = bonds.load(b.family.length);
            const P stiffness = live * bonds.load(b.bond_state[kStiffness]);
            const P bending = two_mu * stiffness, share = own_share(mean[kNormal], other_mean[kNormal]);
            const P relative = live * relative_extension(Y, length);
            extension = larger(extension, relative);
            const P spring = lambda * stiffness * relative;                                     // (6), second term
            const P from_own = bending * share * relative_extension(own, length);               // first, of T<p,q>
            const P from_other = bending * (P(1) - share) * relative_extension(other, length);  // and of -T<q,p>
            for (int c = 0; c < 3; ++c) f[c] += spring * Y[c] + from_own * own[c] + from_other * other[c];  // (7)
        });
    }

    Eigen::Vector3d reference_bond(const Block<Real>& b, std::uint32_t i, std::uint32_t slot) const {
        const Real* own = b.family.reference + 4 * std::size_t{b.first + i};
        const Real* other = b.family.reference + 4 * std::size_t{b.family.neighbour[slot]};
        return Eigen::Vector3d(other[0] - own[0], other[1] - own[1], other[2] - own[2]);
    }
    void set_normalisation(Block<Real>& b, std::uint32_t i) const {
        double sum = 0;
        for (std::uint32_t slot = b.family.row[i]; slot < b.family.row[i + 1]; ++slot)
            sum += influence(static_cast<double>(b.family.length[slot])) *
                   static_cast<double>(b.family.volume[b.family.neighbour[slot]]);
        if (!own_family_) sum = full_weight_;
        b.particle_state[kNormalisation][0][i] = static_cast<Real>(sum > 0 ? 5 / sum : 0);
    }
    void set_stiffness(Block<Real>& b, std::uint32_t i) const {
        const Real* normalisation = b.family_state[kNormalisation][0];
        for (std::uint32_t slot = b.family.row[i]; slot < b.family.row[i + 1]; ++slot) {
            const std::uint32_t j = b.family.neighbour[slot];
            const double length = static_cast<double>(b.family.length[slot]);
            const double both = static_cast<double>(normalisation[b.first + i]) + static_cast<double>(normalisation[j]);
            b.bond_state[kStiffness][slot] =
                static_cast<Real>(both * influence(length) * static_cast<double>(b.volume[i]) *
                                  static_cast<double>(b.family.volume[j]) / (length * length));
        }
    }
    void set_shape_inverse(Block<Real>& b, std::uint32_t i) const {
        Eigen::Matrix3d K = Eigen::Matrix3d::Zero();
        for (std::uint32_t slot = b.family.row[i]; slot < b.family.row[i + 1]; ++slot) {
            if (b.family.is_broken(slot)) continue;
            const Eigen::Vector3d X = reference_bond(b, i, slot);
            K += influence(X.norm()) * static_cast<double>(b.family.volume[b.family.neighbour[slot]]) * X *
                 X.transpose();
        }
        const Eigen::Matrix3d pseudo = pseudo_inverse(K, kSingular);
        constexpr int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};
        for (int c = 0; c < 6; ++c)
            b.particle_state[kShapeInverse][c][i] = static_cast<Real>(pseudo(row[c], column[c]));
    }

    double density_, horizon_, mu_, lambda_;
    bool linear_, own_family_;
    double full_weight_;
};
}  // namespace

PERIMPM_PLUGIN(ConstitutiveLaw, PdElastic, kParams,
               "peridynamic elasticity of Lyu et al. 2019: bond springs and averaged bonds, nu = 1/4")
