#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "state/grid.hpp"
#include "state/morton.hpp"
#include "support/catch.hpp"

using namespace perimpm;

namespace {

using Node = std::array<int, 3>;

std::vector<std::uint64_t> keys_of(const std::vector<Node>& blocks) {
    std::vector<std::uint64_t> keys;
    for (const Node& b : blocks) {
        const std::int32_t c[3] = {b[0], b[1], b[2]};
        keys.push_back(morton(c));
    }
    std::sort(keys.begin(), keys.end());
    return keys;
}

/// Global index of the tile's node n.
Node tile_node(const ParticleBlock& block, int n) {
    Node at{n / 64, n / 8 % 8, n % 8};
    for (std::size_t c = 0; c < 3; ++c) at[c] += kBlockNodes * block.coordinate[c] - kTileOffset;
    return at;
}

const std::vector<Node> kBlocks = {{0, 0, 0}, {0, 0, 1}, {1, 1, 1}, {-1, 0, 0}, {5, -7, 2}, {2, 0, 0}};

}  // namespace

TEMPLATE_TEST_CASE("grid: tiles meet on the nodes that they share", "[state]", float, double) {
    BlockGrid<TestType> grid;
    grid.rebuild(keys_of(kBlocks), false);
    for (std::size_t b = 0; b < grid.size(); ++b) std::fill_n(grid.nodes(b), kBlockValues, TestType(0));
    std::map<Node, double> expected;
    AlignedArray<TestType> tile(kTileValues);
    double value = 1;
    for (const ParticleBlock& block : grid.particle_blocks()) {
        for (int n = 0; n < kTileValues / 4; ++n, ++value) {
            expected[tile_node(block, n)] += value;
            for (int c = 0; c < 4; ++c)
                tile[static_cast<std::size_t>(4 * n + c)] = static_cast<TestType>(value * (c + 1));
        }
        grid.add_tile(block, tile.data(), false);
    }
    for (const ParticleBlock& block : grid.particle_blocks()) {
        grid.load_tile(block, tile.data(), false);
        for (int n = 0; n < kTileValues / 4; ++n)
            for (int c = 0; c < 4; ++c)
                CHECK(tile[static_cast<std::size_t>(4 * n + c)] ==
                      static_cast<TestType>(expected[tile_node(block, n)] * (c + 1)));
    }
}

TEST_CASE("grid: a block's nodes lie where its coordinate says, z fastest", "[state]") {
    BlockGrid<double> grid;
    grid.rebuild(keys_of({{3, -2, 1}}), true);
    CHECK(grid.size() == 27);
    const ParticleBlock& block = grid.particle_blocks()[0];
    for (std::size_t b = 0; b < grid.size(); ++b)
        for (int n = 0; n < kNodesPerBlock; ++n)
            for (int c = 0; c < 3; ++c) {
                const int inside[3] = {n / 16, n / 4 % 4, n % 4};
                grid.increments(b)[4 * n + c] = kBlockNodes * grid.coordinate(b)[c] + inside[c];
            }
    AlignedArray<double> tile(kTileValues);
    grid.load_tile(block, tile.data(), true);
    for (int n = 0; n < kTileValues / 4; ++n)
        for (int c = 0; c < 3; ++c)
            CHECK(tile[static_cast<std::size_t>(4 * n + c)] == tile_node(block, n)[static_cast<std::size_t>(c)]);
}

