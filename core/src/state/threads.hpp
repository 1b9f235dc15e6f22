#pragma once

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cstddef>

#include "perimpm/error.hpp"
#include "state/schedule.hpp"

namespace perimpm {

/// The simulation's own workers. Results never depend on their number: work is cut into fixed pieces, pieces that write
/// to the same place are ordered by the caller, and sums are taken over pieces in order.
class Threads {
public:
    /// 0: every core.
    explicit Threads(int count) : arena_(concurrency(count)) { arena_.initialize(); }
    int count() const { return arena_.max_concurrency(); }
    /// The calling worker's number, below count().
    static int current() { return tbb::this_task_arena::current_thread_index(); }

    /// Runs body(i) for i below n.
    template <class Body>
    void run(std::size_t n, const Body& body) {
        if (n == 0) return;
        arena_.execute([&] { tbb::parallel_for(std::size_t{0}, n, body); });
    }
    /// Runs body(i) for all items of the schedule.
    template <class Body>
    void run(Schedule& schedule, const Body& body) {
        schedule.start();
        arena_.execute([&] {
            tbb::parallel_for(0, count(), [&](int) { schedule.work(static_cast<std::size_t>(current()), body); });
        });
    }
    template <class Body>
    void execute(const Body& body) {
        arena_.execute(body);
    }

private:
    static int concurrency(int count) {
        if (count < 0)
            throw InputError(fmt::format("threads: {}: expected 1 or more worker threads, or 0 for every core", count));
        return count > 0 ? count : tbb::task_arena::automatic;
    }

    tbb::task_arena arena_;
};

}  // namespace perimpm
