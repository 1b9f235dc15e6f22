#pragma once

#include <cmath>

#include "perimpm/peridynamics/influence.hpp"
#include "perimpm/peridynamics/weights.hpp"

/*! Parameters that the laws of Lyu et al. 2019 share. */
namespace perimpm::peridynamics {

inline constexpr ParamSpec kAveragedBondParams[] = {
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
    {.key = "formulation",
     .kind = ParamKind::choice,
     .default_text = "variational",
     .choices = "variational|paper",
     .doc = "forces of averaged bonds: from the energy, which conserves energy and angular momentum, or as printed"},
    {.key = "poisson_ratio",
     .range = open(-1, 0.5),
     .default_value = 0.25,
     .doc = "this law has 1/4, 1/3 in a sheet, and no other"},
    horizon_param(),
    horizon_length_param(),
    influence_param(),
    volume_correction_param(),
    surface_param("moment"),
};

/// mu and lambda of the paper [Pa].
struct SpringModuli {
    double mu, lambda;
    double sum() const { return 2 * mu + lambda; }
};

inline void require_own_poisson_ratio(const Params& p, const SpringLattice& lattice) {
    if (!p.given("poisson_ratio")) return;
    if (lattice.d == 1)
        throw InvalidParameter("poisson_ratio", "has no meaning in a strand, which cannot thin: leave it out");
    const bool sheet = lattice.d == 2;
    if (std::abs(p["poisson_ratio"] - lattice.poisson_ratio()) > (sheet ? 1e-3 : 0.0))
        throw InvalidParameter("poisson_ratio",
                               std::string("must be ") + (sheet ? "1/3 in a sheet" : "1/4") +
                                   ", which this law has whatever mu and lambda; pd_lps takes any ratio");
}

inline SpringModuli springs_of(const Params& p) {
    const SpringLattice lattice(p.context());
    require_own_poisson_ratio(p, lattice);
    const bool paper = p.is("calibration", "paper");
    for (const char* key : {"mu", "lambda"})
        if (p.given(key) != paper)
            throw InvalidParameter(
                key, paper ? "is required by calibration = \"paper\"" : "belongs to calibration = \"paper\"");
    for (const char* key : {"youngs_modulus", "bending_ratio"})
        if (paper && p.given(key)) throw InvalidParameter(key, "belongs to calibration = \"modulus\"");
    if (!paper && !p.given("youngs_modulus"))
        throw InvalidParameter("youngs_modulus", "is required by calibration = \"modulus\"");
    const double lambda =
        paper ? p["lambda"] : lattice.modulus_of_young() * p["youngs_modulus"] / (1 + 2 * p["bending_ratio"]);
    const double mu = paper ? p["mu"] : p["bending_ratio"] * lambda;
    if (mu + lambda <= 0) throw InvalidParameter("lambda", "mu and lambda must not both be 0");
    return {mu, lambda};
}

}  // namespace perimpm::peridynamics
