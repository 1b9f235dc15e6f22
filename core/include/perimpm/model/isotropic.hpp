#pragma once

#include <algorithm>

#include "perimpm/math/elasticity.hpp"
#include "perimpm/math/mat3.hpp"
#include "perimpm/model/block.hpp"
#include "perimpm/model/params.hpp"

/*! What isotropic local laws share: their two elastic parameters, and walking through a block in packs of particles. */
namespace perimpm {

inline constexpr ParamSpec kYoungsModulusParam = {.key = "youngs_modulus",
                                                  .unit = "Pa",
                                                  .range = above(0),
                                                  .per_particle = true,
                                                  .doc = "Young's modulus at small strain, the stiffness in tension"};
inline constexpr ParamSpec kPoissonRatioParam = {
    .key = "poisson_ratio",
    .range = open(-1, 0.5),
    .default_value = 0.25,
    .doc = "Poisson's ratio at small strain: how much a stretched bar thins; 0.5 would keep its volume"};

struct IsotropicModuli {
    double youngs_modulus;  ///< where it does not vary [Pa]
    double poisson_ratio;

    explicit IsotropicModuli(const Params& p)
        : youngs_modulus{p["youngs_modulus"]}, poisson_ratio{p["poisson_ratio"]} {}
};

/// Calls body(first particle, count, F, Lame's constants) for the packs of a block. Missing lanes hold the identity and the
/// modulus 0. `varying`: Young's modulus by particle [Pa], or null.
template <class Real, class Body>
PERIMPM_INLINE void for_each_pack(const Block<Real>& b, const IsotropicModuli& moduli, const Real* varying, Body body) {
    using P = Pack<Real>;
    const Lame<P> uniform(P(static_cast<Real>(moduli.youngs_modulus)), moduli.poisson_ratio);
    for (std::size_t i = 0; i < b.size; i += kLanes<Real>) {
        const std::size_t count = std::min(kLanes<Real>, b.size - i);
        Mat3<P> F;
        for (int c = 0; c < 9; ++c) F.m[c] = load(b.F[c] + i, count, c % 4 == 0 ? Real(1) : Real(0));
        body(i, count, F, varying ? Lame<P>(load(varying + i, count), moduli.poisson_ratio) : uniform);
    }
}

}  // namespace perimpm
