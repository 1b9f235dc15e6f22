#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "perimpm/error.hpp"
#include "step/transfer.hpp"

namespace perimpm {

namespace {

template <class Real>
void pack(World<Real>& w, Material<Real>& m, TransferBlock<Real>& b, std::size_t first) {
    b.mass = b.volume = nullptr;
    b.size = for_each_placed(m, first, b.size, [&](std::size_t to, std::size_t from) {
        for (int c = 0; c < 3; ++c) b.x[c][to] = w.x[c][m.begin + from], b.v[c][to] = w.v[c][m.begin + from];
    });
}

template <class Real>
void unpack(World<Real>& w, Material<Real>& m, const TransferBlock<Real>& b, std::size_t first, std::size_t size) {
    for_each_placed(m, first, size, [&](std::size_t from, std::size_t to) {
        const std::size_t at = m.begin + to;
        for (int c = 0; c < 3; ++c) w.x[c][at] = b.x[c][from], w.v[c][at] = b.v[c][from];
        for (std::size_t c = 0; b.C && c < 9; ++c) w.C[c][at] = b.C[c][from];
    });
}

}  // namespace

template <class Real>
BlockFindings note_findings(World<Real>& w) {
    const GridMotion& motion = w.motion;
    BlockFindings all;
    for (const BlockFindings& found : w.found) all.add(found);
    if (std::isnan(all.speed2)) {
        w.drift = w.spacing();  // a further step must sort first, which names the particle
        throw SimulationError(
            fmt::format("velocities are no longer finite in step {} (t = {:g} s, dt = {:g} s): the step is unstable; "
                        "lower simulation.safety or dt, or check the material's parameters",
                        motion.step, motion.start, motion.dt));
    }
    w.gathered_speed = std::sqrt(all.speed2);
    // Rounding of x + dt v may move a slow particle farther than dt v.
    w.drift += motion.dt * w.gathered_speed + static_cast<double>(std::numeric_limits<Real>::epsilon()) * w.farthest;
    return all;
}

/// Grid velocities back to the particles, which move with them. Also finds the largest speed, and any that is not
/// finite.
template <class Real>
void gather(World<Real>& w) {
    w.found.resize(w.grid.particle_blocks().size());
    w.threads.run(w.found.size(), [&](std::size_t index) {
        const ParticleBlock& block = w.grid.particle_blocks()[index];
        load_tiles(w, block, w.own_scratch().now);
        double fastest2 = 0;
        for_each_run(w, index, [&](Material<Real>& m, std::size_t first, std::size_t size) {
            TransferBlock<Real> b = make_transfer_block(w, m, block, first, size);
            b.dt = static_cast<Real>(w.motion.dt);
            if (m.has_bonds()) pack(w, m, b, first);
            if (b.size == 0) return;
            w.transfer->gather(b);
            if (m.has_bonds()) unpack(w, m, b, first, size);
            fastest2 = std::isfinite(b.sum2) ? std::max(fastest2, static_cast<double>(b.fastest2)) : std::nan("");
        });
        w.found[index] = {.speed2 = fastest2};
    });
    note_findings(w);
}

template BlockFindings note_findings(World<float>&);
template BlockFindings note_findings(World<double>&);
template void gather(World<float>&);
template void gather(World<double>&);

}  // namespace perimpm
