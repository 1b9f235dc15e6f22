#include <map>
#include <random>
#include <set>

#include "state/lattice_rows.hpp"
#include "support/catch.hpp"
#include "support/lattice_families.hpp"

using namespace perimpm;

namespace {

/// LatticeFamilies::moments of the particle at a place of a row, as its neighbours show them.
std::map<std::size_t, Vec3> moments(const BondRows<double>& rows, const LatticeRow& row, std::int32_t place) {
    std::map<std::size_t, Vec3> all;
    for (const auto* n = rows.neighbour.data() + row.neighbours;
         n != rows.neighbour.data() + row.neighbours + row.count; ++n)
        for (auto d = -static_cast<std::int32_t>(n->reach); d <= static_cast<std::int32_t>(n->reach); ++d) {
            const std::int64_t q = std::int64_t{row.first} + place + n->offset + d;
            const bool is_own = n->reach > 0 && d == 0 && n->offset == 0;
            if (place + d < n->begin || place + d >= n->end || is_own) continue;
            const auto distance = static_cast<std::size_t>(std::abs(d));
            const double weight = n->reach > 0 ? n->weight[distance] : 1.0;
            REQUIRE(!all.contains(static_cast<std::size_t>(q)));
            Vec3& moment = all[static_cast<std::size_t>(q)] = Vec3::Zero();
            moment[(row.axis + 1) % 3] = weight * n->across[0];
            moment[(row.axis + 2) % 3] = weight * n->across[1];
            moment[row.axis] = n->reach == 0 ? n->across[2] : d < 0 ? -n->along[distance] : n->along[distance];
        }
    return all;
}

}  // namespace

TEST_CASE("lattice rows: show the bonds of every particle, and no others", "[state]") {
    const bool is_box = GENERATE(true, false);
    const int axis = GENERATE(0, 1, 2);
    const double horizon = GENERATE(1.01, 1.8, 2.2, 3.015, 4.3);
    const std::vector<Vec3> X = rows_along(axis, is_box);
    LatticeFamilies<double> families(X, horizon * kSpacing);
    const BondRows<double> rows = families.rows();
    std::size_t particles = 0;
    std::uint32_t behind = 0;
    for (std::size_t k = 0; k < rows.row.size(); ++k) {
        const LatticeRow& row = rows.row[k];
        REQUIRE(row.first >= behind);
        REQUIRE(row.size >= 2);
        REQUIRE(row.axis == static_cast<std::uint32_t>(axis));
        behind = row.first + row.size, particles += row.size;
        std::uint32_t reach = ~0u;
        for (const auto* n = rows.neighbour.data() + row.neighbours;
             n != rows.neighbour.data() + row.neighbours + row.count; ++n) {
            REQUIRE(n->reach <= reach);
            reach = n->reach;
            if (reach == 0) continue;
            REQUIRE((row.begin <= n->begin && n->begin <= row.whole_begin));
            REQUIRE((row.whole_end <= n->end && n->end <= row.end));
        }
        REQUIRE((row.begin <= 0 && row.end >= static_cast<std::int32_t>(row.size)));
        for (std::uint32_t place = 0; place < row.size; ++place) {
            const auto expected = families.moments(row.first + place),
                       found = moments(rows, row, static_cast<std::int32_t>(place));
            REQUIRE(found.size() == expected.size());
            for (const auto& [q, moment] : expected) {
                REQUIRE(found.contains(q));
                REQUIRE((found.at(q) - moment).norm() <= 1e-15 * moment.norm());
            }
        }
    }
    CHECK(behind <= X.size());
    CHECK(particles >= (is_box ? X.size() : X.size() * 4 / 5));
}

TEST_CASE("lattice rows: those around a particle unlike the others are left out", "[state]") {
    const std::vector<Vec3> X = rows_of_particles(9, 20, kSpacing);
    LatticeFamilies<double> families(X, 1.8 * kSpacing);
    const auto row_of = [](std::size_t particle) { return particle / 20; };
    const std::size_t odd = (4 * 9 + 4) * 20 + 7;
    std::set<std::size_t> around;  // rows that see it
    const bool is_heavy = GENERATE(true, false);
    if (is_heavy) {
        families.reference[4 * odd + 3] = 3.0;
        for (int i = 3; i <= 5; ++i)
            for (int j = 3; j <= 5; ++j) around.insert(static_cast<std::size_t>(i * 9 + j));
    } else {  // one of its bonds weighs more
        families.influence()[families.bonds.row[odd] + 5] *= 1.5;
        around.insert(row_of(odd));
    }
    const BondRows<double> rows = families.rows();
    CHECK(rows.row.size() == 81 - around.size());
    for (std::size_t k = 0; k < rows.row.size(); ++k) CHECK(!around.contains(row_of(rows.row[k].first)));
}

