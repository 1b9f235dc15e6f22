/*! Correspondence peridynamics (Silling, Epton, Weckner, Xu, Askari 2007, doi:10.1007/s10659-007-9125-1, section 18): a
    local law driven by the deformation gradient of each particle's family. w: influence function.
      (1) F- = [sum_q w V_q Y (x) X] K^-1,  K = sum_q w V_q X (x) X          exact for affine motion, at surfaces too
      (2) tau of the local law at F-,  P = tau F-^-T                          Kirchhoff stress, first Piola-Kirchhoff [Pa]
      (3) T<p,q> = w (P K^-1 X + s z),  z = Y - F- X                          force state [N/m^6]
      (4) E_p = V_p (W(F-) + s/2 sum_q w |z|^2 V_q),  s = G M/tr K             energy [J]; M: modulus of pressure waves [Pa]
      (5) f_p = V_p sum_q (T<p,q> - T<q,p>) V_q = sum_q w V_p V_q [(B_p + B_q) X + (s_p + s_q) (Y - X)],
          B = P K^-1 - s (F- - I)
    (1) cannot see motions z that leave F- alone, such as a checkerboard; the second term of (3) resists them (Silling 2017,
    doi:10.1016/j.cma.2017.03.043, with tr K for his normalisation). sum w V z (x) X = 0, so that (5) is minus the gradient
    of (4), and the term vanishes for affine motion.
    `divergence = "grid"` leaves (3) to (5) out: the grid takes the divergence of (2), as it does for a local law. Then
    surfaces are free of tractions, the grid filters zero-energy modes, and F- keeps the bonds' memory: it cannot drift and
    ends where bonds break. Such forces are not the gradient of an energy.
    A law that flows gets F-_new F-_old^-1 times the elastic part that it left. Families that do not span space (sheets,
    strands, fewer than three bonds) carry no stress. */
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "perimpm/math/elasticity.hpp"
#include "perimpm/math/mat3.hpp"
#include "perimpm/peridynamics/family.hpp"
#include "perimpm/peridynamics/influence.hpp"
#include "perimpm/peridynamics/kept_fields.hpp"
#include "perimpm/plugin/plugin.hpp"
#include "perimpm/plugin/registry.hpp"

namespace {
using namespace perimpm;
using namespace perimpm::peridynamics;

constexpr ParamSpec kParams[] = {
    {.key = "law", .kind = ParamKind::model, .doc = "{ type = a local law, its parameters }: stress from F-"},
    {.key = "divergence",
     .kind = ParamKind::choice,
     .default_text = "bonds",
     .choices = "bonds|grid",
     .doc = "who makes forces of the stress: the bonds, or the grid as for local laws"},
    {.key = "stabilisation",
     .range = at_least(0),
     .default_value = 1,
     .doc = "stiffness of the bonds against motion that the family's deformation gradient does not see; divergence "
            "\"bonds\""},
    horizon_param(),
    horizon_length_param(),
    influence_param(),
    volume_correction_param(),
};
enum State { kMeanDeformation, kShapeInverse, kElastic };
constexpr FieldSpec kMean = {.name = "mean_deformation", .components = 9, .doc = "F- of (1), row-major"};
constexpr FieldSpec kInverse = {
    .name = "shape_inverse", .components = 6, .unit = "1/m^5", .doc = "K^-1: xx xy xz yy yz zz; 0: spans no space"};
constexpr FieldSpec kElasticPart = {
    .name = "elastic_deformation", .components = 9, .doc = "what the law leaves of F-, row-major"};
constexpr FieldSpec kStressField = {
    .name = "stress", .components = 6, .unit = "Pa", .doc = "Kirchhoff stress: xx xy xz yy yz zz"};
// What neighbours read of a particle, in one cache line of single precision.
enum Record { kReference = 9, kPresent = 12, kStabilisation = 15, kRecord = 16 };
constexpr FieldSpec kForceState = {
    .name = "force_state", .components = 9, .unit = "N/m^7", .doc = "B of (5), row-major", .packed = kRecord};
constexpr FieldSpec kBondConstants[] = {{.name = "pair_weight", .unit = "m^6", .doc = "w V_p V_q"}};
constexpr int kVoigt[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};

template <class Real>
class PdCorrespondence final : public ConstitutiveLaw<Real> {
    using P = Pack<Real>;

public:
    explicit PdCorrespondence(const Params& p)
        : law_{create_inner<ConstitutiveLaw, Real>(p, "law")},
          inner_{law_->needs()},
          grid_{p.is("divergence", "grid")},
          strength_{grid_ ? 0 : p["stabilisation"]},
          density_{p.context().density},
          influence_{p, horizon_of(p)},
          fields_{kMean, kInverse} {
        if (!inner_.deformation_gradient)
            throw InvalidParameter("law", "must be a local law, which takes a deformation gradient");
        if (p.context().dimension < 3)
            throw InvalidParameter("type",
                                   "needs families that fill space: use pd_elastic, pd_lps or pd_bond for sheets "
                                   "and strands");
        if (grid_ && p.given("stabilisation"))
            throw InvalidParameter("stabilisation", "belongs to divergence = \"bonds\": here bonds carry no forces");
        const Lame<double> lame(inner_.moduli.youngs_modulus, inner_.moduli.poisson_ratio);
        modulus_ = lame.lambda + 2 * lame.mu;
        if (strength_ > 0 && !std::isfinite(modulus_))
            throw InvalidParameter(
                "law",
                "does not say how stiff it is, which stabilisation needs: let the law declare its moduli, "
                "or set stabilisation = 0");
        if (inner_.flows) fields_.push_back(kElasticPart);
        if (!grid_) force_state_ = add(kForceState), stress_ = add(kStressField);
        first_inner_ = static_cast<std::uint32_t>(fields_.size());
        for (std::uint32_t k = 0; k < inner_.particle_state.size; ++k) add(inner_.particle_state.data[k]);
    }
    LawNeeds needs() const noexcept override {
        return {.bonds = true,
                .stress = grid_,
                .prepare = true,
                .horizon = influence_.reach(),
                .particle_state = kept(fields_),
                .bond_constants = kBondConstants,
                .moduli = inner_.moduli};
    }

