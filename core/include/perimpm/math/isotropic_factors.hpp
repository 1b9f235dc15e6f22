#pragma once

#include <span>

#include "perimpm/export.hpp"

namespace perimpm {

inline constexpr double kLeastFactor = 0.1;  ///< negative weights would make a family's energy indefinite

/// Factors f >= kLeastFactor of positive weights a with which sum a f n n n n comes nearest to isotropic in the span of the
/// directions n, sum a kept; among those the least change, sum a (f - 1)^2. Exact wherever such factors exist. `directions`
/// holds three numbers by weight, of any length. Compiled once: plugins of all instruction sets get the same bits.
PERIMPM_API void isotropic_factors(std::span<const double> directions, std::span<const double> weights,
                                   std::span<double> factors);

}  // namespace perimpm
