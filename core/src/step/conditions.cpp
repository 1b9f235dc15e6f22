#include "step/conditions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "perimpm/error.hpp"
#include "step/stages.hpp"

namespace perimpm {

namespace {

/// The factor at time t: linear between the times given, constant before and after.
double factor_at(const ConditionSpec& spec, double t) {
    if (spec.times.empty()) return 1;
    const auto next = std::upper_bound(spec.times.begin(), spec.times.end(), t);
    if (next == spec.times.begin()) return spec.factors.front();
    if (next == spec.times.end()) return spec.factors.back();
    const auto k = static_cast<std::size_t>(next - spec.times.begin());
    const double share = (t - spec.times[k - 1]) / (spec.times[k] - spec.times[k - 1]);
    return spec.factors[k - 1] + share * (spec.factors[k] - spec.factors[k - 1]);
}

/// Notes what the condition's function says at time t; NaN is for the components of a velocity that stay free.
void ask(Condition& c, double t) {
    if (!c.function) return;
    c.function(t, c.id.size(), c.X.data(), c.values.data());
    for (std::size_t i = 0; i < c.values.size(); ++i)
        if (c.spec.drive == Drive::velocity ? std::isinf(c.values[i]) : !std::isfinite(c.values[i]))
            throw SimulationError(fmt::format("{}: the function returned {} for particle {} at t = {:g} s", c.spec.name,
                                              c.values[i], c.id[i / 3], t));
}

/// Component of the condition's value for its particle number i.
double value_of(const Condition& c, std::size_t i, int component) {
    if (c.function) return c.values[3 * i + static_cast<std::size_t>(component)];
    return c.spec.free[component] ? std::numeric_limits<double>::quiet_NaN() : c.spec.value[component];
}

template <class Real>
std::vector<std::uint32_t> particles_of(const World<Real>& w, const ConditionSpec& spec) {
    const double voxel = w.spacing() > 0 ? 0.5 * w.spacing() : std::cbrt(static_cast<double>(w.volume[0]));
    const ShapePtr shape = spec.shape ? build_shape(*spec.shape, w.scene.folder, voxel) : nullptr;
    std::vector<std::uint32_t> id;
    for (std::size_t p = 0; p < w.count; ++p) {
        const auto body = static_cast<std::uint32_t>(
            std::upper_bound(w.body_begin.begin(), w.body_begin.end(), w.id[p]) - w.body_begin.begin() - 1);
        if ((spec.body && *spec.body != body) || (spec.material && *spec.material != w.scene.bodies[body].material))
            continue;
        const Vec3 x(static_cast<double>(w.x[0][p]), static_cast<double>(w.x[1][p]), static_cast<double>(w.x[2][p]));
        if (!shape || shape->signed_distance(x) < 0) id.push_back(w.id[p]);
    }
    std::sort(id.begin(), id.end());
    return id;
}

template <class Real>
void find_slots(World<Real>& w) {
    Conditions<Real>& all = w.conditions;
    for (std::size_t p = 0; p < w.count; ++p) all.slot[w.id[p]] = static_cast<std::uint32_t>(p);
    all.sorts = w.sorts;
    if (all.holds() && w.transfer_needs.grid) prepare_held_nodes(w);
}

}  // namespace

template <class Real>
void add_condition(World<Real>& w, const ConditionSpec& spec, ConditionFunction function) {
    w.defers_gather = false;
    Conditions<Real>& all = w.conditions;
    Condition c{.spec = spec, .function = std::move(function), .id = particles_of(w, spec), .X = {}, .values = {}};
    if (c.id.empty())
        throw InputError(
            spec.source.place.text(),
            fmt::format("{} has no particles: none lies in its shape, body and material at t = 0", spec.name));
    all.slot.resize(w.count), all.held.resize(w.count, Conditions<Real>::kFree);
    find_slots(w);
    double volume = 0;
    for (const std::uint32_t id : c.id) {
        const std::uint32_t p = all.slot[id];
        volume += static_cast<double>(w.volume[p]);
        for (int k = 0; c.function && k < 3; ++k) c.X.push_back(static_cast<double>(w.x[k][p]));
        if (spec.drive != Drive::velocity || all.held[id] != Conditions<Real>::kFree) continue;
        all.held[id] = static_cast<std::uint32_t>(all.id.size());
        all.id.push_back(id);
    }
    c.values.resize(c.X.size());
    c.inverse_volume = 1 / volume;
    all.velocity.resize(3 * all.id.size()), all.start.resize(3 * all.id.size());
    all.list.push_back(std::move(c));
    find_slots(w);
}

/// Loads change the velocities of their particles, which carry them to the grid or move by them; `dt`: the time for which
/// the forces of time t act.
template <class Real>
void apply_loads(World<Real>& w, double t, double dt) {
    Conditions<Real>& all = w.conditions;
    if (all.sorts != w.sorts) find_slots(w);
    for (Condition& c : all.list) {
        if (c.spec.drive == Drive::velocity) continue;
        ask(c, t);
        const double factor = dt * factor_at(c.spec, t);
        for (std::size_t i = 0; i < c.id.size(); ++i) {
            const std::uint32_t p = all.slot[c.id[i]];
            const double specific = static_cast<double>(w.volume[p]) / static_cast<double>(w.mass[p]);
            const double scale = c.spec.drive == Drive::acceleration ? factor
                                 : c.spec.drive == Drive::body_force ? factor * specific
                                                                     : factor * specific * c.inverse_volume;
            for (int k = 0; k < 3; ++k) w.v[k][p] += static_cast<Real>(scale * value_of(c, i, k));
        }
    }
}

/// Held particles get the velocity of time t. Where conditions meet, later ones win.
template <class Real>
void prescribe_velocities(World<Real>& w, double t) {
    Conditions<Real>& all = w.conditions;
    if (!all.holds()) return;
    std::fill(all.velocity.begin(), all.velocity.end(), std::numeric_limits<Real>::quiet_NaN());
    for (Condition& c : all.list) {
        if (c.spec.drive != Drive::velocity) continue;
        ask(c, t);
        const double factor = w.relaxing ? 0 : factor_at(c.spec, t);
        for (std::size_t i = 0; i < c.id.size(); ++i)
            for (int k = 0; k < 3; ++k) {
                const double v = factor * value_of(c, i, k);
                if (!std::isnan(v))
                    all.velocity[3 * all.held[c.id[i]] + static_cast<std::size_t>(k)] = static_cast<Real>(v);
            }
    }
    for (std::size_t h = 0; h < all.id.size(); ++h) {
        const std::uint32_t p = all.slot[all.id[h]];
        double speed2 = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            all.start[3 * h + k] = w.x[k][p];
            const Real v = all.velocity[3 * h + k];
            if (std::isnan(v)) continue;
            w.v[k][p] = v;
            speed2 += static_cast<double>(v) * static_cast<double>(v);
        }
        w.max_speed = std::max(w.max_speed, std::sqrt(speed2));
    }
}

