#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "perimpm/error.hpp"
#include "perimpm/peridynamics/family.hpp"
#include "step/stages.hpp"

namespace perimpm {

namespace {

/// The longest of equal steps up to `step` that fill `whole`: what is left of a frame, whose end may then halve a step if the
/// bound shrinks there. A short step at the end of every frame would drive vibrations whose period is a few steps.
double evenly(double step, double whole) {
    constexpr double kRounding = 1e-9, kMany = 1e6;
    const double count = std::ceil((1 - kRounding) * whole / step);
    return count < kMany ? whole / count : step;
}

/// Of the material's law, the smallest over its blocks; that of any stretch where a criterion watches bonds without a grid: of
/// a vibration that is seen every omega dt the peaks are missed by up to 1 - cos(omega dt/2).
template <class Real>
StableStep stable_step(World<Real>& w, Material<Real>& m) {
    std::vector<StableStep> steps(m.chunks());
    for_each_chunk(w, m, [&](std::size_t c, Block<Real>& b) { steps[c] = m.law->stable_step(b); });
    StableStep smallest;
    for (const StableStep& s : steps) smallest = smallest.smaller(s);
    const bool watched = m.criterion && !w.transfer_needs.grid;
    return m.needs.reports_stretch && !watched ? smallest : StableStep{smallest.any_stretch};
}

/// On the way to equilibrium that of any stretch: modes that turn in two steps would turn where all motion is stopped, and
/// keep their energy.
template <class Real>
double bond_bound(const World<Real>& w) {
    return w.bond_steps.at(w.relaxing ? 1 : w.extension);
}

/// Of a particle that touches twelve others, as springs along twelve directions allow (peridynamics::spring_bound). Bonds are
/// gone on the sides where there is contact, so that the smaller of the two bounds holds for both.
template <class Real>
double contact_step(const World<Real>& w, const Material<Real>& m) {
    const auto lightest = *std::min_element(w.mass.data() + m.begin, w.mass.data() + m.begin + m.size);
    return std::sqrt(2 * static_cast<double>(lightest) / (12.0 / 3 * m.contact_stiffness));
}

template <class Real>
std::string bonds_message(const World<Real>& w, const char* whose) {
    return fmt::format("{} bonds, stretched by up to {:.3g} %; {:g} s holds for any stretch", whose,
                       100 * w.extension / (1 - w.extension), w.bond_steps.any_stretch);
}

template <class Real>
std::string excess_message(const World<Real>& w, double dt, double bound) {
    const std::string why =
        w.has_crack_surfaces && bond_bound(w) <= bound ? bonds_message(w, "crack surfaces:")
        : w.transfer_needs.grid
            ? fmt::format("{:g} dx / (c + |v|) with dx = {:g} m, wave speed c = {:g} m/s, |v| = {:g} m/s",
                          w.transfer_needs.courant, w.spacing(), w.wave_speed, fastest_motion(w))
            : bonds_message(w, "the laws'");
    return fmt::format(
        "dt = {:g} s is above the stable step {:g} s ({}); use dt = \"auto\", at most {:.3g}, or allow_unstable_dt = "
        "true",
        dt, bound, why, bound);
}

}  // namespace

template <class Real>
void measure_wave_speed(World<Real>& w) {
    if (!w.transfer_needs.grid) return;
    w.wave_speed = 0;
    for (Material<Real>& m : w.materials)
        w.wave_speed = reduce_chunks(
            w, m, w.wave_speed, [&](Block<Real>& b) { return m.lightness * m.law->max_wave_speed(b); },
            [](double a, double b) { return std::max(a, b); });
}

template <class Real>
double fastest_collider(const World<Real>& w) {
    double speed = 0;
    for (const Collider& collider : w.colliders) speed = std::max(speed, collider.max_speed());
    return speed;
}

template <class Real>
double fastest_motion(const World<Real>& w) {
    return std::max(w.max_speed, fastest_collider(w));
}

template <class Real>
double grid_bound(const World<Real>& w, double wave_speed) {
    return w.transfer_needs.courant * w.spacing() / (wave_speed + fastest_motion(w));
}

template <class Real>
double time_step_bound(const World<Real>& w, double wave_speed) {
    if (!w.transfer_needs.grid) return bond_bound(w);
    const double bound = grid_bound(w, wave_speed);
    return w.has_crack_surfaces ? std::min(bound, bond_bound(w)) : bound;
}

/// The fixed step, or `safety` times the bound. Broken bonds only ever raise the bond bounds, so they are measured once. How
/// far bonds have been stretched so far counts: steps that followed their vibrations would drive them. What a grid's wave
/// speed is measured to be counts from the next step on.
template <class Real>
double choose_time_step(World<Real>& w, double whole) {
    const SimulationSpec& s = w.scene.simulation;
    const double bound = time_step_bound(w, w.wave_speed);
    if (!s.dt && !std::isfinite(bound))
        throw InputError(s.dt_place.text(),
                         "no model bounds the time step (no particle has a bond): give dt in seconds");
    if (s.dt && !s.allow_unstable_dt && !w.relaxing && *s.dt > bound) {
        if (w.steps == 0) throw InputError(s.dt_place.text(), excess_message(w, *s.dt, bound));
        throw SimulationError(fmt::format("step {}: {}", w.steps + 1, excess_message(w, *s.dt, bound)));
    }
    if (measures_now(w) && !w.motion.owed)
        w.timer("time step", [&] {
            for (Material<Real>& m : w.materials)
                if (m.has_bonds()) pack_positions(w, m);
            measure_wave_speed(w);
        });
    double step = s.dt.value_or(s.safety * bound);
    if (w.relaxing) step = std::min(step, s.safety * bound);
    step = evenly(step, whole);
    if (step > bound && w.unstable.step == 0) w.unstable = {w.steps + 1, step, bound};
    return step;
}

template <class Real>
void measure_bond_steps(World<Real>& w) {
    w.bond_steps = {};
    for (Material<Real>& m : w.materials)
        if (!w.transfer_needs.grid || m.frees_crack_surfaces) w.bond_steps = w.bond_steps.smaller(stable_step(w, m));
    for (Material<Real>& m : w.materials)
        if (m.frees_crack_surfaces) w.bond_steps = w.bond_steps.smaller({contact_step(w, m)});
}

template <class Real>
void measure_extension(World<Real>& w) {
    double stretch = 1;
    for (Material<Real>& m : w.materials)
        if (m.needs.reports_stretch)
            stretch = reduce_chunks(
                w, m, stretch, [&](Block<Real>& b) { return peridynamics::largest_stretch(b); },
                [](double a, double b) { return std::max(a, b); });
    w.extension = 1 - 1 / stretch;
}

template void measure_wave_speed(World<float>&);
template void measure_wave_speed(World<double>&);
template void measure_extension(World<float>&);
template void measure_extension(World<double>&);
template void measure_bond_steps(World<float>&);
template void measure_bond_steps(World<double>&);
template double fastest_collider(const World<float>&);
template double fastest_collider(const World<double>&);
template double fastest_motion(const World<float>&);
template double fastest_motion(const World<double>&);
template double grid_bound(const World<float>&, double);
template double grid_bound(const World<double>&, double);
template double time_step_bound(const World<float>&, double);
template double time_step_bound(const World<double>&, double);
template double choose_time_step(World<float>&, double);
template double choose_time_step(World<double>&, double);

}  // namespace perimpm
