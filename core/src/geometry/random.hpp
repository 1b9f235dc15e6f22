#pragma once

#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace perimpm {

/// std::uniform_real_distribution and std::shuffle differ between standard libraries; the raw engine does not.
class Random {
public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}
    double unit() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }  // [0, 1)
    template <class T>
    std::vector<T> shuffled(std::vector<T> items) {
        for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[engine_() % i]);
        return items;
    }

private:
    std::mt19937_64 engine_;
};

}  // namespace perimpm