TEST_CASE("grid: of two ranges whose tiles overlap one waits for the other, whoever works", "[state]") {
    for (const int edge : {5, 11}) {  // 1331 blocks are scheduled by cubes of eight
        std::vector<Node> blocks;
        for (int i = 0; i < edge; ++i)
            for (int j = 0; j < edge; ++j)
                for (int k = 0; k < edge; ++k) blocks.push_back({i - 2, j - 2, k - 2});
        std::set<std::pair<std::uint32_t, std::uint32_t>> orders[2];  // (first block of a range, that of one it needs)
        for (const int workers : {1, 3}) {
            BlockGrid<float> grid;
            grid.rebuild(keys_of(blocks), false, {}, false, workers);
            const std::vector<BlockRange>& ranges = grid.ranges();
            const Schedule& schedule = grid.schedule();
            REQUIRE(schedule.queue.size() == static_cast<std::size_t>(workers) + 1);
            REQUIRE(schedule.queue.back() == ranges.size());
            REQUIRE(schedule.row.size() == ranges.size() + 1);
            auto& order = orders[workers > 1];
            for (std::uint32_t r = 0; r < ranges.size(); ++r)
                for (std::uint32_t k = schedule.row[r]; k < schedule.row[r + 1]; ++k)
                    order.emplace(ranges[r].first, ranges[schedule.needed[k]].first);

            std::set<std::uint32_t> seen;
            std::map<Node, std::set<std::uint32_t>> owners;
            for (const BlockRange& range : ranges)
                for (std::uint32_t b = range.first; b < range.end; ++b) {
                    CHECK(seen.insert(b).second);
                    for (int n = 0; n < kTileValues / 4; ++n)
                        owners[tile_node(grid.particle_blocks()[b], n)].insert(range.first);
                }
            CHECK(seen.size() == blocks.size());
            bool each_once = true;
            std::size_t overlaps = 0;
            for (const auto& [node, who] : owners)
                for (const std::uint32_t one : who)
                    for (const std::uint32_t other : who)
                        if (one < other) {
                            ++overlaps;
                            each_once = each_once && order.count({one, other}) + order.count({other, one}) == 1;
                        }
            CHECK(overlaps > 0);
            CHECK(each_once);
            const auto longest = std::max_element(ranges.begin(), ranges.end(), [](const auto& a, const auto& b) {
                return a.end - a.first < b.end - b.first;
            });
            CHECK(longest->end - longest->first == (edge == 5 ? 1 : 8));
        }
        CHECK(orders[0] == orders[1]);
    }
}

TEST_CASE("grid: only blocks that a tile reaches exist", "[state]") {
    BlockGrid<float> grid;
    grid.rebuild(keys_of({{0, 0, 0}, {100000, 0, -100000}}), false);
    CHECK(grid.size() == 54);
    CHECK(grid.bytes() < 2 * 54 * kBlockValues * sizeof(float));
    grid.rebuild(keys_of({{0, 0, 0}, {0, 0, 1}}), false);
    CHECK(grid.size() == 36);
}

TEST_CASE("grid: velocity fields have nodes of their own and know where they meet", "[state]") {
    const auto key = [](std::uint64_t field, const Node& at) {
        const std::int32_t c[3] = {at[0], at[1], at[2]};
        return field << kFieldShift | morton(c);
    };
    // field 1 beside field 0, field 5 far from both
    const std::vector<std::uint64_t> keys = {key(0, {0, 0, 0}), key(1, {2, 0, 0}), key(5, {40, 0, 0})};
    BlockGrid<double> grid;
    grid.rebuild(keys, false);
    CHECK(grid.size() == 3 * 27);
    for (std::size_t b = 0; b < keys.size(); ++b)
        for (std::size_t n = 0; n < kNeighbours; ++n) {
            const std::uint32_t link = grid.particle_blocks()[b].links[n];
            CHECK(link / 27 == b);
        }
    const std::vector<std::uint32_t>& begin = grid.shared_begin();
    REQUIRE(begin.size() == 9 + 1);  // the blocks of the plane x = 1
    for (std::size_t k = 0; k + 1 < begin.size(); ++k) {
        REQUIRE(begin[k + 1] == begin[k] + 2);
        const SharedBlock &one = grid.shared()[begin[k]], &other = grid.shared()[begin[k] + 1];
        CHECK(one.block < 27);
        CHECK(other.block / 27 == 1);
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(grid.coordinate(one.block)[axis] == grid.coordinate(other.block)[axis]);
            for (const int side : {0, 1}) {
                const std::uint32_t beside = one.beside[axis][side];
                const int there = grid.coordinate(one.block)[axis] + 2 * side - 1;
                CHECK((beside == SharedBlock::kNone) == (std::abs(there) > 1));
                if (beside != SharedBlock::kNone) CHECK(grid.coordinate(beside)[axis] == there);
            }
        }
    }
    grid.rebuild({key(0, {0, 0, 0}), key(0, {2, 0, 0})}, false);
    CHECK(grid.shared().empty());
    grid.rebuild({key(0, {0, 0, 0}), key(0, {1, 0, 0}), key(1, {0, 0, 0}), key(1, {1, 0, 0})}, false);
    CHECK(grid.schedule().needed == std::vector<std::uint32_t>{0, 1});  // in order of colours: one for each field
}
