// What the machine can do, as far as the two workloads of `perimpm bench throughput` ask for it. Prints one line of JSON.
//   c++ -std=c++20 -O3 -march=native -ffp-contract=fast -pthread limits.cpp -o limits && ./limits THREADS [SIDE]
// SIDE: particles along an edge of the lattice whose neighbours are loaded.
// Every number is the best of several runs: a limit, not a typical value. Thread k runs on the k-th permitted processor.
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <barrier>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <experimental/simd>
#include <thread>
#include <vector>

namespace {

namespace simd = std::experimental;
volatile double sink;  // keeps results alive

void pin(unsigned which) {
    cpu_set_t allowed, one;
    CPU_ZERO(&one);
    sched_getaffinity(0, sizeof allowed, &allowed);
    for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu)
        if (CPU_ISSET(cpu, &allowed) && which-- == 0) CPU_SET(cpu, &one);
    if (CPU_COUNT(&one) == 1) pthread_setaffinity_np(pthread_self(), sizeof one, &one);
}

/// Wall time [s] of work(thread) on all threads at once, from the common start to the last end; best of `runs`.
template <class Work>
double best_seconds(unsigned threads, int runs, const Work& work) {
    using Clock = std::chrono::steady_clock;
    Clock::time_point start;
    double best = 1e300;
    std::barrier begin(threads, [&]() noexcept { start = Clock::now(); });
    std::barrier end(threads, [&]() noexcept {
        best = std::min(best, std::chrono::duration<double>(Clock::now() - start).count());
    });
    std::vector<std::jthread> pool;
    for (unsigned t = 0; t < threads; ++t)
        pool.emplace_back([&, t] {
            pin(t);
            for (int run = 0; run < runs; ++run) {
                begin.arrive_and_wait();
                work(t);
                end.arrive_and_wait();
            }
        });
    pool.clear();  // joins
    return best;
}

/// [first, last) of thread t.
std::array<std::size_t, 2> share(std::size_t count, unsigned t, unsigned threads) {
    return {count * t / threads, count * (t + 1) / threads};
}

/// Bytes per second of a sum over `count` doubles, and of updating them in place (8 bytes read, 8 written).
std::array<double, 2> bandwidth(unsigned threads, std::size_t count) {
    using V = simd::native_simd<double>;
    std::vector<double> a(count, 1.0);
    const auto part = [&](unsigned t) {
        auto [first, last] = share(count / 64, t, threads);
        return std::array{a.data() + 64 * first, a.data() + 64 * last};
    };
    const double read = best_seconds(threads, 7, [&](unsigned t) {
        V sums[4] = {0, 0, 0, 0};
        auto [x, end] = part(t);
        for (; x != end; x += 4 * V::size())
            for (std::size_t k = 0; k < 4; ++k) sums[k] += V(x + k * V::size(), simd::element_aligned);
        sink = simd::reduce(sums[0] + sums[1] + sums[2] + sums[3]);
    });
    const double update = best_seconds(threads, 7, [&](unsigned t) {
        auto [x, end] = part(t);
        for (; x != end; x += V::size()) {
            V v(x, simd::element_aligned);
            v = v * 0.5 + 0.5;
            v.copy_to(x, simd::element_aligned);
        }
    });
    return {8.0 * static_cast<double>(count) / read, 16.0 * static_cast<double>(count) / update};
}

/// Additions and multiplications per second in independent chains of fused operations.
template <class Real>
double flops(unsigned threads) {
    using V = simd::native_simd<Real>;
    constexpr std::size_t kChains = 12;
    constexpr long kSteps = 10'000'000;
    const double seconds = best_seconds(threads, 5, [&](unsigned t) {
        V chain[kChains];
        for (std::size_t k = 0; k < kChains; ++k) chain[k] = Real(1) + Real(0.01) * static_cast<Real>(k + t);
        const V factor = Real(0.999999), term = Real(1e-7);
        for (long step = 0; step < kSteps; ++step)
            for (V& c : chain) c = c * factor + term;
        V sum = 0;
        for (const V& c : chain) sum += c;
        sink = static_cast<double>(simd::reduce(sum));
    });
    return 2.0 * static_cast<double>(V::size() * kChains * kSteps * threads) / seconds;
}

