/*! Critical bond energy (Foster, Silling & Chen 2011, doi:10.1615/IntJMultCompEng.2011002407): a stretched bond breaks, for
    good, when it stores more than w_c per volume of both its particles. Compression breaks nothing.
      (1) w<p,q> + w<q,p> > w_c beta V_p V_q,  |Y| > |X|
      (2) G_0 = w_c sum beta V_p V_q per area of a plane, over the bonds that cross it      from the fracture energy G_0
    w is the law's (ConstitutiveLaw::bond_energy; with the share of ghosts where surface = "ghost"), beta the share of the
    neighbour's volume that counts. (2) is summed over the lattice midway between two layers; with many neighbours it is their
    w_c = 4 G_0/(pi delta^4).
    Each bond costs the same whatever its length and weight, so that long bonds of a falling influence stretch further than
    short ones before they break: a crack keeps a bridge of them behind it. In the plate of tests/verification/test_fracture.py
    that slows pd_elastic's crack with its default influence ("linear") to 0.49 and, on the finer lattice, 0.38 of the Rayleigh
    speed; with "inverse" and "constant" it and pd_lps have 0.51 to 0.57. */
#include "perimpm/peridynamics/family.hpp"
#include "perimpm/plugin/plugin.hpp"

namespace {
using namespace perimpm;
using namespace perimpm::peridynamics;

constexpr ParamSpec kParams[] = {
    {.key = "critical_energy",
     .unit = "J/m^6",
     .range = above(0),
     .optional = true,
     .doc = "a bond breaks when it stores more than this times the volumes of its two particles"},
    {.key = "fracture_energy",
     .unit = "J/m^2",
     .range = above(0),
     .optional = true,
     .doc = "energy per area of crack, instead of critical_energy, which then follows from the law's bonds; with "
            "pd_elastic "
            "give the law influence = \"inverse\", or cracks are slow"},
    interval_param(),
};

template <class Real>
class Energy final : public FractureCriterion<Real> {
    using P = Pack<Real>;

public:
    explicit Energy(const Params& p)
        : critical_{static_cast<Real>(energy_of(p))},
          volumes_{p.context().volumes},
          interval_{static_cast<std::uint32_t>(p["interval"])} {}
    std::uint32_t interval() const noexcept override { return interval_; }
    double harmless_stretch() const noexcept override { return 0; }
    bool asks_bond_energy() const noexcept override { return true; }

    void screen(const Block<Real>& b, CandidateList& found) const override {
        const std::uint32_t first = b.family.row[0];
        for (std::uint32_t i = 0; i < b.size; ++i) {
            const P limit(critical_ * b.volume[i]);
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                const P own(b.stored.own + (bonds.slot - first), std::experimental::element_aligned);
                const P other(b.stored.other + (bonds.slot - first), std::experimental::element_aligned);
                const P volume = bonds.gather(b.family.volume) * share(bonds.length());
                const auto over = live > P(0) && own + other > limit * volume;  // (1)
                if (any_of(over))
                    for (std::uint32_t lane = 0; lane < bonds.size; ++lane)
                        if (over[lane] && is_stretched(b, i, bonds.slot + lane))
                            found.add(b.first + i, bonds.slot + lane);
            });
        }
    }

private:
    static double energy_of(const Params& p) {
        if (p.given("critical_energy") && p.given("fracture_energy"))
            throw InvalidParameter("critical_energy", "contradicts fracture_energy: give one of the two");
        if (!p.given("critical_energy") && !p.given("fracture_energy"))
            throw InvalidParameter("critical_energy", "or 'fracture_energy' [J/m^2] is required: give one of the two");
        if (p.given("critical_energy")) return p["critical_energy"];
        const ModelContext& c = p.context();
        const auto share = [&](double X) { return c.volumes(X); };
        return p["fracture_energy"] / opening_energy(c.horizon, c, share, lattice_sum(c.horizon, c, share) / 2);  // (2)
    }

    /// beta
    P share(const P& length) const {
        if (volumes_.rim == 0) return P(1);
        const P inside = (P(static_cast<Real>(volumes_.radius)) - length) / P(static_cast<Real>(volumes_.rim));
        return clamp(inside + P(Real(0.5)), P(0), P(1));
    }
    static bool is_stretched(const Block<Real>& b, std::uint32_t i, std::uint32_t slot) {
        const Real* own = b.family.position + 4 * std::size_t{b.first + i};
        const Real* other = b.family.position + 4 * std::size_t{b.family.neighbour[slot]};
        const Real Y[3] = {other[0] - own[0], other[1] - own[1], other[2] - own[2]};
        return norm(Y) > b.family.length[constant_of(b.family, i, slot)];
    }

    Real critical_;  ///< w_c [J/m^6]
    BondVolumes volumes_;
    std::uint32_t interval_;
};
}  // namespace

PERIMPM_PLUGIN(FractureCriterion, Energy, kParams, "stretched bonds that store more than a critical energy break")
