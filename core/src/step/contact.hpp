#pragma once

#include <cstdint>
#include <vector>

namespace perimpm {

/// Particles in the cells about crack surfaces, in a hash table of chains.
struct ContactCells {
    static constexpr std::uint32_t kNone = 0xffffffff;
    double width = 0;                        ///< of a cell [m]
    std::size_t mask = 0;                    ///< of hashes
    std::vector<char> near;                  ///< by hash: whether a crack surface may be around
    std::vector<std::uint32_t> first, next;  ///< by hash, by entry: the first, the next entry of the chain
    std::vector<std::uint32_t> particle;     ///< by entry, ascending
    std::vector<std::uint64_t> key;          ///< by entry: of its cell
};

/// What one piece of the search found.
template <class Real>
struct ContactFinds {
    std::vector<std::uint32_t> particle, count, other;
    std::vector<Real> reach, stiffness;

    void clear() { particle.clear(), count.clear(), other.clear(), reach.clear(), stiffness.clear(); }
};

/// Particles that may touch though no bond joins them, at least one of each pair at a crack's surface. Each pair is there
/// twice, so that every particle sums its own forces. Particles by their place in storage.
template <class Real>
struct ContactPairs {
    std::vector<std::uint32_t> particle;  ///< ascending
    std::vector<std::uint32_t> row;       ///< of `particle`: its pairs row[i] .. row[i + 1] - 1
    std::vector<std::uint32_t> other;     ///< by pair
    std::vector<Real> reach;              ///< by pair: distance below which they repel each other [m]
    std::vector<Real> stiffness;          ///< by pair [N/m]

    ContactCells cells;
    std::vector<ContactFinds<Real>> found;  ///< by piece of the search

    bool valid = false;            ///< false: bonds broke since
    double moved = 0;              ///< how far any particle may have moved since [m]
    std::uint64_t generation = 0;  ///< of the storage
};

}  // namespace perimpm
