// Once warm, a step asks the system for no memory. This program replaces operator new, so that core and plugins call
// the versions below; TBB's own memory does not come from operator new.
#include <tbb/global_control.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <utility>

#include "support/box_scene.hpp"
#include "support/catch.hpp"
#include "support/scene.hpp"

namespace {

std::atomic<long> allocations{0};

void* allocate(std::size_t size, std::size_t alignment) {
    ++allocations;
    void* memory = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
    if (!memory) throw std::bad_alloc();
    return memory;
}

using Next = perimpm::Simulation::Next;

/// Allocations of `steps` steps.
long count(perimpm::Simulation& simulation, int steps, Next next, bool resort = false) {
    const long before = allocations;
    for (int n = 0; n < steps; ++n) {
        if (resort) simulation.written("x");
        simulation.step(1e300, next);
    }
    simulation.settle();
    return allocations - before;
}

}  // namespace

void* operator new(std::size_t size) { return allocate(size, alignof(std::max_align_t)); }
void* operator new[](std::size_t size) { return allocate(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
    return allocate(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
    return allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

TEST_CASE("allocations: those of the core library are counted", "[step]") {
    const perimpm::Simulation simulation(scene_from(kBox), 1);
    const long before = allocations;
    static_cast<void>(simulation.fields());
    CHECK(allocations > before);
}

TEST_CASE("allocations: none in a step once every buffer is warm", "[step]") {
    struct Case {
        const char* name;
        Overrides overrides;
    };
    const Case cases[] = {
        {"local law", {}},
        {"local law, flip", {R"(transfer={ type = "flip" })"}},
        {"bond law", {kBonds}},
        {"bonds that never break", {kBonds, kNeverBreaks}},
        {"no grid", {kBonds, kNeverBreaks, kNoGrid}},
        {"colliders", {kFloor, "simulation.gravity=[0, -10, 0]"}},
        {"colliders without grid", {kBonds, kNoGrid, kFloor, "simulation.gravity=[0, -10, 0]"}},
        {"closed domain", {R"(grid.domain={ min = [-1, -1, -1], max = [1, 1, 1], faces = "sticky" })"}},
        {"periodic domain", {R"(grid.domain={ min = [-1, -1, -1], max = [1, 1, 1], faces = "periodic" })"}},
        {"conditions",
         {R"(condition=[{ clamped = true, shape = { type = "box", min = [-1, -1, -1], max = [0.1, 1, 1] } },
                                      { force = [1, 0, 0], times = [0, 1], factors = [0, 1] }])"}},
    };
    for (const Case& c : cases)
        for (const auto& [threads, next] :
             {std::pair{1, Next::look}, {1, Next::step}, {2, Next::look}, {2, Next::step}}) {
            CAPTURE(c.name, threads, next == Next::step);
            perimpm::Simulation simulation(scene_from(kBox, c.overrides), threads);
            {  // the second worker stays away until all is warm: its buffers must be ready before it comes
                const tbb::global_control alone(tbb::global_control::max_allowed_parallelism, 1);
                count(simulation, 30, next, true);
                count(simulation, 30, next);
            }
            CHECK(count(simulation, 50, next) == 0);
            CHECK(count(simulation, 10, next, true) == 0);
        }
}
