#include <atomic>

#include "state/threads.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"

using namespace perimpm;

TEST_CASE("threads: as many as asked for, 0 for every core, never fewer", "[state]") {
    CHECK(Threads(2).count() == 2);
    CHECK(Threads(0).count() >= 1);
    CHECK(contains(message_of([] { Threads(-3); }), "threads: -3: expected 1 or more"));
}

TEST_CASE("threads: every piece runs once", "[state]") {
    std::atomic<int> sum = 0;
    Threads(2).run(100, [&](std::size_t i) { sum += static_cast<int>(i); });
    CHECK(sum == 4950);
}
