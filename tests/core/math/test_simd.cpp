#include <vector>

#include "perimpm/math/simd.hpp"
#include "support/catch.hpp"
#include "support/guarded.hpp"

using namespace perimpm;

TEMPLATE_TEST_CASE("simd: a partial store changes the lanes that it names, nothing else", "[math]", float, double) {
    constexpr std::size_t N = kLanes<TestType>;
    const Pack<TestType> pack([](std::size_t lane) { return static_cast<TestType>(lane + 1); });
    for (std::size_t count = 0; count <= N; ++count) {
        std::vector<TestType> memory(3 * N, TestType(-7));
        store(memory.data() + N, pack, count);
        for (std::size_t k = 0; k < memory.size(); ++k) {
            CAPTURE(count, k);
            CHECK(memory[k] == (k >= N && k < N + count ? static_cast<TestType>(k - N + 1) : TestType(-7)));
        }
    }
}

TEMPLATE_TEST_CASE("simd: a partial load holds what it names, then the rest value", "[math]", float, double) {
    constexpr std::size_t N = kLanes<TestType>;
    std::vector<TestType> memory(N);
    for (std::size_t k = 0; k < N; ++k) memory[k] = static_cast<TestType>(k + 1);
    for (std::size_t count = 0; count <= N; ++count) {
        const Pack<TestType> pack = load(memory.data(), count, TestType(9));
        for (std::size_t lane = 0; lane < N; ++lane) {
            CAPTURE(count, lane);
            CHECK(TestType(pack[lane]) == (lane < count ? memory[lane] : TestType(9)));
        }
    }
}

TEMPLATE_TEST_CASE("simd: neither touches memory beyond its count", "[math]", float, double) {
    constexpr std::size_t N = kLanes<TestType>;
    // The numbers end where memory that must not be touched begins: a wider access would end the program.
    const GuardedPage page;
    auto* const end = static_cast<TestType*>(page.end());
    for (std::size_t count = 0; count <= N; ++count) {
        store(end - count, Pack<TestType>(TestType(count)), count);
        const Pack<TestType> pack = load(end - count, count, TestType(-1));
        for (std::size_t lane = 0; lane < N; ++lane)
            CHECK(TestType(pack[lane]) == (lane < count ? TestType(count) : TestType(-1)));
    }
}

TEMPLATE_TEST_CASE("simd: a load between two lanes holds these, then 0", "[math]", float, double) {
    constexpr auto kSize = static_cast<std::ptrdiff_t>(kLanes<TestType>);
    std::vector<TestType> numbers(kLanes<TestType>);
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<TestType>(i + 1);
    for (std::ptrdiff_t begin = -2; begin <= kSize + 2; ++begin)
        for (std::ptrdiff_t end = -2; end <= kSize + 2; ++end) {
            const Pack<TestType> pack = load_between(numbers.data(), begin, end);
            for (std::ptrdiff_t i = 0; i < kSize; ++i)
                CHECK(pack[static_cast<std::size_t>(i)] == (i >= begin && i < end ? static_cast<TestType>(i + 1) : 0));
        }
}

TEMPLATE_TEST_CASE("simd: a rounded product is rounded before it is added", "[math]", float, double) {
    const TestType a = 1 + std::numeric_limits<TestType>::epsilon();
    const volatile TestType square = a * a;
    const Pack<TestType> sum = rounded(Pack<TestType>(a) * Pack<TestType>(a)) - Pack<TestType>(square);
    CHECK(all_of(sum == TestType(0)));
}

TEMPLATE_TEST_CASE("simd: packs select and compare lane by lane, as numbers do", "[math]", float, double) {
    using P = Pack<TestType>;
    const P even([](std::size_t lane) { return static_cast<TestType>(lane % 2 == 0 ? lane : 0); });
    const P odd([](std::size_t lane) { return static_cast<TestType>(lane % 2 == 0 ? 0 : lane); });
    const P both = larger(even, odd);
    for (std::size_t lane = 0; lane < kLanes<TestType>; ++lane) {
        CHECK(TestType(both[lane]) == static_cast<TestType>(lane));
        CHECK(TestType(select(even > odd, P(1), P(2))[lane]) == (lane % 2 == 0 && lane > 0 ? 1 : 2));
    }
    CHECK(larger(TestType(2), TestType(3)) == TestType(3));
    CHECK(all(both >= even));
    CHECK_FALSE(all(both > even));
    for (std::size_t count = 0; count <= kLanes<TestType>; ++count)
        CHECK(static_cast<std::size_t>(popcount(first_lanes<TestType>(count))) == count);
    for (std::uint32_t bits = 0; bits < 1u << kLanes<TestType>; ++bits) {
        const P ones = ones_at<TestType>(bits);
        for (std::uint32_t lane = 0; lane < kLanes<TestType>; ++lane)
            if (TestType(ones[lane]) != static_cast<TestType>(bits >> lane & 1)) FAIL(bits << ", lane " << lane);
    }
}
