// kBox cut in two, whose halves are moved by hand.
#include "support/catch.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

constexpr double kH = 0.05;

/// Moves the upper half by `by` and takes one step's contact. Returns the momentum given to the upper half.
Vec3 push(World<double>& w, const Vec3& by) {
    for (std::size_t p = 0; p < w.count; ++p)
        for (int c = 0; c < 3; ++c) {
            if (w.x[1][p] > 0.2) w.x[c][p] += by[c];
            w.v[c][p] = 0;
        }
    apply_contact(w);
    Vec3 upper = Vec3::Zero(), all = Vec3::Zero();
    for (std::size_t p = 0; p < w.count; ++p) {
        const Vec3 momentum = w.mass[p] * at(w.v, p);
        all += momentum;
        if (w.materials[0].reference[4 * p + 1] > 0.2) upper += momentum;
    }
    CHECK(all.norm() <= 1e-12 * (1 + upper.norm()));
    return upper;
}

}  // namespace

TEST_CASE("contact: a crack that has not opened pushes nothing, nor one that has", "[step]") {
    CHECK(push(*box_world({kBonds, kCrack}), Vec3::Zero()) == Vec3::Zero());
    CHECK(push(*box_world({kBonds, kCrack}), Vec3(0, 0.3 * kH, 0)) == Vec3::Zero());
}

TEST_CASE("contact: faces that overlap push each other apart, as far as they overlap", "[step]") {
    const auto w = box_world({kBonds, kCrack});
    const double stiffness = w->materials[0].contact_stiffness;
    REQUIRE_THAT(stiffness, WithinRel(0.25 * 1.2e5 * kH, 1e-9));  // rho c^2 = M = 1.2 E
    // 64 pairs face each other; others are farther than h apart.
    const Vec3 pushed = push(*w, Vec3(0, -0.1 * kH, 0));
    CHECK_THAT(pushed[1], WithinRel(64 * stiffness * 0.1 * kH * w->dt, 1e-9));
    CHECK(std::abs(pushed[0]) + std::abs(pushed[2]) < 1e-12 * pushed[1]);
    CHECK_THAT(contact_energy(*w), WithinRel(64 * 0.5 * stiffness * 0.01 * kH * kH, 1e-9));
}

TEST_CASE("contact: pairs are looked for anew when particles came nearer", "[step]") {
    const auto w = box_world({kBonds, kCrack});
    CHECK(push(*w, Vec3(0, 5 * kH, 0)) == Vec3::Zero());
    w->contact.moved = 10 * kH;
    CHECK(push(*w, Vec3(0, -5.1 * kH, 0))[1] > 0);
}

TEST_CASE("contact: crack surfaces push particles of other bodies, which have no cracks", "[step]") {
    const auto w = box_world(
        {R"(crack=[{ body = "cut", shape = { type = "plane", point = [0, 0.2, 0], normal = [0, 1, 0] } }])",
         R"(material.glass={ density = 1000, constitutive = { type = "pd_bond", youngs_modulus = 1e5 } })",
         R"(body=[{ name = "cut", material = "glass", particle_spacing = 0.05, shape = { type = "box", min = [0, 0, 0], max = [0.4, 0.4, 0.4] } },)"
         R"({ material = "rubber", particle_spacing = 0.05, shape = { type = "box", min = [0.4, 0, 0], max = [0.6, 0.4, 0.4] } }])"});
    for (std::size_t p = 0; p < w->count; ++p)
        if (w->x[0][p] > 0.4) w->x[0][p] -= 0.2 * kH;
    apply_contact(*w);
    Vec3 cut = Vec3::Zero(), other = Vec3::Zero();
    for (std::size_t p = 0; p < w->count; ++p) {
        const bool bonded = p >= w->materials[0].begin && p < w->materials[0].begin + w->materials[0].size
                                ? w->materials[0].has_bonds()
                                : w->materials[1].has_bonds();
        (bonded ? cut : other) += w->mass[p] * at(w->v, p);
    }
    CHECK(cut[0] < 0);
    CHECK_THAT(other[0], WithinRel(-cut[0], 1e-12));
}

TEST_CASE("contact: bonds hold what they join, however near", "[step]") {
    const auto w = box_world({kBonds, kCrack});
    for (std::size_t p = 0; p < w->count; ++p)
        for (int c = 0; c < 3; ++c) w->x[c][p] *= 0.5;  // the whole cube, to half its size
    apply_contact(*w);
    for (std::size_t p = 0; p < w->count; ++p) {
        const bool at_crack = w->materials[0].bonds.damage[p] > 0;
        CHECK((at_crack || at(w->v, p).norm() == 0));
    }
}
