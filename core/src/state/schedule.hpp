#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <vector>

namespace perimpm {

/// Items of work in queues, one for each worker. Items of a queue begin in their order, each after others that it needs.
/// A worker whose queue is empty, or has to wait, takes the next item of another.
class Schedule {
public:
    /// Queue q has items queue[q] .. queue[q + 1] - 1; item i needs items needed[row[i]] .. needed[row[i + 1] - 1]. There
    /// must be an order of all items that keeps to both. Allocates only when there is more of something than ever before.
    std::vector<std::uint32_t> queue{0}, row{0}, needed;

    /// Before items can run.
    void start() {
        provide(next_, queues()), provide(done_, queue.back());
        for (std::size_t q = 0; q < queues(); ++q) next_[q] = queue[q];
        for (std::uint32_t i = 0; i < queue.back(); ++i) done_[i] = 0;
        stopped_ = false;
    }
    /// Runs body(item) for items until none is left, beside other workers who do the same. `own`: the queue to begin with,
    /// any number. body must not wait for other tasks of its arena, which might be workers that wait for its item.
    template <class Body>
    void work(std::size_t own, const Body& body) {
        for (bool left = true; left && !stopped_;) {
            left = false;
            bool ran = false;
            for (std::size_t k = 0; k < queues() && !ran; ++k) {
                const std::size_t q = (own + k) % queues();
                left = left || next_[q] < queue[q + 1];
                ran = run_next(q, body);
            }
            if (left && !ran) std::this_thread::yield();
        }
    }

private:
    using Counter = std::atomic<std::uint32_t>;

    std::size_t queues() const { return queue.size() - 1; }
    static void provide(std::vector<Counter>& counters, std::size_t count) {
        if (counters.size() < count) counters = std::vector<Counter>(count + count / 4);
    }
    bool is_ready(std::uint32_t item) const {
        return std::all_of(needed.begin() + row[item], needed.begin() + row[item + 1],
                           [&](std::uint32_t other) { return done_[other] != 0; });
    }
    /// False: nothing is left, or the next item has to wait, or another worker was first.
    template <class Body>
    bool run_next(std::size_t q, const Body& body) {
        std::uint32_t item = next_[q];
        if (item == queue[q + 1] || !is_ready(item) || !next_[q].compare_exchange_strong(item, item + 1)) return false;
        try {
            body(item);
        } catch (...) {
            stopped_ = true;  // what needs this item would wait for ever
            throw;
        }
        done_[item] = 1;
        return true;
    }

    std::vector<Counter> next_, done_;  ///< by queue; by item
    std::atomic<bool> stopped_ = false;
};

}  // namespace perimpm
