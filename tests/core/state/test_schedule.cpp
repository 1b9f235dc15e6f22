#include <algorithm>
#include <atomic>
#include <stdexcept>
#include <vector>

#include "state/schedule.hpp"
#include "state/threads.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"

using namespace perimpm;

TEST_CASE("schedule: items run once, after those that they need", "[state]") {
    Schedule schedule;
    for (const int count : {1, 2, 4}) {  // each item needs the items of the queue beside its own that come before it
        constexpr std::uint32_t kLength = 50;
        const auto queues = static_cast<std::uint32_t>(count);
        schedule.queue.assign(1, 0), schedule.row.assign(1, 0), schedule.needed.clear();
        for (std::uint32_t q = 0; q < queues; ++q) {
            for (std::uint32_t k = 0; k < kLength; ++k) {
                if (k > 0) schedule.needed.push_back((q + 1) % queues * kLength + k - 1);
                schedule.row.push_back(static_cast<std::uint32_t>(schedule.needed.size()));
            }
            schedule.queue.push_back((q + 1) * kLength);
        }
        Threads threads(count);
        for (int repeat = 0; repeat < 20; ++repeat) {
            std::vector<std::atomic<int>> runs(queues * kLength);
            std::atomic<int> early = 0;
            threads.run(schedule, [&](std::uint32_t i) {
                for (std::uint32_t k = schedule.row[i]; k < schedule.row[i + 1]; ++k)
                    early += runs[schedule.needed[k]] == 0;
                ++runs[i];
            });
            CHECK(early == 0);
            CHECK(std::all_of(runs.begin(), runs.end(), [](const auto& n) { return n == 1; }));
        }
    }
}

TEST_CASE("schedule: one worker does it all, wherever it begins", "[state]") {
    Schedule schedule;
    schedule.queue = {0, 2, 3, 3, 4}, schedule.row = {0, 0, 1, 1, 3}, schedule.needed = {3, 0, 2};
    for (const std::size_t own : {0, 2, 7}) {
        std::vector<std::uint32_t> ran;
        schedule.start();
        schedule.work(own, [&](std::uint32_t item) { ran.push_back(item); });
        REQUIRE(ran.size() == 4);
        const auto place = [&](std::uint32_t item) { return std::find(ran.begin(), ran.end(), item); };
        CHECK(place(0) < place(3));
        CHECK(place(2) < place(3));
        CHECK(place(3) < place(1));
    }
    Schedule empty;
    Threads(2).run(empty, [](std::uint32_t) { FAIL("there is no item"); });
}

TEST_CASE("schedule: an item that throws ends the run, and the schedule can run again", "[state]") {
    Schedule schedule;
    schedule.queue = {0, 2, 4}, schedule.row = {0, 0, 1, 1, 2}, schedule.needed = {0, 0};
    Threads threads(2);
    std::atomic<bool> refuses = true;
    std::atomic<int> ran = 0;
    const auto run = [&] {
        threads.run(schedule, [&](std::uint32_t i) {
            if (i == 0 && refuses) throw std::runtime_error("refused");
            ++ran;
        });
    };
    CHECK(message_of<std::runtime_error>(run) == "refused");
    CHECK(ran <= 1);
    refuses = false, ran = 0;
    run();
    CHECK(ran == 4);
}
