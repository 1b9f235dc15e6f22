#pragma once

#include <cstdint>
#include <vector>

namespace perimpm {

/// Particles in the cells about crack surfaces, by a hash of their cells.
template <class Real>
struct ContactCells {
    struct Entry {
        std::uint64_t key;  ///< of its cell
        std::uint32_t particle;
        Real x[3];
    };
    double width = 0;                    ///< of a cell [m]
    std::size_t mask = 0;                ///< of hashes
    std::vector<std::uint32_t> free;     ///< particles at crack surfaces, ascending
    std::vector<char> is_free, near;     ///< by particle; by hash: whether a crack surface may be around
    std::vector<std::uint32_t> begin;    ///< by hash: its first entry, then their number
    std::vector<Entry> entries, found;   ///< by hash and particle; by particle
    std::vector<std::uint32_t> surface;  ///< entries at crack surfaces
};

/// A worker's search for pairs.
template <class Real>
struct ContactSearch {
    std::size_t count = 0;                ///< of particles in the 27 cells about the one searched for
    std::vector<std::uint32_t> particle;  ///< these
    std::vector<Real> x[3], apart2;       ///< where they are [m], and their squared distances [m^2]
    std::vector<char> is_bonded;          ///< by particle: to the one whose pairs are looked for

    void make_room(std::size_t size) {
        if (size <= particle.size()) return;
        particle.resize(2 * size), apart2.resize(2 * size);
        for (std::vector<Real>& coordinate : x) coordinate.resize(2 * size);
    }
};

/// What one piece of the search found: pairs of particles at crack surfaces with anything else.
template <class Real>
struct ContactFinds {
    std::vector<std::uint32_t> count;  ///< of pairs, by particle searched for
    std::vector<std::uint32_t> other;  ///< by pair, as the next two
    std::vector<Real> reach, stiffness;

    void clear() { count.clear(), other.clear(), reach.clear(), stiffness.clear(); }
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

    ContactCells<Real> cells;
    std::vector<ContactFinds<Real>> found;  ///< by piece of the search
    std::vector<std::uint32_t> place;       ///< by particle: number of its pairs, then where its next one goes

    bool valid = false;            ///< false: bonds broke since
    double moved = 0;              ///< how far any particle may have moved since [m]
    std::uint64_t generation = 0;  ///< of the storage
};

}  // namespace perimpm
