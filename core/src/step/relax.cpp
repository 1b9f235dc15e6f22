#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <type_traits>

#include "perimpm/error.hpp"
#include "step/stages.hpp"

namespace perimpm {

namespace {

template <class Real>
void stop(World<Real>& w) {
    for (int c = 0; c < 3; ++c) std::fill_n(w.v[c], w.count, Real(0));
    for (std::size_t c = 0; c < w.C.components(); ++c) std::fill_n(w.C[c], w.count, Real(0));
    w.set_speed(0);
}

/// Twice the kinetic energy over the mass [m^2/s^2].
template <class Real>
double mean_speed2(World<Real>& w) {
    double sum = 0, mass = 0;
    for (Material<Real>& m : w.materials) {
        sum = reduce_chunks(
            w, m, sum,
            [](Block<Real>& b) {
                double own = 0;
                for (std::uint32_t i = 0; i < b.size; ++i)
                    for (int c = 0; c < 3; ++c)
                        own += static_cast<double>(b.mass[i]) * static_cast<double>(b.v[c][i]) *
                               static_cast<double>(b.v[c][i]);
                return own;
            },
            std::plus<>());
        for (std::size_t p = 0; p < m.size; ++p) mass += static_cast<double>(w.mass[m.begin + p]);
    }
    return sum / mass;
}

}  // namespace

/// Kinetic damping (Cundall 1982; Barnes 1999): all motion is stopped whenever its energy has passed a maximum. The
/// step after a stop shows the unbalanced forces: velocities are then dt times accelerations.
template <class Real>
Relaxation relax(World<Real>& w, double residual, std::uint64_t most_steps, const std::function<void()>& step) {
    if (!(residual > 0)) throw InputError(fmt::format("relax: residual = {:g}: expected a number above 0", residual));
    if (most_steps == 0) throw InputError("relax: expected 1 step or more");
    const double time = w.time;
    double scale = w.scene.simulation.gravity.norm(), before = 0, reached = 0;
    bool stopped = true;
    stop(w);
    w.relaxing = true;
    struct Finally {
        World<Real>& w;
        ~Finally() { w.relaxing = false; }
    } finally{w};
    for (std::uint64_t n = 1; n <= most_steps; ++n) {
        step();
        w.time = time;
        const double speed2 = mean_speed2(w);
        if (stopped) {
            const double acceleration = std::sqrt(speed2) / w.dt;
            scale = std::max(scale, acceleration);
            reached = scale > 0 ? acceleration / scale : 0;
            if (reached <= residual) {
                stop(w);
                return {n, reached};
            }
        }
        stopped = speed2 < before;
        before = stopped ? 0 : speed2;
        if (stopped) stop(w);
    }
    const char* const way =
        std::is_same_v<Real, float> && residual < 1e-3 ? "precision = \"double\"" : "more steps or a larger residual";
    throw SimulationError(fmt::format("no equilibrium within {} steps: the residual is {:g}, asked was {:g}\n  give {}",
                                      most_steps, reached, residual, way));
}

template Relaxation relax(World<float>&, double, std::uint64_t, const std::function<void()>&);
template Relaxation relax(World<double>&, double, std::uint64_t, const std::function<void()>&);

}  // namespace perimpm