/// The families of a cubic lattice, horizon 3.015 spacings, particles in Morton order.
struct Lattice {
    std::vector<std::uint32_t> row{0}, neighbour;
};

std::uint32_t morton(std::array<int, 3> cell) {
    std::uint32_t code = 0;
    for (unsigned bit = 0; bit < 10; ++bit)
        for (unsigned axis = 0; axis < 3; ++axis)
            code |= ((static_cast<std::uint32_t>(cell[axis]) >> bit) & 1u) << (3 * bit + axis);
    return code;
}

Lattice lattice(int side) {
    std::vector<std::array<int, 3>> cells;
    for (int x = 0; x < side; ++x)
        for (int y = 0; y < side; ++y)
            for (int z = 0; z < side; ++z) cells.push_back({x, y, z});
    const auto index = [side](int x, int y, int z) { return static_cast<std::size_t>((x * side + y) * side + z); };
    const auto inside = [side](int c) { return c >= 0 && c < side; };
    std::sort(cells.begin(), cells.end(), [](const auto& a, const auto& b) { return morton(a) < morton(b); });
    std::vector<std::uint32_t> place(cells.size());
    for (std::uint32_t p = 0; p < cells.size(); ++p) place[index(cells[p][0], cells[p][1], cells[p][2])] = p;
    Lattice result;
    for (const auto& [x, y, z] : cells) {
        for (int i = -3; i <= 3; ++i)
            for (int j = -3; j <= 3; ++j)
                for (int k = -3; k <= 3; ++k) {
                    const int square = i * i + j * j + k * k;
                    if (square == 0 || square > 9 || !inside(x + i) || !inside(y + j) || !inside(z + k)) continue;
                    result.neighbour.push_back(place[index(x + i, y + j, z + k)]);
                }
        // Ascending, as an engine would store them: neighbours in memory follow each other.
        std::sort(result.neighbour.begin() + result.row.back(), result.neighbour.end());
        result.row.push_back(static_cast<std::uint32_t>(result.neighbour.size()));
    }
    return result;
}

/// Seconds per bond for loading the neighbour's position as one quad, and the sum over the family.
template <class Real>
double quad_load(unsigned threads, const Lattice& l) {
    using V = simd::fixed_size_simd<Real, 4>;
    const std::size_t count = l.row.size() - 1;
    std::vector<Real> quads(4 * count, Real(1.25));
    const double seconds = best_seconds(threads, 9, [&](unsigned t) {
        auto [first, last] = share(count, t, threads);
        V sums[4] = {0, 0, 0, 0};
        for (std::size_t p = first; p < last; ++p) {
            const std::uint32_t* n = l.neighbour.data() + l.row[p];
            const std::uint32_t* end = l.neighbour.data() + l.row[p + 1];
            for (; end - n >= 4; n += 4)
                for (std::size_t k = 0; k < 4; ++k) sums[k] += V(&quads[4 * n[k]], simd::element_aligned);
            for (; n != end; ++n) sums[0] += V(&quads[4 * *n], simd::element_aligned);
        }
        sink = static_cast<double>(simd::reduce(sums[0] + sums[1] + sums[2] + sums[3]));
    });
    return seconds / static_cast<double>(l.neighbour.size());
}

}  // namespace

int main(int argc, char** argv) {
    const int threads = argc > 1 ? std::atoi(argv[1]) : 1;
    const int side = argc > 2 ? std::atoi(argv[2]) : 46;
    if (threads < 1 || side < 4 || side > 1024)
        return std::fputs("usage: limits THREADS [SIDE], 1 or more threads, SIDE from 4 to 1024\n", stderr), 2;
    const auto t = static_cast<unsigned>(threads);
    const auto [read, update] = bandwidth(t, std::size_t(1) << 27);  // 1 GiB: no cache holds it
    const Lattice families = lattice(side);
    std::printf(
        "{\"threads\": %d, \"side\": %d, \"read_GBs\": %.4g, \"update_GBs\": %.4g, \"float_GFlops\": %.4g, "
        "\"double_GFlops\": %.4g, "
        "\"float_quad_ns\": %.4g, \"double_quad_ns\": %.4g}\n",
        threads, side, 1e-9 * read, 1e-9 * update, 1e-9 * flops<float>(t), 1e-9 * flops<double>(t),
        1e9 * quad_load<float>(t, families), 1e9 * quad_load<double>(t, families));
}