/// After a grid moved all particles: held ones move by what is prescribed.
template <class Real>
void move_held_particles(World<Real>& w) {
    Conditions<Real>& all = w.conditions;
    double fastest2 = 0;
    for (std::size_t h = 0; h < all.id.size(); ++h) {
        const std::uint32_t p = all.slot[all.id[h]];
        double speed2 = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const Real v = all.velocity[3 * h + k];
            if (std::isnan(v)) continue;
            w.x[k][p] = all.start[3 * h + k] + static_cast<Real>(w.dt) * v;
            w.v[k][p] = v;
            speed2 += static_cast<double>(v) * static_cast<double>(v);
        }
        fastest2 = std::max(fastest2, speed2);
    }
    const double faster = std::sqrt(fastest2) - w.max_speed;
    if (faster > 0) w.drift += w.dt * faster, w.max_speed += faster;
}

template void add_condition(World<float>&, const ConditionSpec&, ConditionFunction);
template void add_condition(World<double>&, const ConditionSpec&, ConditionFunction);
template void apply_loads(World<float>&, double, double);
template void apply_loads(World<double>&, double, double);
template void prescribe_velocities(World<float>&, double);
template void prescribe_velocities(World<double>&, double);
template void move_held_particles(World<float>&);
template void move_held_particles(World<double>&);

}  // namespace perimpm
