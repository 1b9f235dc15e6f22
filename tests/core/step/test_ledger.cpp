// kBox: M = 64 kg, centre (0.2, 0.2, 0.2) m, n = 8 particles of spacing h = 0.05 m along each axis, dx = 0.1 m.
#include "support/catch.hpp"
#include "support/world.hpp"

using namespace perimpm;

TEST_CASE("ledger: a flying cube", "[step]") {
    const auto w = box_world({"body.0.initial_velocity=[1, 2, 3]", "simulation.gravity=[0, -10, 0]"});
    w->time = 1.5;
    const Ledger l = take_ledger(*w);
    CHECK(l.time == 1.5);
    CHECK_THAT(l.kinetic, WithinRel(0.5 * 64 * 14, 1e-12));
    CHECK_THAT(l.potential, WithinRel(64 * 10 * 0.2, 1e-12));
    CHECK_THAT(l.elastic, WithinAbs(0, 1e-12));
    const double momentum[3] = {64, 128, 192}, spin[3] = {64 * 0.2 * (3 - 2), 64 * 0.2 * (1 - 3), 64 * 0.2 * (2 - 1)};
    for (std::size_t c = 0; c < 3; ++c) {
        CHECK_THAT(l.momentum[c], WithinRel(momentum[c], 1e-12));
        CHECK_THAT(l.angular_momentum[c], WithinRel(spin[c], 1e-12));
    }
}

TEST_CASE("ledger: a spinning cube, with the affine part of APIC", "[step]") {
    // sum m (x^2 + y^2) = M h^2 (n^2 - 1)/6; the affine field of rotation adds 2 m D omega with D = dx^2/4 for quadratic
    // and dx^2/3 for cubic splines. Linear ones: D = f (1 - f) dx^2 with f = 1/4 or 3/4, so 3/16 dx^2.
    const double lattice = 64 * 0.0025 * 63 / 6;
    for (const auto& [order, D] : {std::pair{1, 3.0 / 16}, {2, 1.0 / 4}, {3, 1.0 / 3}}) {
        CAPTURE(order);
        const auto w =
            box_world({"body.0.initial_angular_velocity=[0, 0, 2]", "transfer.order=" + std::to_string(order)});
        const Ledger l = take_ledger(*w);
        CHECK_THAT(l.angular_momentum[2], WithinRel(2 * (lattice + 2 * 64 * D * 0.01), 1e-12));
        CHECK_THAT(l.angular_momentum[0], WithinAbs(0, 1e-12));
        CHECK_THAT(l.kinetic, WithinRel(0.5 * 4 * lattice, 1e-12));
    }
    const auto flip = box_world({"body.0.initial_angular_velocity=[0, 0, 2]", R"(transfer.type="flip")"});
    CHECK_THAT(take_ledger(*flip).angular_momentum[2], WithinRel(2 * lattice, 1e-12));
}

TEST_CASE("ledger: the elastic energy of a stretched cube", "[step]") {
    const auto w = box_world();
    for (std::size_t p = 0; p < w->count; ++p) w->materials[0].F[0][p] = 1.2;
    // mu |F - R|^2 + lambda/2 (J - 1)^2 over 0.064 m^3
    CHECK_THAT(take_ledger(*w).elastic, WithinRel(0.064 * 0.04 * (4e4 + 2e4), 1e-9));
}
