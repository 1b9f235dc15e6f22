// kBox cut in two: particles within the horizon of the cut move by their own forces.
#include "perimpm/error.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

bool free_particle(const World<double>& w, std::size_t p) { return w.materials[0].bonds.damage[p] > 0; }

}  // namespace

TEST_CASE("crack surfaces: their particles are not on the grid, all others are", "[step]") {
    const auto w = box_world({kBonds, kCrack});
    double on_grid = 0;
    for (std::size_t p = 0; p < w->count; ++p) on_grid += free_particle(*w, p) ? 0 : w->mass[p];
    REQUIRE(on_grid > 0);
    REQUIRE(on_grid < 60);  // of 64 kg
    compute_bond_forces(*w);
    scatter(*w);
    CHECK_THAT(node_sums(*w)[3], WithinRel(on_grid, 1e-12));
    const auto kept = box_world({kBonds, kCrack, kOnGrid});
    compute_bond_forces(*kept);
    scatter(*kept);
    CHECK_THAT(node_sums(*kept)[3], WithinRel(64.0, 1e-12));
}

TEST_CASE("crack surfaces: each particle once, by its force, gravity and damping", "[step]") {
    const auto w = box_world({kBonds, kCrack, "simulation.gravity=[0, -10, 0]", "simulation.damping=3.0"});
    w->motion.dt = w->dt;
    for (std::size_t p = 0; p < w->count; ++p) {
        w->v[0][p] = 1;
        w->materials[0].force[2][p] = 7;
    }
    const auto before = w->x[0][0];
    move_crack_surfaces(*w);
    const double decay = std::exp(-3.0 * w->dt);
    for (std::size_t p = 0; p < w->count; ++p) {
        const Vec3 expected = decay * Vec3(1, -10 * w->dt, 7 * w->dt / w->mass[p]);
        CHECK((at(w->v, p) - (free_particle(*w, p) ? expected : Vec3(1, 0, 0))).norm() < 1e-12);
    }
    CHECK_THAT(w->x[0][0], WithinRel(before + (free_particle(*w, 0) ? w->dt * decay : 0.0), 1e-12));
    CHECK_THAT(w->max_speed, WithinRel(decay * Vec3(1, 10 * w->dt, 7 * w->dt / w->mass[0]).norm(), 1e-9));
}

TEST_CASE("crack surfaces: faces of the domain stop them", "[step]") {
    const auto w =
        box_world({kBonds, kCrack, R"(grid.domain={ min = [-1, -1, 0], max = [1, 1, 1], faces = "separate" })"});
    for (std::size_t p = 0; p < w->count; ++p) w->v[2][p] = -0.03 / w->dt;  // through the face z = 0, for the nearest
    move_crack_surfaces(*w);
    for (std::size_t p = 0; p < w->count; ++p)
        if (free_particle(*w, p)) CHECK(w->x[2][p] > 0);
}

TEST_CASE("crack surfaces: the step is what their bonds allow, once there are any", "[step]") {
    const auto whole = box_world({kBonds, kNeverBreaks}), cut = box_world({kBonds, kCrack});
    const double bonds = whole->bond_steps.at(0);
    CHECK(std::isfinite(bonds));
    CHECK(time_step_bound(*cut, cut->wave_speed) == std::min(bonds, time_step_bound(*whole, whole->wave_speed)));
    CHECK(time_step_bound(*box_world({kBonds, kCrack, kOnGrid}), cut->wave_speed) ==
          time_step_bound(*whole, whole->wave_speed));
}

TEST_CASE("crack surfaces: what touches bounds the step, as stiff as its layer whatever its bonds are", "[step]") {
    const auto w = box_world({kBonds, kCrack});
    Material<double>& m = w->materials[0];
    const double c = m.law->max_wave_speed(make_block(*w, m, 0, m.size));
    CHECK_THAT(m.contact_stiffness, WithinRel(0.25 * 1000 * c * c * m.spacing, 1e-12));
    for (std::size_t p = 0; p < w->count; ++p) w->mass[p] /= 1e4;
    measure_bond_steps(*w);
    m.contact_stiffness *= 100;
    const double bonds = w->bond_steps.at(0);
    measure_bond_steps(*w);
    CHECK_THAT(w->bond_steps.at(0), WithinRel(std::sqrt(2 * w->mass[0] / (4 * m.contact_stiffness)), 1e-12));
    CHECK(w->bond_steps.at(0) < bonds);
}

TEST_CASE("crack surfaces: a speed that is not finite ends the run", "[step]") {
    const auto w = box_world({kBonds, kCrack});
    for (std::size_t p = 0; p < w->count; ++p) w->materials[0].force[1][p] = std::nan("");
    CHECK(
        contains(message_of<SimulationError>([&] { move_crack_surfaces(*w); }), "crack surfaces are no longer finite"));
}

TEST_CASE("crack surfaces: what leaves the grid keeps momenta, at little energy (D8c, D8f)", "[step]") {
    const auto w =
        box_world({kBonds, R"(material.rubber.fracture={ type = "critical_stretch", critical_stretch = 0.01 })"});
    for (std::size_t p = 0; p < w->count; ++p) {
        const Vec3 r = at(w->x, p) - Vec3(0.2, 0.2, 0.2), v = Vec3(0, 0.3, 0.1).cross(r);
        for (int c = 0; c < 3; ++c) w->v[c][p] = v[c];
        w->C[6][p] = -0.3, w->C[2][p] = 0.3, w->C[3][p] = 0.1, w->C[1][p] = -0.1;  // of the same spin
        if (r[1] > 0) w->x[1][p] += 0.02;                                          // tears it
    }
    const Ledger before = take_ledger(*w);
    compute_bond_forces(*w);
    REQUIRE(w->has_crack_surfaces);
    const Ledger after = take_ledger(*w);
    for (int c = 0; c < 3; ++c) {
        CHECK_THAT(after.momentum[c], WithinAbs(before.momentum[c], 1e-12));
        CHECK_THAT(after.angular_momentum[c], WithinAbs(before.angular_momentum[c], 1e-12));
    }
    std::size_t left = 0;
    for (std::size_t p = 0; p < w->count; ++p) {
        if (!free_particle(*w, p)) continue;
        ++left;
        for (std::size_t c = 0; c < 9; ++c) CHECK(w->C[c][p] == 0);
    }
    REQUIRE(left > 0);
    REQUIRE(before.elastic > after.elastic);
    CHECK(std::abs(after.kinetic - before.kinetic) <= 1e-3 * (before.elastic - after.elastic));
}
