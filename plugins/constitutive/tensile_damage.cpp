/*! Local fracture to compare with: any local law, damaged by its largest tension, softening as a crack band (Bazant & Oh 1983,
    doi:10.1007/BF02486267), closing again under pressure.
      (1) tau0 = sum_i sigma_i n_i (x) n_i                           stress of the undamaged law, principal values [Pa]
      (2) kappa = max over time of sigma_max/E                       largest tensile strain so far
      (3) D = 1 - (e0/kappa) exp(-(kappa - e0)/(ef - e0))            above e0 = f_t/E, else 0
      (4) tau = tau0 - D sum_i max(sigma_i, 0) n_i (x) n_i
      (5) ef = e0/2 + G_f/(w f_t)                                    a bar in tension then takes G_f per area of crack
    f_t: `tensile_strength`, G_f: `fracture_energy`, w: width of the band that fails, a grid cell. Without G_f all tension is lost
    at once, D = 1. (5) and the stored energy, of which D takes the share that the tension has in the linear energy of tau0, are
    those of small strains. */
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "perimpm/model/constitutive_law.hpp"
#include "perimpm/peridynamics/kept_fields.hpp"
#include "perimpm/plugin/plugin.hpp"
#include "perimpm/plugin/registry.hpp"

namespace {
using namespace perimpm;

constexpr ParamSpec kParams[] = {
    {.key = "law", .kind = ParamKind::model, .doc = "{ type = a local law, its parameters }: stress of what is whole"},
    {.key = "tensile_strength", .unit = "Pa", .range = above(0), .doc = "largest tension that it bears"},
    {.key = "fracture_energy",
     .unit = "J/m^2",
     .range = above(0),
     .optional = true,
     .doc = "energy per area of crack: how slowly it softens; absent: it breaks at once"},
};
enum State { kDamage, kTension, kReleased, kOwn };
constexpr FieldSpec kState[] = {
    {.name = "damage", .doc = "D of (3): share of tension lost"},
    {.name = "largest_tension", .doc = "kappa of (2): largest principal stress so far over Young's modulus"},
    {.name = "released_share", .doc = "what damage takes from the stored energy now, over that of the undamaged law"},
};

template <class Real>
class TensileDamage final : public ConstitutiveLaw<Real> {
public:
    explicit TensileDamage(const Params& p)
        : law_{create_inner<ConstitutiveLaw, Real>(p, "law")},
          inner_{law_->needs()},
          youngs_modulus_{inner_.moduli.youngs_modulus},
          poisson_ratio_{inner_.moduli.poisson_ratio},
          first_{p["tensile_strength"] / youngs_modulus_},
          fields_(std::begin(kState), std::end(kState)) {
        if (!inner_.deformation_gradient)
            throw InvalidParameter("law", "must be a local law: bonds break by a fracture criterion");
        if (!std::isfinite(youngs_modulus_))
            throw InvalidParameter("law", "does not say how stiff it is: damage needs its Young's modulus");
        fields_.insert(fields_.end(), inner_.particle_state.data,
                       inner_.particle_state.data + inner_.particle_state.size);
        if (!p.given("fracture_energy")) return;
        const double width = p.context().grid_spacing;
        softening_ = p["fracture_energy"] / (width * p["tensile_strength"]) - first_ / 2;  // (5): ef - e0
        if (width > 0 && softening_ <= 0)
            throw InvalidParameter("fracture_energy",
                                   "is less than the band stores before it breaks, tensile_strength^2 grid.spacing/(2 "
                                   "E): refine the grid");
    }
    LawNeeds needs() const noexcept override {
        return {.deformation_gradient = true,
                .flows = inner_.flows,
                .may_refuse = inner_.may_refuse,
                .rounds = inner_.rounds,
                .particle_state = peridynamics::kept(fields_),
                .moduli = inner_.moduli};
    }

    void initialise(Block<Real>& b, std::uint32_t round) const override {
        Block<Real> inner = inner_block(b);
        law_->initialise(inner, round);
    }

