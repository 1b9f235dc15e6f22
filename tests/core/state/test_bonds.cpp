#include <random>

#include "state/bonds.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/particles.hpp"

using namespace perimpm;

namespace {

Bonds build(const std::vector<Vec3>& X, double horizon, bool can_break = false) {
    const std::size_t whole[] = {0, X.size()};
    return build_bonds(X, whole, horizon, can_break);
}

/// Bonds of a lattice's middle point by counting all integer offsets.
std::uint32_t count_offsets(double horizon) {
    std::uint32_t count = 0;
    const int reach = static_cast<int>(horizon) + 1;
    for (int i = -reach; i <= reach; ++i)
        for (int j = -reach; j <= reach; ++j)
            for (int k = -reach; k <= reach; ++k) count += (i || j || k) && i * i + j * j + k * k <= horizon * horizon;
    return count;
}

std::vector<Vec3> cloud(std::size_t count) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> place(-1.0, 1.0);
    std::vector<Vec3> X(count);
    for (Vec3& x : X) x = {place(random), place(random), place(random)};
    return X;
}

}  // namespace

TEST_CASE("bonds: full families on a lattice have the known sizes", "[state]") {
    const int count = 11;
    const double h = 0.37;
    for (const auto& [horizon, size] : {std::pair{2.01, 32u}, {3.015, 122u}, {4.001, 256u}}) {
        REQUIRE(count_offsets(horizon) == size);
        const Bonds bonds = build(lattice(count, h), horizon * h);
        CHECK(bonds.row[middle(count) + 1] - bonds.row[middle(count)] == size);
    }
}

TEST_CASE("bonds: random clouds have exactly the pairs within the horizon, both ways, ascending", "[state]") {
    const std::vector<Vec3> X = cloud(400);
    const double horizon = 0.4;
    const Bonds bonds = build(X, horizon);
    for (std::uint32_t p = 0; p < X.size(); ++p) {
        std::vector<std::uint32_t> expected;
        for (std::uint32_t q = 0; q < X.size(); ++q)
            if (q != p && (X[q] - X[p]).norm() <= horizon) expected.push_back(q);
        CHECK(std::vector(bonds.neighbour.data() + bonds.row[p], bonds.neighbour.data() + bonds.row[p + 1]) ==
              expected);
    }
    CHECK(bonds.row[X.size()] == bonds.size());
    CHECK(bonds.broken.empty());
    CHECK(bonds.damage.empty());
}

TEST_CASE("bonds: the opposite direction leads back", "[state]") {
    const std::vector<Vec3> X = cloud(300);
    const Bonds bonds = build(X, 0.5);
    for (std::uint32_t p = 0; p < X.size(); ++p)
        for (std::uint32_t slot = bonds.row[p]; slot < bonds.row[p + 1]; ++slot) {
            const std::uint32_t q = bonds.neighbour[slot], back = bonds.opposite(p, slot);
            CHECK((back >= bonds.row[q] && back < bonds.row[q + 1]));
            CHECK(bonds.neighbour[back] == p);
        }
}

TEST_CASE("bonds: breaking counts each direction once", "[state]") {
    Bonds bonds = build(lattice(5, 1.0), 1.5, true);
    const auto p = static_cast<std::uint32_t>(middle(5));
    const std::uint32_t slot = bonds.row[p] + 3;
    CHECK(bonds.break_direction(p, slot));
    CHECK_FALSE(bonds.break_direction(p, slot));
    CHECK(bonds.damage[p] == 1);
    CHECK(bonds.damage[bonds.neighbour[slot]] == 0);
    Families<double> family;
    family.broken = bonds.broken.data();
    for (std::uint32_t s = 0; s < bonds.size(); ++s) CHECK(family.is_broken(s) == (s == slot));
    for (std::uint32_t s = 0; s < bonds.size(); ++s)
        CHECK(family.broken_from(s) == (slot >= s && slot < s + 32 ? 1u << (slot - s) : 0u));
}

TEST_CASE("bonds: families never cross bodies", "[state]") {
    std::vector<Vec3> X = lattice(3, 1.0);
    const std::size_t one = X.size();
    for (std::size_t i = 0; i < one; ++i) X.push_back(X[i] + Vec3(0.25, 0.0, 0.0));
    const std::size_t bodies[] = {0, one, 2 * one};
    const Bonds bonds = build_bonds(X, bodies, 1.01, false);
    for (std::uint32_t p = 0; p < X.size(); ++p)
        for (std::uint32_t slot = bonds.row[p]; slot < bonds.row[p + 1]; ++slot)
            CHECK((bonds.neighbour[slot] < one) == (p < one));
    CHECK(bonds.row[middle(3) + 1] - bonds.row[middle(3)] == 6);
}

TEST_CASE("bonds: a horizon below the spacing leaves particles free", "[state]") {
    CHECK(build(lattice(3, 1.0), 0.9).size() == 0);
    CHECK(build({Vec3::Zero()}, 1.0).size() == 0);
}

TEST_CASE("bonds: two particles at one place are refused", "[state]") {
    std::vector<Vec3> X = lattice(3, 1.0);
    X.push_back(X[5]);
    CHECK(contains(message_of([&] { build(X, 1.5); }), "share the place"));
}
