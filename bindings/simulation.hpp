#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "perimpm/step/simulation.hpp"

namespace perimpm::python {

/// A simulation as Python holds it: one thread at a time.
class SharedSimulation {
public:
    SharedSimulation(Scene scene, int threads) : threads_{threads}, simulation_{std::move(scene), threads} {}

    int threads() const { return threads_; }
    /// Throws std::runtime_error when another thread is using this simulation.
    std::unique_lock<std::recursive_mutex> lock();
    Simulation& get() { return simulation_; }

    std::size_t added = 0;  ///< conditions beyond those of the scene

private:
    int threads_;
    std::recursive_mutex mutex_;
    Simulation simulation_;
};

}  // namespace perimpm::python
