#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "perimpm/error.hpp"
#include "step/stages.hpp"

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

template <class Real>
void require_positive(const World<Real>& w, const AlignedArray<Real>& values, const char* name) {
    for (std::size_t p = 0; p < w.count; ++p)
        if (!(values[p] > 0) || !std::isfinite(values[p]))
            throw SimulationError(
                fmt::format("the {0} written into '{0}' of particle {1} is {2}, but must be finite and "
                            "above 0",
                            name, w.id[p], values[p]));
}

/// Bonds keep what their particles' volumes gave at the start.
template <class Real>
void require_volumes_kept(const World<Real>& w, const Material<Real>& m) {
    for (std::size_t p = 0; p < m.size; ++p)
        if (w.volume[m.begin + p] != m.reference[4 * p + 3])
            throw SimulationError(
                fmt::format("the volume written into 'volume' of particle {} is {:g} m^3, but the bonds of material "
                            "'{}' keep the {:g} "
                            "m^3 of the start: only volumes of local laws may be written",
                            w.id[m.begin + p], w.volume[m.begin + p], m.name, m.reference[4 * p + 3]));
}

/// Stiffness goes with volumes, inertia with masses: the wave speed of the particle that is lightest for its volume.
template <class Real>
double lightness(const World<Real>& w, const Material<Real>& m) {
    double most = 0;
    for (std::size_t p = m.begin; p < m.begin + m.size; ++p)
        most = std::max(most, m.density * static_cast<double>(w.volume[p]) / static_cast<double>(w.mass[p]));
    return std::sqrt(most);
}

}  // namespace

template <class Real>
void accept_positions(World<Real>& w) {
    require_finite(w, w.x, "x", "position");
    w.drift = w.spacing();
    w.forces_known = false;
    for (Material<Real>& m : w.materials)
        if (m.has_bonds()) pack_positions(w, m);
    measure_wave_speed(w);
    measure_extension(w);
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

template <class Real>
void accept_weights(World<Real>& w) {
    require_positive(w, w.mass, "mass");
    require_positive(w, w.volume, "volume");
    for (Material<Real>& m : w.materials) {
        if (m.has_bonds()) require_volumes_kept(w, m);
        m.lightness = lightness(w, m);
    }
    measure_wave_speed(w);
    measure_bond_steps(w);
}

template <class Real>
void accept_deformations(World<Real>& w) {
    for (const Material<Real>& m : w.materials)
        for (std::size_t p = 0; p < m.size && !m.F.empty(); ++p)
            for (int c = 0; c < 9; ++c)
                if (!std::isfinite(m.F[c][p]))
                    throw SimulationError(fmt::format(
                        "the deformation gradient written into 'F' of particle {} is not finite: component {}{} is {}",
                        w.id[m.begin + p], "xyz"[c / 3], "xyz"[c % 3], m.F[c][p]));
    measure_wave_speed(w);
}

template void accept_positions(World<float>&);
template void accept_positions(World<double>&);
template void accept_velocities(World<float>&);
template void accept_velocities(World<double>&);
template void accept_weights(World<float>&);
template void accept_weights(World<double>&);
template void accept_deformations(World<float>&);
template void accept_deformations(World<double>&);

}  // namespace perimpm
