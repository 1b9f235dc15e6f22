#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "perimpm/model/transfer_kernel.hpp"
#include "state/array.hpp"
#include "state/images.hpp"
#include "state/schedule.hpp"

namespace perimpm {

inline constexpr int kBlockNodes = 4;  ///< nodes and cells along a block's edge
inline constexpr int kNodesPerBlock = kBlockNodes * kBlockNodes * kBlockNodes;
inline constexpr std::size_t kBlockValues = 4 * kNodesPerBlock;
inline constexpr std::uint32_t kNeighbours = 27;

/// A cubic block of cells that holds particles, and the grid blocks that its tile overlaps.
struct ParticleBlock {
    std::int32_t coordinate[3];        ///< in blocks
    std::uint32_t links[kNeighbours];  ///< grid blocks at offsets -1, 0, 1, z fastest
};

/// Particle blocks first .. end - 1, which lie side by side in memory. Tiles of different ranges of a colour do not overlap.
struct BlockRange {
    std::uint32_t first, end;
    int colour;
};

/// A grid block at whose place another velocity field has one, too.
struct SharedBlock {
    static constexpr std::uint32_t kNone = ~0u;
    std::uint32_t block;
    std::uint32_t beside[3][2] = {};  ///< the blocks of its field below and above along each axis; kNone
};

/// Sparse grid: only blocks that some particle can reach exist. Nodes of a block: z fastest, four numbers each
/// (momentum or velocity, mass). Layout and tiles as in TransferBlock.
template <class Real>
class BlockGrid {
public:
    /// Rebuilds both lists of blocks from the sorted, unique Morton keys of the blocks that hold particles, which begin with
    /// the number of a velocity field: nodes of different fields are different nodes. Allocates
    /// only when there are more blocks than ever before. With images, the nodes that they stand for exist, too. `twice`:
    /// there are second values for all nodes, which the next step is scattered to before this one's are read. `workers`:
    /// the number of queues of the schedule.
    void rebuild(const std::vector<std::uint64_t>& keys, bool increment, const DomainImages& images = {},
                 bool twice = false, int workers = 1);

    std::size_t size() const { return coordinates_.size() / 3; }
    const std::vector<ParticleBlock>& particle_blocks() const { return blocks_; }
    /// All of particle_blocks().
    const std::vector<BlockRange>& ranges() const { return ranges_; }
    /// Its items are the ranges(). Of two whose tiles overlap, one needs the other, which one does not depend on the number of
    /// workers: each node sees its blocks in the same order.
    Schedule& schedule() { return schedule_; }
    /// Places where blocks of several fields are: from shared_begin()[k] on those of place k, by ascending field; then the
    /// total. Empty with one field.
    const std::vector<SharedBlock>& shared() const { return shared_; }
    const std::vector<std::uint32_t>& shared_begin() const { return shared_begin_; }
    const std::int32_t* coordinate(std::size_t block) const { return coordinates_.data() + 3 * block; }
    Real* nodes(std::size_t block) { return values_.data() + block * kBlockValues; }
    Real* increments(std::size_t block) { return increments_.data() + block * kBlockValues; }
    Real* next_nodes() { return next_values_.data(); }
    Real* next_increments() { return next_increments_.data(); }
    /// The second values become the grid's.
    void swap_nodes() { std::swap(values_, next_values_), std::swap(increments_, next_increments_); }
    /// Nodes on and behind mirrors and periodic borders, in the order of the nodes they stand for; those on a face last.
    const std::vector<NodeImage>& images() const { return images_; }
    Real* node(std::uint32_t number) { return values_.data() + 4 * std::size_t{number}; }
    Real* increment(std::uint32_t number) { return increments_.data() + 4 * std::size_t{number}; }
    std::size_t bytes() const {
        return values_.bytes() + increments_.bytes() + next_values_.bytes() + next_increments_.bytes() +
               images_.capacity() * sizeof(NodeImage) + shared_.capacity() * sizeof(SharedBlock) +
               4 * shared_begin_.capacity();
    }

    /// Adds a tile to the blocks it overlaps; `second`: the increments.
    void add_tile(const ParticleBlock& block, const Real* tile, bool second) {
        add_tile_to(block, tile, second ? increments_.data() : values_.data());
    }
    /// The same to values that are kept elsewhere, kBlockValues by grid block.
    void add_tile_to(const ParticleBlock& block, const Real* tile, Real* values) const;
    void load_tile(const ParticleBlock& block, Real* tile, bool second) const;

private:
    void add_blocks_inside(const DomainImages& images);
    void find_images(const DomainImages& images);
    void find_shared();
    void find_ranges(const std::vector<std::uint64_t>& keys);
    void find_queues(std::uint32_t workers);
    void find_needed();
    std::uint32_t block_number(std::uint64_t key) const;
    template <class Copy>
    void for_each_run(const ParticleBlock& block, Copy copy) const;

    std::vector<ParticleBlock> blocks_;
    std::vector<BlockRange> ranges_;
    std::vector<std::uint32_t> range_of_;  ///< by grid block: the range that holds its particles, if any
    Schedule schedule_;
    std::vector<std::uint64_t> keys_;
    std::vector<std::int32_t> coordinates_;
    std::vector<NodeImage> images_;
    std::vector<SharedBlock> shared_;
    std::vector<std::uint32_t> shared_begin_;
    AlignedArray<Real> values_, increments_, next_values_, next_increments_;
};

extern template class BlockGrid<float>;
extern template class BlockGrid<double>;

}  // namespace perimpm
