#include "state/grid.hpp"

#include <algorithm>

#include "state/morton.hpp"

namespace perimpm {

namespace {

/// From here on cubes of 2x2x2 blocks are coloured, whose particles follow each other in memory; fewer blocks are spread
/// over the threads one by one.
constexpr std::size_t kManyBlocks = 1024;

}  // namespace

template <class Real>
void BlockGrid<Real>::rebuild(const std::vector<std::uint64_t>& keys, bool increment) {
    blocks_.resize(keys.size());
    keys_.clear();
    const auto for_each_neighbour = [](const std::int32_t c[3], auto body) {
        for (int n = 0; n < static_cast<int>(kNeighbours); ++n) {
            const std::int32_t at[3] = {c[0] + n / 9 - 1, c[1] + n / 3 % 3 - 1, c[2] + n % 3 - 1};
            body(n, morton(at));
        }
    };
    for (std::size_t b = 0; b < keys.size(); ++b) {
        morton_decode(keys[b], blocks_[b].coordinate);
        for_each_neighbour(blocks_[b].coordinate, [&](int, std::uint64_t key) { keys_.push_back(key); });
    }
    std::sort(keys_.begin(), keys_.end());
    keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());

    coordinates_.resize(3 * keys_.size());
    for (std::size_t g = 0; g < keys_.size(); ++g) morton_decode(keys_[g], coordinates_.data() + 3 * g);
    for (auto& set : colours_) set.clear();
    const int shift = keys.size() < kManyBlocks ? 0 : 1;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
        const std::int32_t* c = blocks_[b].coordinate;
        for_each_neighbour(c, [&](int n, std::uint64_t key) {
            blocks_[b].links[n] =
                static_cast<std::uint32_t>(std::lower_bound(keys_.begin(), keys_.end(), key) - keys_.begin());
        });
        const int parity = (c[0] >> shift & 1) | (c[1] >> shift & 1) << 1 | (c[2] >> shift & 1) << 2;
        std::vector<BlockRange>& ranges = colours_[parity];
        const auto index = static_cast<std::uint32_t>(b);
        if (b > 0 && keys[b] >> 3 * shift == keys[b - 1] >> 3 * shift)
            ranges.back().end = index + 1;
        else
            ranges.push_back({index, index + 1});
    }
    const std::size_t needed = keys_.size() * kBlockValues;
    if (values_.size() < needed) values_ = AlignedArray<Real>(needed + needed / 4);
    if (increment && increments_.size() < needed) increments_ = AlignedArray<Real>(needed + needed / 4);
}

/// A tile starts kTileOffset nodes below its block: each row of eight nodes consists of two, four and two nodes of
/// three blocks. copy(tile offset, grid offset, count), all in numbers, the count a constant.
template <class Real>
template <class Copy>
void BlockGrid<Real>::for_each_run(const ParticleBlock& block, Copy copy) const {
    constexpr int shift = kBlockNodes - kTileOffset;  // node i of the tile is node (i + shift) of the 3-block span
    for (int i = 0; i < kTileNodes; ++i)
        for (int j = 0; j < kTileNodes; ++j) {
            const int bi = (i + shift) / kBlockNodes, bj = (j + shift) / kBlockNodes;
            const std::uint32_t* links = block.links + 9 * bi + 3 * bj;
            const std::size_t row =
                4 * (((i + shift) % kBlockNodes) * kBlockNodes + (j + shift) % kBlockNodes) * kBlockNodes;
            const std::size_t tile = 4 * (i * kTileNodes + j) * kTileNodes;
            constexpr std::integral_constant<int, 4 * kTileOffset> side;
            constexpr std::integral_constant<int, 4 * kBlockNodes> middle;
            copy(tile, links[0] * kBlockValues + row + 4 * shift, side);
            copy(tile + side, links[1] * kBlockValues + row, middle);
            copy(tile + side + middle, links[2] * kBlockValues + row, side);
        }
}

template <class Real>
void BlockGrid<Real>::add_tile(const ParticleBlock& block, const Real* tile, bool second) {
    Real* values = second ? increments_.data() : values_.data();
    for_each_run(block, [&](std::size_t from, std::size_t to, auto count) {
        Real sum[count];
        for (int n = 0; n < count; ++n) sum[n] = values[to + n] + tile[from + n];
        std::copy_n(sum, count(), values + to);
    });
}

template <class Real>
void BlockGrid<Real>::load_tile(const ParticleBlock& block, Real* tile, bool second) const {
    const Real* values = second ? increments_.data() : values_.data();
    for_each_run(block,
                 [&](std::size_t to, std::size_t from, auto count) { std::copy_n(values + from, count(), tile + to); });
}

template class BlockGrid<float>;
template class BlockGrid<double>;

}  // namespace perimpm
