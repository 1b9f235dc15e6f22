/*! Critical stretch (Silling & Askari 2005, section 4): a bond longer than (1 + s0) |X| breaks, for good. Compression breaks
    nothing.
      (1) s = (|Y| - |X|)/|X| > s0 */
#include "perimpm/peridynamics/family.hpp"
#include "perimpm/plugin/plugin.hpp"

namespace {
using namespace perimpm;
using namespace perimpm::peridynamics;

constexpr ParamSpec kParams[] = {
    {.key = "critical_stretch",
     .range = above(0),
     .doc = "a bond breaks when it is longer than 1 + this, times its length at the start"},
    {.key = "interval",
     .kind = ParamKind::integer,
     .unit = "steps",
     .range = at_least(1),
     .default_value = 1,
     .doc = "the criterion is asked every so many steps"},
};

template <class Real>
class CriticalStretch final : public FractureCriterion<Real> {
public:
    explicit CriticalStretch(const Params& p)
        : limit_{static_cast<Real>(1 + p["critical_stretch"])}, interval_{static_cast<std::uint32_t>(p["interval"])} {}
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
                const P longest = limit_ * bonds.load(b.family.length);
                const auto over =
                    live > P(0) && Y[0] * Y[0] + Y[1] * Y[1] + Y[2] * Y[2] > longest * longest;  // (1), squared
                if (any_of(over))
                    for (std::uint32_t lane = 0; lane < bonds.size; ++lane)
                        if (over[lane]) found.add(b.first + i, bonds.slot + lane);
            });
        }
    }

private:
    Real limit_;
    std::uint32_t interval_;
};
}  // namespace

PERIMPM_PLUGIN(FractureCriterion, CriticalStretch, kParams,
               "bonds longer than (1 + s0) times their reference length break")