TEST_CASE("lattice rows: a missing bond leaves its rows out", "[state]") {
    std::vector<Vec3> X = rows_of_particles(9, 20, kSpacing);
    const std::size_t halves[] = {0, X.size() / 3, X.size()};  // two bodies side by side
    LatticeFamilies<double> families(X, 1.8 * kSpacing);
    CHECK(families.rows().row.size() == 81);
    families.bonds = build_bonds(X, halves, 1.8 * kSpacing, false);
    families.rebuild_constants();
    CHECK(families.rows().row.size() == 81);                   // each body is a lattice
    const std::size_t inside[] = {0, X.size() / 2, X.size()};  // the border is within a row
    families.bonds = build_bonds(X, inside, 1.8 * kSpacing, false);
    families.rebuild_constants();
    CHECK(families.rows().row.size() == 81 - 9);
}

TEST_CASE("lattice rows: none off a lattice, none of too few particles or too little reach", "[state]") {
    std::vector<Vec3> X = rows_of_particles(5, 20, kSpacing);
    LatticeFamilies<double> lattice(X, 1.8 * kSpacing);
    CHECK(lattice.rows(20).row.size() == 25);
    CHECK(lattice.rows(21).row.size() == 0);
    CHECK(lattice.rows(21).bytes() == 0);
    CHECK(lattice.rows(2, 1.0).row.size() == 25);
    CHECK(lattice.rows(2, 1.1).row.size() == 0);
    // own row 2, eight rows 1, four more not along the row; at edges fewer
    LatticeFamilies<double> longer(X, 2.2 * kSpacing);
    CHECK(longer.rows(2, 10 / 9.0).row.size() == 25);
    CHECK(longer.rows(2, 10 / 8.9).row.size() == 25 - 9);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> shift(-1e-3, 1e-3);
    for (Vec3& x : X) x += Vec3(shift(random), shift(random), shift(random));
    CHECK(LatticeFamilies<double>(X, 1.8 * kSpacing).rows().row.size() == 0);
}

TEST_CASE("lattice rows: bodies whose spacings differ by rounding, in whatever order", "[state]") {
    const std::vector<Vec3> one = rows_of_particles(4, 9, kSpacing);
    const double ratio = GENERATE(1 + 0x1p-15, 1 - 0x1p-15);
    std::vector<Vec3> X = one;
    for (const Vec3& x : one) X.push_back(Vec3(8, 0, 0) + ratio * x);
    LatticeFamilies<double> families(X, 1.8 * kSpacing);
    CHECK(families.rows().row.size() == 2 * 16);
}

TEST_CASE("lattice rows: single particles, and rows without bonds along them, are none", "[state]") {
    std::vector<Vec3> sheet;  // across the axis that a row would have
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j) sheet.push_back(kSpacing * Vec3(i, 1.5 * j + 0.1 * i * j, 0));
    CHECK(LatticeFamilies<double>(sheet, 1.01 * kSpacing).rows().row.size() == 0);
    std::vector<Vec3> far = rows_of_particles(3, 5, kSpacing);
    for (Vec3& x : far) x[2] *= 2;  // bonds across the rows alone
    CHECK(LatticeFamilies<double>(far, 1.5 * kSpacing).rows().row.size() == 0);
}

TEST_CASE("lattice rows: inner rows share their neighbours", "[state]") {
    LatticeFamilies<double> families(rows_of_particles(9, 20, kSpacing), 1.8 * kSpacing);
    const BondRows<double> rows = families.rows();
    CHECK(rows.row[4 * 9 + 4].neighbours == rows.row[3 * 9 + 5].neighbours);
    CHECK(rows.row[4 * 9 + 4].count == 9);
    CHECK(rows.neighbour.size() == 4 * 4 + 4 * 6 + 9);  // at four edges, on four faces, inside
}
