// kRow with a horizon of 1.1 spacings: particles 0-1-2-3 along x, bonds between neighbours only.
#include <algorithm>
#include <array>
#include <bit>

#include "support/catch.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

std::unique_ptr<World<double>> row(int interval = 1) {
    return box_world({kElastic, kNoGrid, kRow,
                      "material.rubber.fracture={ type = \"critical_stretch\", critical_stretch = 0.5, interval = " +
                          std::to_string(interval) + " }"});
}

/// Index of the particle at place n of the row.
std::size_t member(const World<double>& w, int n) {
    for (std::size_t p = 0; p < w.count; ++p)
        if (std::abs(w.materials[0].reference[4 * p] - 0.05 * (n + 0.5)) < 1e-9) return p;
    return w.count;
}

std::array<std::uint32_t, 4> damage(const World<double>& w) {
    std::array<std::uint32_t, 4> by_place{};
    for (int n = 0; n < 4; ++n) by_place[static_cast<std::size_t>(n)] = w.materials[0].bonds.damage[member(w, n)];
    return by_place;
}

double state(const World<double>& w, const char* name, int n) {
    for (const StateField<double>& s : w.materials[0].particle_state)
        if (std::string(s.spec.name) == name) return s.values[0][member(w, n)];
    return -1;
}

}  // namespace

TEST_CASE("fracture: a bond breaks in both directions, once and for good", "[step]") {
    const auto w = row();
    REQUIRE(w->materials[0].bonds.size() == 6);
    compute_bond_forces(*w);
    CHECK(damage(*w) == std::array<std::uint32_t, 4>{0, 0, 0, 0});
    w->x[0][member(*w, 3)] += 0.04;  // stretch 0.8
    for (int again = 0; again < 2; ++again) {
        compute_bond_forces(*w);
        CHECK(damage(*w) == std::array<std::uint32_t, 4>{0, 0, 1, 1});
        CHECK(std::popcount(w->materials[0].bonds.broken[0]) == 2);
    }
    w->x[0][member(*w, 3)] -= 0.04;
    compute_bond_forces(*w);
    CHECK(damage(*w) == std::array<std::uint32_t, 4>{0, 0, 1, 1});
    w->x[0][member(*w, 0)] -= 0.04;
    compute_bond_forces(*w);
    CHECK(damage(*w) == std::array<std::uint32_t, 4>{1, 1, 1, 1});
}

TEST_CASE("fracture: families that lost bonds get new reference quantities", "[step]") {
    const auto w = row();
    // K = sum w^ V X X^T: neighbours at +-h give the inner ones twice the K_xx of the outer ones, K^+ half as large.
    const double outer = state(*w, "shape_inverse", 0), inner = state(*w, "shape_inverse", 1);
    REQUIRE(outer > 0);
    REQUIRE_THAT(inner, WithinRel(outer / 2, 1e-12));
    w->x[0][member(*w, 3)] += 0.04;
    compute_bond_forces(*w);
    CHECK_THAT(state(*w, "shape_inverse", 2), WithinRel(outer, 1e-12));
    CHECK(state(*w, "shape_inverse", 3) == 0);  // no bond is left: nothing to average
    CHECK(state(*w, "shape_inverse", 0) == outer);
    CHECK(state(*w, "shape_inverse", 1) == inner);
}

TEST_CASE("fracture: a criterion is asked every `interval` steps", "[step]") {
    const auto w = row(3);
    w->x[0][member(*w, 3)] += 0.04;
    for (w->steps = 0; w->steps < 2; ++w->steps) {
        compute_bond_forces(*w);
        CHECK(damage(*w)[3] == 0);
    }
    compute_bond_forces(*w);  // the third step
    CHECK(damage(*w)[3] == 1);
}
