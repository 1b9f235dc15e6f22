// Number k of every array holds the value k: what lands where can be read off.
#include <numeric>
#include <set>
#include <vector>

#include "perimpm/math/quads.hpp"
#include "support/catch.hpp"
#include "support/guarded.hpp"

using namespace perimpm;

namespace {

template <class Real>
std::vector<Real> counted(std::size_t size) {
    std::vector<Real> values(size);
    std::iota(values.begin(), values.end(), Real(0));
    return values;
}

}  // namespace

TEMPLATE_TEST_CASE("quads: a transpose exchanges rows and lanes within each group of four, and undoes itself", "[math]",
                   float, double) {
    constexpr std::size_t N = kLanes<TestType>;
    if constexpr (N >= 4) {
        const std::vector<TestType> values = counted<TestType>(4 * N);
        Pack<TestType> rows[4], columns[4], again[4];
        for (std::size_t k = 0; k < 4; ++k)
            rows[k].copy_from(values.data() + k * N, std::experimental::element_aligned);
        transpose_quads<TestType>(rows, columns);
        transpose_quads<TestType>(columns, again);
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t lane = 0; lane < N; ++lane) {
                CAPTURE(k, lane);
                const std::size_t group = lane / 4 * 4;
                CHECK(TestType(columns[k][lane]) == values[lane % 4 * N + group + k]);
                CHECK(TestType(again[k][lane]) == values[k * N + lane]);
            }
    } else {
        SUCCEED("packs narrower than a quad are not transposed");
    }
}

TEMPLATE_TEST_CASE("quads: one quad is repeated, wherever it lies and nothing beside it", "[math]", float, double) {
    const GuardedPage page;
    TestType* const quad = static_cast<TestType*>(page.end()) - 4;
    std::iota(quad, quad + 4, TestType(1));
    const auto check = [](const auto& v, std::size_t lanes) {
        for (std::size_t lane = 0; lane < lanes; ++lane)
            CHECK(TestType(v[lane]) == static_cast<TestType>(lane % 4 + 1));
    };
    check(detail::repeat_quad<TestType, 4>(quad), 4);
    check(detail::repeat_quad<TestType, 8>(quad), 8);
    if constexpr (kLanes<TestType> == 16) check(detail::repeat_quad<TestType, 16>(quad), 16);
    alignas(64) const TestType between[] = {0, 1, 2, 3, 4, 0};
    check(detail::repeat_quad<TestType, 8>(between + 1), 8);
}

TEMPLATE_TEST_CASE("quads: store and load put every lane's quad at its place", "[math]", float, double) {
    constexpr std::size_t N = kLanes<TestType>;
    Pack<TestType> component[4], again[4];
    for (std::size_t c = 0; c < 4; ++c)
        component[c] = Pack<TestType>([&](std::size_t lane) { return static_cast<TestType>(4 * lane + c); });
    std::vector<TestType> memory(6 * N, TestType(-7));
    store_quads<TestType>(memory.data() + N, component);
    load_quads<TestType>(memory.data() + N, again);
    std::set<std::size_t> places;
    for (std::size_t lane = 0; lane < N; ++lane) {
        const std::size_t place = quad_place<TestType>(lane);
        places.insert(place);
        for (std::size_t c = 0; c < 4; ++c) {
            CAPTURE(lane, c);
            CHECK(memory[N + 4 * place + c] == static_cast<TestType>(4 * lane + c));
            CHECK(TestType(again[c][lane]) == static_cast<TestType>(4 * lane + c));
        }
    }
    CHECK(places.size() == N);  // no two lanes share a place, none lies outside
    CHECK(*places.rbegin() == N - 1);
    for (std::size_t k = 0; k < N; ++k) {
        CHECK(memory[k] == TestType(-7));
        CHECK(memory[5 * N + k] == TestType(-7));
    }
}

TEMPLATE_TEST_CASE("quads: a gather takes the quad that each lane names, repeated ones included", "[math]", float,
                   double) {
    constexpr std::size_t N = kLanes<TestType>;
    constexpr std::uint32_t kTrials = 200;
    const GuardedPage page;  // the last quad ends where memory must not be touched
    auto* const quads = static_cast<TestType*>(page.end()) - 4 * 100;
    std::iota(quads, quads + 4 * 100, TestType(0));
    for (std::uint32_t trial = 0; trial < kTrials; ++trial) {
        std::uint32_t entry[N];
        for (std::uint32_t lane = 0; lane < N; ++lane)
            entry[lane] = trial == 0 ? 99 : (37 * trial + 11 * lane * lane) % 100;
        Pack<TestType> component[4];
        gather_quads<4, TestType>(quads, entry, component);
        for (std::size_t lane = 0; lane < N; ++lane)
            for (std::size_t c = 0; c < 4; ++c)
                CHECK(TestType(component[c][lane]) == static_cast<TestType>(4 * entry[lane] + c));
    }
}

TEMPLATE_TEST_CASE("quads: four packs are summed each into its own number", "[math]", float, double) {
    constexpr std::size_t N = kLanes<TestType>;
    Pack<TestType> packs[4];
    for (std::size_t k = 0; k < 4; ++k)
        packs[k] = Pack<TestType>([&](std::size_t lane) { return static_cast<TestType>(1000 * k + lane * lane); });
    TestType sums[4];
    reduce_four<TestType>(packs, sums);
    std::size_t squares = 0;
    for (std::size_t lane = 0; lane < N; ++lane) squares += lane * lane;
    for (std::size_t k = 0; k < 4; ++k) CHECK(sums[k] == static_cast<TestType>(1000 * k * N + squares));
}

TEMPLATE_TEST_CASE("quads: records are summed by weight, for any number of entries", "[math]", float, double) {
    constexpr std::uint32_t kEntries = 30;  // fit into the page
    const GuardedPage page;                 // the last record ends where memory must not be touched
    auto* const records = static_cast<TestType*>(page.end()) - kSumRecord * kEntries;
    for (std::uint32_t k = 0; k < kSumRecord * kEntries; ++k)  // small integers: every sum is exact
        records[k] = static_cast<TestType>((7 * k + k * k) % 23) - 11;
    for (std::uint32_t count = 0; count < 12; ++count) {
        std::uint32_t entry[12];
        for (std::uint32_t k = 0; k < 12; ++k) entry[k] = k == 0 ? kEntries - 1 : (3 * k * k + count) % kEntries;
        const auto weight = [](std::uint32_t k) { return static_cast<TestType>(k % 3); };
        TestType sum[kSumRecord], expected[12] = {};
        sum_records(records, entry, count, weight, sum);
        for (std::uint32_t k = 0; k < count; ++k)
            for (int c = 0; c < 12; ++c) expected[c] += weight(k) * records[kSumRecord * entry[k] + c];
        for (int c = 0; c < 12; ++c) {
            CAPTURE(count, c);
            CHECK(sum[c] == expected[c]);
        }
    }
}
