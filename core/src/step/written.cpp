#include <fmt/format.h>

#include <cmath>

#include "perimpm/error.hpp"
#include "step/world.hpp"

namespace perimpm {

namespace {

template <class Real>
void require_finite(const World<Real>& w, const FieldArray<Real>& field, const char* name, const char* what) {
    for (std::size_t p = 0; p < w.count; ++p)
        for (int c = 0; c < 3; ++c)
            if (!std::isfinite(field[c][p]))
                throw SimulationError(
                    fmt::format("the {} written into '{}' of particle {} is not finite: component {} is {}", what, name,
                                w.id[p], "xyz"[c], field[c][p]));
}

}  // namespace

template <class Real>
void accept_positions(World<Real>& w) {
    require_finite(w, w.x, "x", "position");
    w.drift = w.spacing();
    w.forces_known = false;
    for (Material<Real>& m : w.materials)
        if (m.has_bonds()) pack_positions(w, m);
    measure_bounds(w);
}

template <class Real>
void accept_velocities(World<Real>& w) {
    require_finite(w, w.v, "v", "velocity");
    double fastest2 = 0;
    for (std::size_t p = 0; p < w.count; ++p) {
        double speed2 = 0;
        for (int c = 0; c < 3; ++c) speed2 += static_cast<double>(w.v[c][p]) * static_cast<double>(w.v[c][p]);
        fastest2 = std::max(fastest2, speed2);
    }
    w.set_speed(std::sqrt(fastest2));
}

template void accept_positions(World<float>&);
template void accept_positions(World<double>&);
template void accept_velocities(World<float>&);
template void accept_velocities(World<double>&);

}  // namespace perimpm