    void initialise(Block<Real>& b, std::uint32_t round) const override {
        for (std::uint32_t i = 0; i < b.size; ++i) {
            set_weights(b, i), set_shape_inverse(b, i);
            store(b.particle_state[kMeanDeformation], i, Mat3<Real>::identity());
            if (inner_.flows) store(b.particle_state[kElastic], i, Mat3<Real>::identity());
        }
        Block<Real> inner = inner_block(b);
        law_->initialise(inner, round);
    }
    void renew(Block<Real>& b) const override {
        for (std::uint32_t i = 0; i < b.size; ++i) set_shape_inverse(b, i);
    }

    void prepare(Block<Real>& b) const override {
        for (std::uint32_t i = 0; i < b.size; ++i) set_mean_deformation(b, i);
        if (grid_) return;
        Block<Real> inner = inner_block(b);
        law_->evaluate(inner, b.dt);
        for (std::uint32_t i = 0; i < b.size; ++i) set_force_state(b, i);
    }

    void evaluate(Block<Real>& b, Real dt) const override {
        if (grid_) {
            Block<Real> inner = inner_block(b);
            return law_->evaluate(inner, dt);
        }
        const Real* records = b.family_state[force_state_].data;
        for (std::uint32_t i = 0; i < b.size; ++i) {
            const Real* mine = records + kRecord * std::size_t{b.first + i};
            P f[3] = {P(0), P(0), P(0)};
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                P theirs[kRecord], X[3];
                bonds.template gather_packed<kRecord>(records, theirs);
                for (int c = 0; c < 3; ++c) X[c] = theirs[kReference + c] - mine[kReference + c];
                const P weight = live * bonds.constant(b.bond_constants[0]);
                const P both = theirs[kStabilisation] + mine[kStabilisation];
                for (int c = 0; c < 3; ++c) {
                    P pull = both * (theirs[kPresent + c] - mine[kPresent + c] - X[c]);
                    for (int d = 0; d < 3; ++d) pull += (theirs[3 * c + d] + mine[3 * c + d]) * X[d];
                    f[c] += weight * pull;
                }
            });
            for (int c = 0; c < 3; ++c) b.force[c][i] = reduce(f[c]);  // (5)
        }
    }

    double max_wave_speed(const Block<Real>& b) const override { return law_->max_wave_speed(inner_block(b)); }
    /// By Cauchy's inequality (4) is at most the energy of springs (M |K^-1| + s) w V_p V_q of the families.
    StableStep stable_step(const Block<Real>& b) const override {
        const double speed = max_wave_speed(b);
        double smallest = std::numeric_limits<double>::infinity();
        for (std::uint32_t i = 0; i < b.size; ++i) {
            double sum = 0;
            for (std::uint32_t slot = b.family.row[i]; slot < b.family.row[i + 1]; ++slot)
                sum += static_cast<double>(b.bond_constants[0][constant_of(b.family, i, slot)]) *
                       (stiffness(b, b.first + i, speed) + stiffness(b, b.family.neighbour[slot], speed));
            if (sum > 0) smallest = std::min(smallest, std::sqrt(2 * static_cast<double>(b.mass[i]) / sum));
        }
        return {smallest, smallest};
    }

    double energy(const Block<Real>& b) const override {
        double total = law_->energy(inner_block(b));
        for (std::uint32_t i = 0; i < b.size && strength_ > 0; ++i) {
            const Real* record = b.particle_state[force_state_].data + kRecord * std::size_t{i};
            P F[9], sum(0);
            for (int c = 0; c < 9; ++c) F[c] = P(b.particle_state[kMeanDeformation][c][i]);
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                P X[3], Y[3];
                bonds.difference(b.family.reference, b.family.reference + 4 * std::size_t{b.first + i}, X);
                bonds.difference(b.family.position, b.family.position + 4 * std::size_t{b.first + i}, Y);
                P z2(0);
                for (int c = 0; c < 3; ++c) {
                    const P z = Y[c] - (F[3 * c] * X[0] + F[3 * c + 1] * X[1] + F[3 * c + 2] * X[2]);
                    z2 += z * z;
                }
                sum += live * bonds.constant(b.bond_constants[0]) * z2;
            });
            total += 0.5 * static_cast<double>(record[kStabilisation]) * static_cast<double>(reduce(sum));  // (4)
        }
        return total;
    }

