#include "state/grid.hpp"
#include "state/images.hpp"
#include "state/morton.hpp"
#include "support/catch.hpp"

using namespace perimpm;

namespace {

AxisImages::End mirror(std::int32_t half_cells, std::uint8_t flip) { return {true, half_cells, flip}; }

}  // namespace

TEST_CASE("images: a mirror on a node and one midway between two", "[state]") {
    const AxisImages axis{.low = mirror(4, 1), .high = mirror(13, 1)};  // planes at 2 and 6.5
    for (const auto& [i, node, flip] :
         {std::tuple(2, 2, 0), {3, 3, 0}, {6, 6, 0}, {1, 3, 1}, {-1, 5, 1}, {7, 6, 1}, {8, 5, 1}}) {
        CAPTURE(i);
        CHECK(axis(i).node == node);
        CHECK(axis(i).flip == flip);
        CHECK(axis(i).zero == (i == 2 ? 1 : 0));
    }
}

TEST_CASE("images: between two near mirrors an image of an image keeps its sign", "[state]") {
    const AxisImages axis{.low = mirror(0, 4), .high = mirror(2, 4)};  // planes at 0 and 1
    for (int i = -4; i <= 5; ++i) {
        CAPTURE(i);
        const int turns = (i % 4 + 4) % 4;  // the pattern 0, 1, back to 0, (-1 is 1 again) repeats after two lengths
        CHECK(axis(i).node == (turns % 2));
        CHECK(axis(i).zero == 4);
    }
    CHECK(axis(-1).flip == 4);
    CHECK(axis(2).flip == 4);
    CHECK(axis(-2).flip == 0);  // -2 -> 2 -> 0
}

TEST_CASE("images: a periodic axis wraps, also below zero and from a border between nodes", "[state]") {
    for (const std::int32_t low : {-8, -7}) {  // at -4 and -3.5: the first node inside is -4, -3
        const AxisImages axis{.low = {.at = low}, .period = 6};
        const int first = low == -8 ? -4 : -3;
        for (int i = first - 9; i < first + 15; ++i) {
            CHECK((axis(i).node - i) % 6 == 0);
            CHECK(axis(i).node >= first);
            CHECK(axis(i).node < first + 6);
        }
    }
}

TEST_CASE("images: the grid holds every node that stands for another", "[state]") {
    DomainImages images;
    images.axis[0] = {.low = {.at = 0}, .period = 16};
    const std::int32_t last[3] = {3, 0, 0};  // cells 12 to 15: nodes 16 and 17 are images of 0 and 1
    BlockGrid<double> grid;
    grid.rebuild({morton(last)}, false, images);
    std::vector<std::uint32_t> of;
    for (const NodeImage& image : grid.images()) {
        const auto x = [&](std::uint32_t node) {
            const std::uint32_t n = node % kNodesPerBlock;
            return kBlockNodes * grid.coordinate(node / kNodesPerBlock)[0] + static_cast<int>(n / 16);
        };
        CHECK(x(image.node) == x(image.of) + 16);
        CHECK(image.flip == 0);
        of.push_back(image.of);
    }
    CHECK(of.size() == 4 * 12 * 12);  // four planes of nodes beyond the border, in three blocks across each way
    CHECK(std::is_sorted(of.begin(), of.end()));
}
