#pragma once

#include <type_traits>

#include "perimpm/error.hpp"
#include "perimpm/math/simd.hpp"
#include "perimpm/model/block.hpp"

namespace perimpm {

/// The error of a law that ends at det F = 0; x: where the particle is [m].
[[noreturn]] PERIMPM_API void throw_inverted(const char* law, double det_F, const double x[3]);

/// Throws SimulationError when a particle is crushed to nothing or turned inside out. J: det F of the block's particles
/// from number i on, a number or a pack, positive in missing lanes.
template <class Real, class T>
PERIMPM_INLINE void require_upright(const char* law, const Block<Real>& b, std::size_t i, const T& J) {
    if (all(J > T(0))) [[likely]]
        return;
    double det_F;
    if constexpr (std::is_arithmetic_v<T>) {
        det_F = J;
    } else {
        std::size_t lane = 0;
        while (J[lane] > 0) ++lane;
        det_F = J[lane], i += lane;
    }
    const double x[3] = {double(b.x[0][i]), double(b.x[1][i]), double(b.x[2][i])};
    throw_inverted(law, det_F, x);
}

}  // namespace perimpm
