#include <algorithm>

#include "step/stages.hpp"

namespace perimpm {

/// A neighbour's position then costs one load.
template <class Real>
void pack_positions(World<Real>& w, Material<Real>& m) {
    for_each_chunk(w, m, [&](std::size_t, Block<Real>& b) {
        for (std::uint32_t i = 0; i < b.size; ++i)
            for (int c = 0; c < 3; ++c) m.position[4 * std::size_t{b.first + i} + c] = b.x[c][i];
    });
}

template <class Real>
void evaluate_bonds(World<Real>& w, Material<Real>& m, std::size_t chunk, Block<Real>& b) {
    m.law->evaluate(b, static_cast<Real>(w.dt));
    if (m.needs.reports_stretch) m.stretch[chunk] = static_cast<double>(b.largest_stretch);
}

/// Bond laws: family quantities, then forces; each particle writes only its own. Bonds break where their stretches are
/// known, before the forces act.
template <class Real>
void compute_bond_forces(World<Real>& w) {
    for (Material<Real>& m : w.materials) {
        if (!m.has_bonds()) continue;
        w.timer("bond forces", [&] {
            pack_positions(w, m);
            if (m.needs.prepare) for_each_chunk(w, m, [&](std::size_t, Block<Real>& b) { m.law->prepare(b); });
            for_each_chunk(w, m, [&](std::size_t chunk, Block<Real>& b) { evaluate_bonds(w, m, chunk, b); });
        });
        if (m.criterion && (w.steps + 1) % m.criterion->interval() == 0) w.timer("fracture", [&] { fracture(w, m); });
        if (!m.needs.reports_stretch) continue;
        const double stretch = *std::max_element(m.stretch.begin(), m.stretch.end());
        w.extension = std::max(w.extension, 1 - 1 / (1 + stretch));
    }
}

template void pack_positions(World<float>&, Material<float>&);
template void pack_positions(World<double>&, Material<double>&);
template void evaluate_bonds(World<float>&, Material<float>&, std::size_t, Block<float>&);
template void evaluate_bonds(World<double>&, Material<double>&, std::size_t, Block<double>&);
template void compute_bond_forces(World<float>&);
template void compute_bond_forces(World<double>&);

}  // namespace perimpm
