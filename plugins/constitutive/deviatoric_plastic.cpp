/*! Elastoplastic law of Lyu, Zhang, Chang, Guo, Zhang 2019: pd_elastic whose bonds yield in shear. Equation numbers are the
    paper's; (4) to (7) are in pd_elastic.cpp.
      (8)  e = (|Y| - |X|)/|X| = e_iso + e_dev,  e_iso = theta/3     theta of the family (Silling et al. 2007)
      (9)  T of (6) with e_p |X| taken off both extensions           e_p: permanent strain of the bond
      (10) E_dev = ((2 mu + lambda) w/|X|) (e_dev - e_p),  f = E_dev^2/2 - psi > 0: yields
      (11) De_p = (|X| / ((2 mu + lambda) w)) (E_dev - sqrt(2 psi) sign E_dev)
    Differs from print: (9) prints |Y| for |Y-| in the first term, so that it is not (6) even where nothing has yielded;
    that form is `formulation = "paper"`. (11) prints lambda for (2 mu + lambda) w, which multiplies the excess of |E_dev| over
    sqrt(2 psi) by -2 mu/lambda instead of 0 and diverges from mu = lambda/2 on: `return_mapping = "paper"`.
    `yield_stress` gives psi of each bond so that the bond along a bar in tension yields at that stress: e_dev there is
    sigma/(3 mu_eff) = sigma/(2 mu + lambda). `yield = "family"` and hardening: perimpm/peridynamics/bond_flow.hpp.
    Without yield, and while nothing has yielded (variational form), the law is pd_elastic, bit for bit: the kernel is one. */
#include "perimpm/peridynamics/averaged_bonds.hpp"
#include "perimpm/peridynamics/bond_flow.hpp"
#include "perimpm/plugin/plugin.hpp"

namespace {
using namespace perimpm;
using namespace perimpm::peridynamics;

constexpr ParamSpec kYieldParams[] = {
    yield_stress_param(),
    {.key = "yield_psi",
     .unit = "N^2/m^12",
     .range = at_least(0),
     .optional = true,
     .doc = "energy-like yield constant, as the paper prints it, instead of yield_stress"},
    yield_rule_param("bond"),
    hardening_param(),
    {.key = "return_mapping",
     .kind = ParamKind::choice,
     .default_text = "consistent",
     .choices = "consistent|paper",
     .doc = "how yielding bonds come back: to where they yield, or as printed, which misses it"},
};
constexpr std::size_t kElastic = std::size(kAveragedBondParams), kYield = std::size(kYieldParams);
struct Table {
    ParamSpec at[kElastic + kYield];
};
constexpr Table kTable = [] {
    Table t{};
    for (std::size_t k = 0; k < kElastic; ++k) t.at[k] = kAveragedBondParams[k];
    for (std::size_t k = 0; k < kYield; ++k) t.at[kElastic + k] = kYieldParams[k];
    return t;
}();
constexpr const auto& kParams = kTable.at;

struct Flow : BondFlow {
    Flow(const Params& p, double modulus, double lambda)
        : BondFlow(p, modulus, modulus, factor(p, modulus, lambda), "yield_psi") {}

private:
    /// (11) as printed over the consistent one: (2 mu + lambda) w/lambda, without w, as dimensions demand.
    static double factor(const Params& p, double modulus, double lambda) {
        if (!p.is("return_mapping", "paper")) return 1;
        if (lambda <= 0) throw InvalidParameter("return_mapping", "\"paper\" divides by lambda, which is 0");
        return modulus / lambda;
    }
};

template <class Real>
class DeviatoricPlastic final : public AveragedBonds<Real, Flow> {
    using AveragedBonds<Real, Flow>::AveragedBonds;
};
}  // namespace

PERIMPM_PLUGIN(ConstitutiveLaw, DeviatoricPlastic, kParams,
               "elastoplastic peridynamics of Lyu et al. 2019: pd_elastic whose bonds yield in shear")
