#include <algorithm>
#include <vector>

#include "state/morton.hpp"
#include "support/catch.hpp"

using namespace perimpm;

namespace {

std::uint64_t key(std::int32_t x, std::int32_t y, std::int32_t z) {
    const std::int32_t c[3] = {x, y, z};
    return morton(c);
}

}  // namespace

TEST_CASE("morton: keys decode to the coordinates, negative and extreme ones included", "[state]") {
    const std::int32_t values[] = {-kMortonBias, -1000, -1, 0, 1, 2, 77, 4096, kMortonBias - 1};
    for (const std::int32_t x : values)
        for (const std::int32_t y : values)
            for (const std::int32_t z : values) {
                std::int32_t c[3];
                morton_decode(key(x, y, z), c);
                CHECK((c[0] == x && c[1] == y && c[2] == z));
            }
}

TEST_CASE("morton: the order visits one octant after the other, z first", "[state]") {
    std::vector<std::uint64_t> keys;
    for (int x = 0; x < 2; ++x)
        for (int y = 0; y < 2; ++y)
            for (int z = 0; z < 2; ++z) keys.push_back(key(x, y, z));
    CHECK(std::is_sorted(keys.begin(), keys.end()));
    CHECK(keys.back() - keys.front() == 7);
    CHECK(key(1, 1, 1) < key(0, 0, 2));
    CHECK(key(-1, -1, -1) < key(0, 0, 0));
}