    void evaluate(Block<Real>& b, Real dt) const override {
        Block<Real> inner = inner_block(b);
        law_->evaluate(inner, dt);
        for (std::uint32_t i = 0; i < b.size; ++i) soften(b, i);
    }

    double max_wave_speed(const Block<Real>& b) const override { return law_->max_wave_speed(inner_block(b)); }

    double energy(const Block<Real>& b) const override {
        const Block<Real> inner = inner_block(b);
        double total = law_->energy(inner);
        for (std::uint32_t i = 0; i < b.size; ++i) {
            const auto share = static_cast<double>(b.particle_state[kReleased][0][i]);
            if (share > 0) total -= share * law_->energy(particle(inner, i));
        }
        return total;
    }

private:
    Block<Real> inner_block(const Block<Real>& b) const {
        Block<Real> inner = b;
        for (std::uint32_t k = 0; k < kMaxStateFields; ++k) inner.particle_state[k] = inner.family_state[k] = {};
        for (std::uint32_t k = kOwn; k < std::min(kMaxStateFields, kOwn + inner_.particle_state.size); ++k)
            inner.particle_state[k - kOwn] = b.particle_state[k];
        return inner;
    }

    /// The block's particle i alone.
    static Block<Real> particle(const Block<Real>& b, std::uint32_t i) {
        Block<Real> one = b;
        one.size = 1, one.first = b.first + i;
        one.x = b.x.from(i), one.v = b.v.from(i), one.F = b.F.from(i), one.tau = b.tau.from(i);
        one.mass = b.mass + i, one.volume = b.volume + i;
        for (Field<Real>& field : one.particle_state) field = field.from(i);
        return one;
    }

    /// (3).
    double damage(double tension) const {
        if (tension <= first_) return 0;
        return softening_ > 0 ? 1 - first_ / tension * std::exp(-(tension - first_) / softening_) : 1;
    }

    void soften(Block<Real>& b, std::uint32_t i) const {
        Eigen::Matrix3d stress;
        constexpr int at[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) stress(r, c) = static_cast<double>(b.tau[at[r][c]][i]);
        Real& so_far = b.particle_state[kTension][0][i];
        const double bound = stress.cwiseAbs().rowwise().sum().maxCoeff();  // of the largest principal stress
        if (so_far <= first_ && bound <= first_ * youngs_modulus_) return;
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(stress);                      // (1)
        so_far = std::max(so_far, static_cast<Real>(principal.eigenvalues()[2] / youngs_modulus_));  // (2)
        const double D = damage(static_cast<double>(so_far));
        const Eigen::Vector3d tension = principal.eigenvalues().cwiseMax(0);
        const Eigen::Matrix3d left =
            stress - D * principal.eigenvectors() * tension.asDiagonal() * principal.eigenvectors().transpose();  // (4)
        for (int r = 0; r < 3; ++r)
            for (int c = r; c < 3; ++c) b.tau[at[r][c]][i] = static_cast<Real>(left(r, c));
        b.particle_state[kDamage][0][i] = static_cast<Real>(D);
        b.particle_state[kReleased][0][i] =
            static_cast<Real>(D * linear_energy(tension) / linear_energy(principal.eigenvalues()));
    }

    /// Of principal stresses, times 2 E.
    double linear_energy(const Eigen::Vector3d& s) const {
        return (1 + poisson_ratio_) * s.squaredNorm() - poisson_ratio_ * s.sum() * s.sum();
    }

    ModelPtr<ConstitutiveLaw, Real> law_;
    LawNeeds inner_;
    double youngs_modulus_, poisson_ratio_;
    double first_;          ///< e0
    double softening_ = 0;  ///< ef - e0; 0: none
    std::vector<FieldSpec> fields_;
};
}  // namespace

PERIMPM_PLUGIN(ConstitutiveLaw, TensileDamage, kParams,
               "any local law that loses its tension beyond a strength: local fracture with softening")
