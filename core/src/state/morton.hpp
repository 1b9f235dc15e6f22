#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace perimpm {

/// Spreads the low 18 bits so that two zero bits follow each.
constexpr std::uint64_t spread_bits(std::uint64_t v) {
    v &= 0x3ffff;
    v = (v | v << 32) & 0x001f00000000ffffULL;
    v = (v | v << 16) & 0x001f0000ff0000ffULL;
    v = (v | v << 8) & 0x100f00f00f00f00fULL;
    v = (v | v << 4) & 0x10c30c30c30c30c3ULL;
    return (v | v << 2) & 0x1249249249249249ULL;
}
constexpr std::uint64_t compact_bits(std::uint64_t v) {
    v &= 0x1249249249249249ULL;
    v = (v | v >> 2) & 0x10c30c30c30c30c3ULL;
    v = (v | v >> 4) & 0x100f00f00f00f00fULL;
    v = (v | v >> 8) & 0x001f0000ff0000ffULL;
    v = (v | v >> 16) & 0x001f00000000ffffULL;
    return (v | v >> 32) & 0x3ffff;
}

/// Bits of a key above those of its coordinates: the number of a velocity field.
inline constexpr int kFieldShift = 54;
inline constexpr std::uint32_t kMostFields = 1u << 10;
constexpr std::uint64_t field_bits(std::uint64_t key) { return key >> kFieldShift << kFieldShift; }

inline constexpr std::int32_t kMortonBias = 1 << 17;  ///< coordinates from -bias to bias - 1

/// Farthest cell from the origin that particles on a grid may reach: in single precision positions there are still known
/// to a few thousandths of a cell, as the margin of the tiles requires; in double the keys of blocks (4 cells) set the
/// limit.
template <class Real>
constexpr double farthest_cell() {
    return sizeof(Real) == sizeof(float) ? 32768.0 : 4.0 * (kMortonBias - 2);
}

/// Z-order key (Morton 1966) of three coordinates; neighbours in space are mostly neighbours in memory.
constexpr std::uint64_t morton(const std::int32_t c[3]) {
    return spread_bits(static_cast<std::uint64_t>(c[0] + kMortonBias)) << 2 |
           spread_bits(static_cast<std::uint64_t>(c[1] + kMortonBias)) << 1 |
           spread_bits(static_cast<std::uint64_t>(c[2] + kMortonBias));
}
constexpr void morton_decode(std::uint64_t key, std::int32_t c[3]) {
    c[0] = static_cast<std::int32_t>(compact_bits(key >> 2)) - kMortonBias;
    c[1] = static_cast<std::int32_t>(compact_bits(key >> 1)) - kMortonBias;
    c[2] = static_cast<std::int32_t>(compact_bits(key)) - kMortonBias;
}

inline void sort_unique(std::vector<std::uint64_t>& keys) {
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

}  // namespace perimpm
