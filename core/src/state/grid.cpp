#include "state/grid.hpp"

#include <algorithm>
#include <cstring>
#include <tuple>
#include <utility>

#include "state/morton.hpp"

namespace perimpm {

namespace {

/// From here on cubes of 2x2x2 blocks are coloured, whose particles follow each other in memory; fewer blocks are spread
/// over the threads one by one.
constexpr std::size_t kManyBlocks = 1024;

/// What a block's four node planes across each axis are images of.
struct BlockImages {
    bool any = false;  ///< some node is an image, or lies on a face
    ImageOf plane[3][kBlockNodes];
    bool reached[3][kBlockNodes];

    BlockImages(const std::int32_t block[3], const DomainImages& images) {
        for (int c = 0; c < 3; ++c)
            for (int n = 0; n < kBlockNodes; ++n) {
                const std::int32_t i = kBlockNodes * block[c] + n;
                reached[c][n] = images.axis[c].within_reach(i);
                plane[c][n] = reached[c][n] ? images.axis[c](i) : ImageOf{i};
                any = any || plane[c][n].node != i || plane[c][n].zero;
            }
    }
};

std::int32_t floor_block(std::int32_t node) { return (node >= 0 ? node : node - kBlockNodes + 1) / kBlockNodes; }

/// Calls body(number of the node in its block, its images by axis) for every node that particles may reach.
template <class Body>
void for_each_reached(const BlockImages& b, Body body) {
    for (int n = 0; n < kNodesPerBlock; ++n) {
        const int at[3] = {n / 16, n / 4 % 4, n % 4};
        if (b.reached[0][at[0]] && b.reached[1][at[1]] && b.reached[2][at[2]])
            body(n, b.plane[0][at[0]], b.plane[1][at[1]], b.plane[2][at[2]]);
    }
}

}  // namespace

template <class Real>
void BlockGrid<Real>::rebuild(const std::vector<std::uint64_t>& keys, bool increment, const DomainImages& images,
                              bool twice, int workers) {
    blocks_.resize(keys.size());
    keys_.clear();
    const auto for_each_neighbour = [](std::uint64_t block, auto body) {
        std::int32_t c[3];
        morton_decode(block, c);
        for (int n = 0; n < static_cast<int>(kNeighbours); ++n) {
            const std::int32_t at[3] = {c[0] + n / 9 - 1, c[1] + n / 3 % 3 - 1, c[2] + n % 3 - 1};
            body(n, field_bits(block) | morton(at));
        }
    };
    for (std::size_t b = 0; b < keys.size(); ++b) {
        morton_decode(keys[b], blocks_[b].coordinate);
        for_each_neighbour(keys[b], [&](int, std::uint64_t key) { keys_.push_back(key); });
    }
    sort_unique(keys_);
    if (images.any()) add_blocks_inside(images);

    coordinates_.resize(3 * keys_.size());
    for (std::size_t g = 0; g < keys_.size(); ++g) morton_decode(keys_[g], coordinates_.data() + 3 * g);
    for (std::size_t b = 0; b < blocks_.size(); ++b)
        for_each_neighbour(keys[b], [&](int n, std::uint64_t key) { blocks_[b].links[n] = block_number(key); });
    find_ranges(keys);
    find_queues(static_cast<std::uint32_t>(workers));
    find_needed();
    images_.clear();
    if (images.any()) find_images(images);
    find_shared();
    const std::size_t needed = keys_.size() * kBlockValues;
    const auto provide = [&](AlignedArray<Real>& values) {
        if (values.size() < needed) values = AlignedArray<Real>(needed + needed / 4);
    };
    provide(values_);
    if (increment) provide(increments_);
    if (twice) provide(next_values_);
    if (twice && increment) provide(next_increments_);
}

template <class Real>
void BlockGrid<Real>::find_ranges(const std::vector<std::uint64_t>& keys) {
    const int shift = keys.size() < kManyBlocks ? 0 : 1;
    ranges_.clear();
    for (std::uint32_t b = 0; b < keys.size(); ++b) {
        const std::int32_t* c = blocks_[b].coordinate;
        if (b > 0 && keys[b] >> 3 * shift == keys[b - 1] >> 3 * shift)
            ranges_.back().end = b + 1;
        else
            ranges_.push_back({b, b + 1, (c[0] >> shift & 1) | (c[1] >> shift & 1) << 1 | (c[2] >> shift & 1) << 2});
    }
}

/// Each worker's queue has the ranges of as many blocks, colour by colour.
template <class Real>
void BlockGrid<Real>::find_queues(std::uint32_t workers) {
    schedule_.queue.assign(1, 0);
    for (std::uint32_t worker = 0; worker < workers; ++worker) {
        const std::uint64_t last = blocks_.size() * (worker + 1) / workers;
        const auto begin = ranges_.begin() + schedule_.queue.back();
        const auto end = std::partition_point(begin, ranges_.end(), [&](const BlockRange& r) { return r.end <= last; });
        schedule_.queue.push_back(static_cast<std::uint32_t>(end - ranges_.begin()));
        std::sort(begin, end, [](const BlockRange& a, const BlockRange& b) {
            return std::pair(a.colour, a.first) < std::pair(b.colour, b.first);
        });
    }
}

/// A range needs those of lower colours beside it.
template <class Real>
void BlockGrid<Real>::find_needed() {
    constexpr std::uint32_t none = ~0u;
    constexpr std::size_t itself = kNeighbours / 2;
    range_of_.assign(keys_.size(), none);
    for (std::uint32_t r = 0; r < ranges_.size(); ++r)
        for (std::uint32_t b = ranges_[r].first; b < ranges_[r].end; ++b) range_of_[blocks_[b].links[itself]] = r;
    schedule_.row.assign(1, 0), schedule_.needed.clear();
    for (const BlockRange& range : ranges_) {
        for (std::uint32_t b = range.first; b < range.end; ++b)
            for (const std::uint32_t link : blocks_[b].links)
                if (const std::uint32_t other = range_of_[link]; other != none && ranges_[other].colour < range.colour)
                    schedule_.needed.push_back(other);
        const auto begin = schedule_.needed.begin() + schedule_.row.back();
        std::sort(begin, schedule_.needed.end());
        schedule_.needed.erase(std::unique(begin, schedule_.needed.end()), schedule_.needed.end());
        schedule_.row.push_back(static_cast<std::uint32_t>(schedule_.needed.size()));
    }
}

template <class Real>
std::uint32_t BlockGrid<Real>::block_number(std::uint64_t key) const {
    return static_cast<std::uint32_t>(std::lower_bound(keys_.begin(), keys_.end(), key) - keys_.begin());
}

/// Nodes behind a face need the nodes that they are images of, at a periodic border on the far side of the domain.
template <class Real>
void BlockGrid<Real>::add_blocks_inside(const DomainImages& images) {
    const std::size_t before = keys_.size();
    for (std::size_t g = 0; g < before; ++g) {
        std::int32_t block[3];
        morton_decode(keys_[g], block);
        const BlockImages own(block, images);
        if (!own.any) continue;
        for_each_reached(own, [&](int, const ImageOf& x, const ImageOf& y, const ImageOf& z) {
            const std::int32_t inside[3] = {floor_block(x.node), floor_block(y.node), floor_block(z.node)};
            const std::uint64_t key = field_bits(keys_[g]) | morton(inside);
            if (key != keys_[g] && key != keys_.back()) keys_.push_back(key);
        });
    }
    sort_unique(keys_);
}

template <class Real>
void BlockGrid<Real>::find_images(const DomainImages& images) {
    for (std::size_t g = 0; g < keys_.size(); ++g) {
        const BlockImages own(coordinate(g), images);
        if (!own.any) continue;
        std::uint64_t key = keys_[g];
        auto number = static_cast<std::uint32_t>(g);
        for_each_reached(own, [&](int n, const ImageOf& x, const ImageOf& y, const ImageOf& z) {
            const std::int32_t inside[3] = {floor_block(x.node), floor_block(y.node), floor_block(z.node)};
            if (const std::uint64_t other = field_bits(key) | morton(inside); other != key)
                key = other, number = block_number(other);
            const auto in_block = [&](const ImageOf& image, int c) { return image.node - kBlockNodes * inside[c]; };
            const NodeImage image{.of = static_cast<std::uint32_t>(kNodesPerBlock * number + 16 * in_block(x, 0) +
                                                                   4 * in_block(y, 1) + in_block(z, 2)),
                                  .node = static_cast<std::uint32_t>(kNodesPerBlock * g + n),
                                  .flip = static_cast<std::uint8_t>(x.flip ^ y.flip ^ z.flip),
                                  .zero = static_cast<std::uint8_t>(x.zero | y.zero | z.zero)};
            if (image.of != image.node || image.zero) images_.push_back(image);
        });
    }
    std::sort(images_.begin(), images_.end(), [](const NodeImage& a, const NodeImage& b) {
        return std::tuple(a.of, a.of == a.node, a.node) < std::tuple(b.of, b.of == b.node, b.node);
    });
}

template <class Real>
void BlockGrid<Real>::find_shared() {
    shared_.clear(), shared_begin_.clear();
    if (keys_.empty() || field_bits(keys_.back()) == 0) return;
    const auto place = [&](const SharedBlock& s) { return keys_[s.block] ^ field_bits(keys_[s.block]); };
    for (std::size_t g = 0; g < keys_.size(); ++g) shared_.push_back({.block = static_cast<std::uint32_t>(g)});
    std::sort(shared_.begin(), shared_.end(), [&](const SharedBlock& a, const SharedBlock& b) {
        return std::pair(place(a), a.block) < std::pair(place(b), b.block);
    });
    std::size_t kept = 0;
    for (std::size_t first = 0, end; first < shared_.size(); first = end) {
        for (end = first + 1; end < shared_.size() && place(shared_[end]) == place(shared_[first]);) ++end;
        if (end == first + 1) continue;
        shared_begin_.push_back(static_cast<std::uint32_t>(kept));
        for (std::size_t k = first; k < end; ++k) shared_[kept++] = shared_[k];
    }
    shared_.resize(kept);
    shared_begin_.push_back(static_cast<std::uint32_t>(kept));
    for (SharedBlock& s : shared_)
        for (int axis = 0; axis < 3; ++axis)
            for (const int side : {0, 1}) {
                std::int32_t at[3] = {coordinate(s.block)[0], coordinate(s.block)[1], coordinate(s.block)[2]};
                at[axis] += 2 * side - 1;
                const std::uint64_t key = field_bits(keys_[s.block]) | morton(at);
                const std::uint32_t found = block_number(key);
                s.beside[axis][side] = found < keys_.size() && keys_[found] == key ? found : SharedBlock::kNone;
            }
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
void BlockGrid<Real>::add_tile_to(const ParticleBlock& block, const Real* tile, Real* values) const {
    for_each_run(block, [&](std::size_t from, std::size_t to, auto count) {
        Real sum[count];
        for (int n = 0; n < count; ++n) sum[n] = values[to + n] + tile[from + n];
        std::memcpy(values + to, sum, sizeof sum);
    });
}

template <class Real>
void BlockGrid<Real>::load_tile(const ParticleBlock& block, Real* tile, bool second) const {
    const Real* values = second ? increments_.data() : values_.data();
    for_each_run(block, [&](std::size_t to, std::size_t from, auto count) {
        std::memcpy(tile + to, values + from, count * sizeof(Real));
    });
}

template class BlockGrid<float>;
template class BlockGrid<double>;

}  // namespace perimpm