private:
    static constexpr double kSingular = 1e-4;  // eigenvalues of K below this share of the largest span nothing

    int add(const FieldSpec& spec) {
        fields_.push_back(spec);
        return static_cast<int>(fields_.size()) - 1;
    }

    /// What the local law sees: F- (or its elastic part), its own fields and where the stress goes.
    Block<Real> inner_block(const Block<Real>& b) const {
        Block<Real> inner = b;
        inner.family = {};
        inner.F = b.particle_state[inner_.flows ? kElastic : kMeanDeformation];
        if (!grid_) inner.tau = b.particle_state[stress_];
        for (std::uint32_t k = 0; k < kMaxStateFields; ++k) {
            const bool own = k < inner_.particle_state.size;
            inner.particle_state[k] = own ? b.particle_state[first_inner_ + k] : Field<Real>{};
            inner.family_state[k] = {};
            inner.bond_state[k] = inner.bond_constants[k] = nullptr;
        }
        return inner;
    }

    static Mat3<Real> load(const Field<Real>& field, std::uint32_t i) {
        Mat3<Real> m;
        for (int c = 0; c < 9; ++c) m.m[c] = field[static_cast<std::size_t>(c)][i];
        return m;
    }
    static void store(const Field<Real>& field, std::uint32_t i, const Mat3<Real>& m) {
        for (int c = 0; c < 9; ++c) field[static_cast<std::size_t>(c)][i] = m.m[c];
    }
    static Mat3<Real> shape_inverse(const Field<Real>& field, std::size_t i) {
        Mat3<Real> m;
        for (int c = 0; c < 9; ++c) m.m[c] = field[static_cast<std::size_t>(kVoigt[c / 3][c % 3])][i];
        return m;
    }

    /// w V_q
    double weight(const Block<Real>& b, std::uint32_t i, std::uint32_t slot) const {
        const Real volume = b.family.reference[4 * std::size_t{b.family.neighbour[slot]} + 3];
        return influence_(static_cast<double>(b.family.length[constant_of(b.family, i, slot)])) *
               static_cast<double>(volume);
    }
    void set_weights(Block<Real>& b, std::uint32_t i) const {
        const double volume = static_cast<double>(b.family.reference[4 * std::size_t{b.first + i} + 3]);
        for (std::uint32_t slot = b.family.row[i]; slot < b.family.row[i + 1]; ++slot)
            b.bond_constants[0][constant_of(b.family, i, slot)] = static_cast<Real>(weight(b, i, slot) * volume);
    }
    void set_shape_inverse(Block<Real>& b, std::uint32_t i) const {
        Eigen::Matrix3d K = Eigen::Matrix3d::Zero();
        const Real* own = b.family.reference + 4 * std::size_t{b.first + i};
        for (std::uint32_t slot = b.family.row[i]; slot < b.family.row[i + 1]; ++slot) {
            const Real* other = b.family.reference + 4 * std::size_t{b.family.neighbour[slot]};
            const Eigen::Vector3d X(other[0] - own[0], other[1] - own[1], other[2] - own[2]);
            if (!b.family.is_broken(slot)) K += weight(b, i, slot) * X * X.transpose();
        }
        const Eigen::Vector3d spread = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(K).eigenvalues();
        const bool spans = spread[0] > kSingular * spread[2];
        const Eigen::Matrix3d inverse = spans ? Eigen::Matrix3d(K.inverse()) : Eigen::Matrix3d::Zero();
        for (int r = 0; r < 3; ++r)
            for (int c = r; c < 3; ++c)
                b.particle_state[kShapeInverse][static_cast<std::size_t>(kVoigt[r][c])][i] =
                    static_cast<Real>(inverse(r, c));
        if (!grid_)
            b.particle_state[force_state_].data[kRecord * std::size_t{i} + kStabilisation] =
                static_cast<Real>(spans ? strength_ * modulus_ / K.trace() : 0);
    }

    void set_mean_deformation(Block<Real>& b, std::uint32_t i) const {
        const Mat3<Real> K = shape_inverse(b.particle_state[kShapeInverse], i);
        if (K.m[0] == 0) return;  // spans no space: stays at rest
        const Real* reference = b.family.reference + 4 * std::size_t{b.first + i};
        const Real* position = b.family.position + 4 * std::size_t{b.first + i};
        P A[9] = {};
        for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
            P X[3], Y[3];
            bonds.difference(b.family.reference, reference, X);
            bonds.difference(b.family.position, position, Y);
            const P weight = live * bonds.constant(b.bond_constants[0]);
            for (int c = 0; c < 9; ++c) A[c] += (Y[c / 3] - X[c / 3]) * (weight * X[c % 3]);
        });
        Mat3<Real> sum;
        for (int c = 0; c < 9; ++c) sum.m[c] = reduce(A[c]) / b.volume[i];
        Mat3<Real> F = sum * K;  // (1) of displacements, which is exact at rest
        for (int c = 0; c < 9; c += 4) F.m[c] += 1;
        if (inner_.flows) {
            const Mat3<Real> before = load(b.particle_state[kMeanDeformation], i);
            store(b.particle_state[kElastic], i, F * inverse(before) * load(b.particle_state[kElastic], i));
        }
        store(b.particle_state[kMeanDeformation], i, F);
    }

    void set_force_state(Block<Real>& b, std::uint32_t i) const {
        const Mat3<Real> F = load(b.particle_state[kMeanDeformation], i);
        Mat3<Real> tau;
        for (int c = 0; c < 9; ++c)
            tau.m[c] = b.particle_state[stress_][static_cast<std::size_t>(kVoigt[c / 3][c % 3])][i];
        const Mat3<Real> H = tau * transpose(inverse(F)) * shape_inverse(b.particle_state[kShapeInverse], i);  // (2)
        Real* record = b.particle_state[force_state_].data + kRecord * std::size_t{i};
        for (int c = 0; c < 9; ++c) record[c] = H.m[c] - record[kStabilisation] * (F.m[c] - (c % 4 == 0));
        for (int c = 0; c < 3; ++c) {
            record[kReference + c] = b.family.reference[4 * std::size_t{b.first + i} + static_cast<std::size_t>(c)];
            record[kPresent + c] = b.family.position[4 * std::size_t{b.first + i} + static_cast<std::size_t>(c)];
        }
    }

    /// Of the springs that bound (4), over w V_p V_q; rho c^2 is the law's modulus as it is now [N/m^6].
    double stiffness(const Block<Real>& b, std::size_t p, double speed) const {
        const Mat3<Real> K = shape_inverse(b.family_state[kShapeInverse], p);
        double largest = 0;  // the largest row sum bounds the largest eigenvalue
        for (int r = 0; r < 3; ++r)
            largest = std::max(largest, static_cast<double>(std::abs(K(r, 0)) + std::abs(K(r, 1)) + std::abs(K(r, 2))));
        const double s = static_cast<double>(b.family_state[force_state_].data[kRecord * p + kStabilisation]);
        return density_ * speed * speed * largest + s;
    }

    ModelPtr<ConstitutiveLaw, Real> law_;
    LawNeeds inner_;
    bool grid_;
    double strength_, modulus_ = 0, density_;
    Influence influence_;
    std::vector<FieldSpec> fields_;
    int force_state_ = -1, stress_ = -1;
    std::uint32_t first_inner_ = 0;
};
}  // namespace

PERIMPM_PLUGIN(ConstitutiveLaw, PdCorrespondence, kParams,
               "correspondence peridynamics: any local law, driven by the deformation gradient of the family")
