/*! Critical stretch (Silling & Askari 2005, section 4): a bond longer than (1 + s0) |X| breaks, for good. Compression breaks
    nothing.
      (1) s = (|Y| - |X|)/|X| > s0
      (2) s0 = sqrt(G_c/g)                                           from the fracture energy G_c
    g is the energy per area of a lattice plane whose bonds are all stretched alike, over the square of the stretch: the law
    sums it over its own bonds (opening_energy in perimpm/peridynamics/family.hpp). For bond-based solids with many neighbours
    that is their eq. 27, s0 = sqrt(5 G_c/(9 K delta)). */
#include <cmath>

#include "perimpm/peridynamics/family.hpp"
#include "perimpm/plugin/plugin.hpp"

namespace {
using namespace perimpm;
using namespace perimpm::peridynamics;

constexpr ParamSpec kParams[] = {
    {.key = "critical_stretch",
     .range = above(0),
     .optional = true,
     .doc = "a bond breaks when it is longer than 1 + this, times its length at the start"},
    {.key = "fracture_energy",
     .unit = "J/m^2",
     .range = above(0),
     .optional = true,
     .doc = "energy per area of crack, instead of critical_stretch, which then follows from the law and its horizon"},
    interval_param(),
};

template <class Real>
class CriticalStretch final : public FractureCriterion<Real> {
public:
    explicit CriticalStretch(const Params& p)
        : limit_{static_cast<Real>(1 + stretch_of(p))}, interval_{static_cast<std::uint32_t>(p["interval"])} {}
    std::uint32_t interval() const noexcept override { return interval_; }
    double harmless_stretch() const noexcept override {
        constexpr double kRounding = 1e-6;  // of (|Y| - |X|)/|Y| in single precision, amply; of |Y|/|X| times that
        const double limit = static_cast<double>(limit_);
        return limit * (1 - kRounding * limit) - 1;
    }

    void screen(const Block<Real>& b, CandidateList& found) const override {
        using P = Pack<Real>;
        for (std::uint32_t i = 0; i < b.size; ++i) {
            const Real* own = b.family.position + 4 * std::size_t{b.first + i};
            for_each_bond(b, i, [&](const BondPack<Real>& bonds, const P& live) PERIMPM_INLINE_LAMBDA {
                P Y[3];
                bonds.difference(b.family.position, own, Y);
                const P longest = limit_ * bonds.length();
                const auto over =
                    live > P(0) && Y[0] * Y[0] + Y[1] * Y[1] + Y[2] * Y[2] > longest * longest;  // (1), squared
                if (any_of(over))
                    for (std::uint32_t lane = 0; lane < bonds.size; ++lane)
                        if (over[lane]) found.add(b.first + i, bonds.slot + lane);
            });
        }
    }

private:
    static double stretch_of(const Params& p) {
        if (p.given("critical_stretch") && p.given("fracture_energy"))
            throw InvalidParameter("critical_stretch", "contradicts fracture_energy: give one of the two");
        if (!p.given("critical_stretch") && !p.given("fracture_energy"))
            throw InvalidParameter("critical_stretch", "or 'fracture_energy' [J/m^2] is required: give one of the two");
        if (p.given("critical_stretch")) return p["critical_stretch"];
        const double opening = p.context().opening_energy;
        if (std::isnan(opening))
            throw InvalidParameter("fracture_energy",
                                   "needs a law that knows the energy of its bonds across a crack, as pd_bond, "
                                   "pd_elastic and pd_lps do: give critical_stretch instead");
        return std::sqrt(p["fracture_energy"] / opening);  // (2)
    }

    Real limit_;
    std::uint32_t interval_;
};
}  // namespace

PERIMPM_PLUGIN(FractureCriterion, CriticalStretch, kParams,
               "bonds longer than (1 + s0) times their reference length break")
