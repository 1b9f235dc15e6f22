#include <cmath>
#include <limits>

#include "step/stages.hpp"

namespace perimpm {

namespace {

constexpr double kOnFace = 1e-6;  ///< nodes this near to a face, in cells, lie on it

Contact contact_of(Face face) {
    return face == Face::sticky ? Contact::sticky : face == Face::slip ? Contact::slip : Contact::separate;
}

/// Which contacts act: all of them, or only those that hold for good (sticky, slip), without their friction.
enum class Acting { all, lasting };

Vec3 apply_faces(const GridSpec& grid, const DomainImages& images, const Vec3& x, Vec3 v, Acting acting) {
    const double tolerance = kOnFace * grid.spacing, friction = acting == Acting::all ? grid.face_friction : 0.0;
    for (int f = 0; f < 6; ++f) {
        if (!sets_nodes(grid, images, f) || (acting == Acting::lasting && grid.faces[f] == Face::separate)) continue;
        const int axis = f / 2;
        const bool upper = f % 2;
        const bool outside =
            upper ? x[axis] >= grid.domain.max()[axis] - tolerance : x[axis] <= grid.domain.min()[axis] + tolerance;
        if (outside)
            v = resolve_contact(v, Vec3::Unit(axis) * (upper ? -1.0 : 1.0), contact_of(grid.faces[f]), friction);
    }
    return v;
}

template <class Real>
void obey(const World<Real>& w, const NearObstacles& near, const Vec3& x, Real* node, Acting acting) {
    Vec3 v(static_cast<double>(node[0]), static_cast<double>(node[1]), static_cast<double>(node[2]));
    for (const Collider* collider : near.colliders)
        if (collider->signed_distance(x) <= 0)
            v = acting == Acting::all ? collider->resolve(x, v) : collider->hold(x, v);
    if (near.faces) v = apply_faces(w.scene.grid, w.images, x, v, acting);
    for (int c = 0; c < 3; ++c) node[c] = static_cast<Real>(v[c]);
}

/// Returns the square of the largest speed of the block's nodes, infinite when one, or its mass, is not finite.
template <class Real>
double update_block(World<Real>& w, std::size_t g, const NearObstacles& near) {
    const double dx = w.spacing();
    const std::int32_t* coordinate = w.grid.coordinate(g);
    const Real gravity[3] = {static_cast<Real>(w.dt * w.scene.simulation.gravity[0]),
                             static_cast<Real>(w.dt * w.scene.simulation.gravity[1]),
                             static_cast<Real>(w.dt * w.scene.simulation.gravity[2])};
    Real* node = w.grid.nodes(g);
    Real* increment = w.transfer_needs.increment ? w.grid.increments(g) : nullptr;
    const auto decay = static_cast<Real>(std::exp(-w.scene.simulation.damping * w.dt));
    const bool obstacles = near.faces || !near.colliders.empty();
    Real fastest2 = 0;
    for (int n = 0; n < kNodesPerBlock; ++n, node += 4) {
        const Real mass = node[3];
        if (!(mass > 0)) {
            if (std::isnan(mass)) fastest2 = std::numeric_limits<Real>::infinity();
            continue;
        }
        for (int c = 0; c < 3; ++c) {
            node[c] /= mass;
            if (increment) {
                const Real impulse = increment[4 * n + c] / mass;
                increment[4 * n + c] = node[c];  // the velocity before forces
                node[c] += impulse;
            }
            node[c] = decay * (node[c] + gravity[c]);
        }
        if (obstacles) {
            const Vec3 x(dx * (kBlockNodes * coordinate[0] + n / 16), dx * (kBlockNodes * coordinate[1] + n / 4 % 4),
                         dx * (kBlockNodes * coordinate[2] + n % 4));
            obey(w, near, x, node, Acting::all);
            // A clamp took its share of the velocity long ago: without this, FLIP would take it again in every step.
            if (increment) obey(w, near, x, increment + 4 * n, Acting::lasting);
        }
        const Real speed2 = node[0] * node[0] + node[1] * node[1] + node[2] * node[2];
        if (!(speed2 <= fastest2)) fastest2 = std::isnan(speed2) ? std::numeric_limits<Real>::infinity() : speed2;
    }
    return fastest2;
}

template <class Real>
void find_near(const World<Real>& w, std::size_t g, NearObstacles& near) {
    const std::int32_t* c = w.grid.coordinate(g);
    const double dx = w.spacing(), span = dx * (kBlockNodes - 1);
    const Vec3 low = kBlockNodes * dx * Vec3(c[0], c[1], c[2]), high = low + Vec3::Constant(span);
    const GridSpec& grid = w.scene.grid;
    near.faces = grid.bounded && ((low - grid.domain.min()).minCoeff() <= kOnFace * dx ||
                                  (grid.domain.max() - high).minCoeff() <= kOnFace * dx);
    near.colliders.clear();
    const double reach = 0.5 * std::sqrt(3.0) * span;
    for (const Collider& collider : w.colliders)
        if (collider.signed_distance(0.5 * (low + high)) <= reach) near.colliders.push_back(&collider);
}

}  // namespace

/// Momentum to velocity, external forces, then colliders and those of the domain's faces that set nodes one by one.
template <class Real>
void update_grid(World<Real>& w) {
    for (Collider& collider : w.colliders) collider.set_time(w.time + w.dt);
    w.partial.resize(std::max(w.partial.size(), w.grid.size()));
    w.threads.run(w.grid.size(), [&](std::size_t g) {
        NearObstacles& near = w.own_scratch().near;
        find_near(w, g, near);
        w.partial[g] = update_block(w, g, near);
    });
    double fastest2 = 0;
    for (std::size_t g = 0; g < w.grid.size(); ++g) fastest2 = std::max(fastest2, w.partial[g]);
    w.motion = {.step = w.steps + 1, .start = w.time, .dt = w.dt, .fastest = std::sqrt(fastest2), .owed = true};
}

template void update_grid(World<float>&);
template void update_grid(World<double>&);

}  // namespace perimpm
