#include <algorithm>
#include <random>

#include "perimpm/peridynamics/family.hpp"
#include "state/bond_constants.hpp"
#include "support/catch.hpp"
#include "support/particles.hpp"

using namespace perimpm;

namespace {

constexpr FieldSpec kDeclared[] = {{.name = "stiffness", .initial = 2.0}, {.name = "share", .initial = 3.0}};

struct Body {
    std::vector<double> reference;
    Bonds bonds;
    BondConstants<double> constants;

    explicit Body(const std::vector<Vec3>& X, double horizon) {
        const std::size_t whole[] = {0, X.size()};
        bonds = build_bonds(X, whole, horizon, false);
        for (const Vec3& x : X) reference.insert(reference.end(), {x[0], x[1], x[2], 1.0});
        constants = BondConstants<double>(bonds, reference.data(), kDeclared);
    }
    std::uint32_t count(std::size_t p) const { return bonds.row[p + 1] - bonds.row[p]; }
    std::vector<double> numbers(const AlignedArray<double>& array, std::size_t p) const {
        return {array.data() + constants.shape[p], array.data() + constants.shape[p] + count(p)};
    }
};

}  // namespace

TEST_CASE("bond constants: lengths and initial values, each family its own at first", "[state]") {
    Body body(rows_of_particles(3, 5, 1 / 64.0), 1.8 / 64);
    CHECK(body.constants.length.size() == body.bonds.size());
    for (std::size_t p = 0; p < body.constants.shape.size(); ++p) {
        CHECK(body.constants.shape[p] == body.bonds.row[p]);
        CHECK(body.constants.twin[p] == p);
        for (const double X : body.numbers(body.constants.length, p))
            CHECK((X == 1 / 64.0 || X == std::sqrt(2.0) / 64 || X == std::sqrt(3.0) / 64));
    }
    CHECK(body.constants.declared[1][7] == 3.0);
    CHECK(body.constants.run.empty());
}

TEST_CASE("bond constants: families share what is the same, and keep what is not", "[state]") {
    Body body(rows_of_particles(7, 40, 1 / 64.0), 1.8 / 64);
    const std::size_t size = body.constants.shape.size(), odd = (3 * 7 + 3) * 40 + 20;
    body.constants.declared[0][body.bonds.row[odd] + 5] = 7.0;
    std::vector<std::vector<double>> before[3];
    const auto all = [&](int k) -> const AlignedArray<double>& {
        return k < 2 ? body.constants.declared[static_cast<std::size_t>(k)] : body.constants.length;
    };
    for (int k = 0; k < 3; ++k)
        for (std::size_t p = 0; p < size; ++p) before[k].push_back(body.numbers(all(k), p));
    body.constants.share(body.bonds, body.reference.data());
    for (int k = 0; k < 3; ++k)
        for (std::size_t p = 0; p < size; ++p) CHECK(body.numbers(all(k), p) == before[k][p]);
    // 27 places in a box: inside, on faces, edges and corners, some with the same lengths in the same order; and the odd one
    CHECK(body.constants.length.size() <= 28 * 26);
    CHECK(body.constants.declared[0].size() == body.constants.length.size());
    const std::uint32_t* shape = body.constants.shape.data();
    CHECK(std::count(shape, shape + size, shape[odd]) == 1);
    CHECK(body.constants.shape[odd - 1] == body.constants.shape[odd + 1]);
}

TEST_CASE("bond constants: a twin sees the same neighbours, shifted; rows of inner particles are runs", "[state]") {
    Body body(rows_of_particles(7, 40, 1 / 64.0), 1.8 / 64);
    body.constants.share(body.bonds, body.reference.data());
    const std::size_t size = body.constants.shape.size();
    for (std::size_t p = 0; p < size; ++p) {
        const std::size_t twin = body.constants.twin[p];
        REQUIRE(body.count(twin) == body.count(p));
        for (std::uint32_t k = 0; k < body.count(p); ++k) {
            const std::uint32_t q = body.bonds.neighbour[body.bonds.row[p] + k],
                                r = body.bonds.neighbour[body.bonds.row[twin] + k];
            REQUIRE(q - p == r - twin);
            for (std::size_t c = 0; c < 3; ++c)
                REQUIRE(body.reference[4 * q + c] - body.reference[4 * p + c] ==
                        body.reference[4 * r + c] - body.reference[4 * twin + c]);
        }
        const std::size_t along = p % 40;
        if (p + 200 < size) CHECK(body.constants.run[p] == (along == 0 || along == 39 ? 1 : 39 - along));
    }
    CHECK(body.constants.run[size - 1] == 1);
}

TEST_CASE("bond constants: a neighbour of another volume makes other surroundings", "[state]") {
    Body body(rows_of_particles(7, 40, 1 / 64.0), 1.8 / 64);
    const std::size_t heavy = (3 * 7 + 3) * 40 + 20;
    body.reference[4 * heavy + 3] = 2;
    body.constants.share(body.bonds, body.reference.data());
    CHECK(body.constants.twin[heavy - 1] == heavy - 1);
    CHECK(body.constants.twin[heavy - 2] == body.constants.twin[heavy + 2]);
    CHECK(body.constants.run[heavy - 3] == 2);
}

TEST_CASE("bond constants: what a pack reads past the end of a twin's row are particles", "[state]") {
    Body body(rows_of_particles(5, 9, 1 / 64.0), 2.01 / 64);
    body.constants.share(body.bonds, body.reference.data());
    const auto size = static_cast<std::int64_t>(body.constants.shape.size());
    for (std::int64_t p = 0; p < size; ++p) {
        const auto twin = static_cast<std::int64_t>(body.constants.twin[static_cast<std::size_t>(p)]);
        const std::uint32_t begin = body.bonds.row[static_cast<std::size_t>(twin)];
        for (std::uint32_t slot = begin; slot < begin + body.count(static_cast<std::size_t>(p)) + kSlotPadding;
             ++slot) {
            const std::int64_t q = p + (static_cast<std::int64_t>(body.bonds.neighbour[slot]) - twin);
            REQUIRE((q >= 0 && q < size));
        }
        if (body.constants.run[static_cast<std::size_t>(p)] > 1)
            CHECK(body.bonds.neighbour[body.bonds.row[static_cast<std::size_t>(p) + 1] - 1] + kSlotPadding <= size);
    }
}

TEST_CASE("bond constants: particles off a lattice share nothing and are no runs", "[state]") {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> shift(-1e-3, 1e-3);
    std::vector<Vec3> X = rows_of_particles(5, 20, 1 / 64.0);
    for (Vec3& x : X) x += Vec3(shift(random), shift(random), shift(random));
    Body body(X, 1.6 / 64);
    const std::size_t bonds = body.bonds.size();
    body.constants.share(body.bonds, body.reference.data());
    CHECK(body.constants.length.size() == bonds);
    for (std::size_t p = 0; p < X.size(); ++p) {
        CHECK(body.constants.twin[p] == p);
        CHECK(body.constants.run[p] == 1);
    }
}
