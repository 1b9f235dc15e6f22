#include "perimpm/io/run.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "perimpm/error.hpp"
#include "record.hpp"

namespace perimpm {
namespace {

/// Shares of a frame that rounding of the simulated time may take.
constexpr double kTimeTolerance = 1e-9;

class Runner {
public:
    Runner(Simulation& simulation, const RunOptions& options)
        : simulation_{simulation},
          options_{options},
          interval_{1.0 / simulation.scene().simulation.frame_rate},
          first_{first_frame()},
          last_{last_frame()},
          record_{simulation, options, first_} {}

    bool run() {
        try {
            const bool finished = run_frames();
            simulation_.settle();
            record_.status(finished ? "done" : "stopped");
            return finished;
        } catch (const std::exception& e) {
            record_.failed(e.what());
            throw;
        }
    }

private:
    /// The first frame at or after the present time: number n stands for t = (n - 1) / frame_rate.
    std::uint32_t first_frame() const {
        return static_cast<std::uint32_t>(std::ceil(simulation_.time() / interval_ - kTimeTolerance)) + 1;
    }

    std::uint32_t last_frame() const {
        return options_.frames > 0 ? options_.frames : perimpm::last_frame(simulation_.scene());
    }

    bool run_frames() {
        for (std::uint32_t frame = first_; frame <= last_; ++frame) {
            if (!advance((frame - 1) * interval_)) return false;
            record_.frame(frame);
            written_ = frame;
            if (!go_on()) return false;
        }
        return options_.frames > 0 || advance(simulation_.scene().simulation.end_time);
    }

    /// Steps to `target` [s].
    bool advance(double target) {
        const auto left = [&] { return target - simulation_.time(); };
        while (left() > kTimeTolerance * interval_) {
            const double before = simulation_.time();
            require_progress(before, simulation_.step(left(), Simulation::Next::step));
            if (!go_on()) return false;
        }
        return true;
    }

    /// A step below the rounding of the time would be repeated for ever.
    void require_progress(double before, double step) const {
        if (simulation_.time() > before) return;
        throw SimulationError(fmt::format(
            "step {}: the time stands still at {:g} s: the stable step has shrunk to {:g} s, so that something "
            "moves or stiffens without bound",
            simulation_.steps(), before, step));
    }

    bool go_on() const { return !options_.after_step || options_.after_step(progress()); }

    Progress progress() const {
        const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
        return {written_,
                last_,
                simulation_.steps(),
                simulation_.particle_count(),
                simulation_.time(),
                (last_ - 1) * interval_,
                elapsed.count()};
    }

    Simulation& simulation_;
    const RunOptions& options_;
    double interval_;  ///< between frames [s]
    std::uint32_t first_, last_;
    RunRecord record_;
    std::uint32_t written_ = 0;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

std::uint32_t last_frame(const Scene& scene) {
    const double interval = 1.0 / scene.simulation.frame_rate;
    return static_cast<std::uint32_t>(std::floor(scene.simulation.end_time / interval + kTimeTolerance)) + 1;
}

bool run(Simulation& simulation, const RunOptions& options) { return Runner(simulation, options).run(); }

}  // namespace perimpm
