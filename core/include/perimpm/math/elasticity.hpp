#pragma once

#include "perimpm/math/simd.hpp"

namespace perimpm {

/// Lamé constants [Pa] from Young's modulus [Pa] and Poisson's ratio.
template <class T>
struct Lame {
    T mu, lambda;
    Lame(const T& youngs_modulus, double poisson_ratio)
        : mu(youngs_modulus * T(Scalar<T>(1 / (2 * (1 + poisson_ratio))))),
          lambda(youngs_modulus * T(Scalar<T>(poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))))) {}
};

/// Isotropic stress over the sum of the strains; in a sheet (dimension 2, plane stress) and a strand (1) of those inside it.
inline constexpr double bulk_modulus(double youngs_modulus, double poisson_ratio, double dimension = 3) {
    return youngs_modulus / (dimension * (1 - (dimension - 1) * poisson_ratio));
}

}  // namespace perimpm
