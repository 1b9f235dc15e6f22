#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "perimpm/step/simulation.hpp"

namespace perimpm {

struct Progress {
    std::uint32_t frame, frames;  ///< last frame written, frames to write
    std::uint64_t steps, particles;
    double time, end_time;  ///< simulated [s]
    double elapsed;         ///< wall time of this run [s]
};

struct RunOptions {
    std::string folder;        ///< output folder, made when missing; empty: nothing is written
    std::uint32_t frames = 0;  ///< stop at the frame of this number; 0: the scene's end time
    int threads = 0;           ///< as given to the simulation, for run.json; 0: every core
    /// What else run.json shall name beside perimpm's own versions, e.g. {"Python", "3.11.2"}.
    std::vector<std::pair<std::string, std::string>> versions = {};
    /// Called after every step and every frame; false stops the run there.
    std::function<bool(const Progress&)> after_step;
};

/// Number of the last frame of a run to the scene's end.
PERIMPM_API std::uint32_t last_frame(const Scene& scene);

/// Runs to the end: frame 1 at t = 0, then one frame every 1/frame_rate seconds, each reached by equal steps; writes
/// frames, energy.csv and run.json after every frame. In energy.csv total = kinetic + elastic + potential, and
/// dissipated = the first row's total - total: what models, transfers, contact and rounding have taken since, less the
/// work of moving colliders and faces. Returns false when `after_step` stopped it; files stay whole.
/// Goes on from the simulation's time; frames of later times that a former run left in the folder are removed first.
/// Throws SimulationError after dumping the state to `folder`/failed.h5.
PERIMPM_API bool run(Simulation& simulation, const RunOptions& options);

}  // namespace perimpm
