#pragma once

#include <cstdint>
#include <vector>

namespace perimpm {

/// Particles that may touch though no bond joins them, at least one of each pair at a crack's surface. Each pair is there
/// twice, so that every particle sums its own forces. Particles by their place in storage.
template <class Real>
struct ContactPairs {
    std::vector<std::uint32_t> particle;  ///< ascending
    std::vector<std::uint32_t> row;       ///< of `particle`: its pairs row[i] .. row[i + 1] - 1
    std::vector<std::uint32_t> other;     ///< by pair
    std::vector<Real> reach;              ///< by pair: distance below which they repel each other [m]
    std::vector<Real> stiffness;          ///< by pair [N/m]

    bool valid = false;            ///< false: bonds broke since
    double moved = 0;              ///< how far any particle may have moved since [m]
    std::uint64_t generation = 0;  ///< of the storage
};

}  // namespace perimpm
