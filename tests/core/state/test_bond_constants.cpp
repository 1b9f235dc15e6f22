#include <algorithm>
#include <array>
#include <random>
#include <set>

#include "perimpm/peridynamics/family_slice.hpp"
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
        for (const double X : body.numbers(body.constants.length, p))
            CHECK((X == 1 / 64.0 || X == std::sqrt(2.0) / 64 || X == std::sqrt(3.0) / 64));
    }
    CHECK(body.constants.declared[1][7] == 3.0);
    CHECK(body.constants.slices.view().slice == nullptr);
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
    body.constants.share(body.bonds, body.reference.data(), {});
    CHECK(body.constants.slices.view().slice == nullptr);
    for (int k = 0; k < 3; ++k)
        for (std::size_t p = 0; p < size; ++p) CHECK(body.numbers(all(k), p) == before[k][p]);
    // 27 places in a box: inside, on faces, edges and corners, some with the same lengths in the same order; and the odd one
    CHECK(body.constants.length.size() <= 28 * 26);
    CHECK(body.constants.declared[0].size() == body.constants.length.size());
    const std::uint32_t* shape = body.constants.shape.data();
    CHECK(std::count(shape, shape + size, shape[odd]) == 1);
    CHECK(body.constants.shape[odd - 1] == body.constants.shape[odd + 1]);
}

TEST_CASE("bond constants: a slice shows the bonds of its families, each in a lane, and no others", "[state]") {
    const std::uint32_t lanes = GENERATE(2u, 4u, 8u, 16u);
    const bool is_box = GENERATE(true, false);
    std::vector<Vec3> X = rows_of_particles(7, 40, 1 / 64.0);
    if (!is_box)  // rows begin and end anywhere, and are shorter than a family now and then
        std::erase_if(
            X, [](const Vec3& x) { return (64 * x - Vec3(3, 3, 20)).cwiseQuotient(Vec3(3.2, 3.2, 19)).norm() > 1; });
    X.push_back({9, 9, 9});  // has no neighbours
    for (int k = 1; k < 64; ++k) X.push_back({9, 9, 10 + k / 64.0});
    Body body(X, 2.01 / 64);
    std::mt19937 random(4);
    std::uniform_real_distribution<double> number(1, 2);
    for (std::size_t p = 0; p < X.size(); p += 50) body.reference[4 * p + 3] = number(random);
    for (AlignedArray<double>& numbers : body.constants.declared)
        for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] = number(random);
    body.constants.share(body.bonds, body.reference.data(), {.lanes = lanes});
    const auto size = static_cast<std::int64_t>(X.size());
    const Slices<double> all = body.constants.slices.view();
    for (std::uint32_t first = 0; first + lanes <= X.size(); first += lanes) {
        const Slice& slice = all.slice[first / lanes];
        std::set<std::array<double, 5>> seen;  // distance in memory, X and V
        bool in_range = true;
        for (std::uint32_t p = first; p < first + lanes; ++p)
            for (std::uint32_t slot = body.bonds.row[p]; slot < body.bonds.row[p + 1]; ++slot) {
                const std::uint32_t q = body.bonds.neighbour[slot];
                const std::int64_t nearest = std::int64_t{first} + q - p;
                in_range = in_range && nearest >= 0 && nearest + lanes <= size;
                const double *from = body.reference.data() + 4 * p, *to = body.reference.data() + 4 * q;
                seen.insert({double(q) - p, to[0] - from[0], to[1] - from[1], to[2] - from[2], to[3]});
            }
        const std::size_t count = body.bonds.row[first + lanes] - body.bonds.row[first];
        const bool worthwhile = count > 0 && seen.size() <= std::min(4u, lanes / 2) * count / lanes;
        REQUIRE(slice.size == (in_range && worthwhile ? seen.size() : 0));
        std::vector<std::uint32_t> found(lanes);
        for (std::uint32_t k = 0; k < slice.size; ++k) {
            const std::uint32_t entry = slice.first + k;
            const std::int64_t nearest = first + std::int64_t{all.offset[entry]};
            REQUIRE((nearest >= 0 && nearest + lanes <= size));
            for (std::uint32_t lane = 0; lane < lanes; ++lane) {
                const std::uint32_t p = first + lane, bond = found[lane];
                const bool has = slice.masks == Slice::kWhole || (all.mask[slice.masks + k] >> lane & 1) != 0;
                found[lane] += has;
                for (std::size_t c = 0; c < 2; ++c) {
                    const AlignedArray<double>& declared = body.constants.declared[c];
                    const double shown = declared[slice.constants + lanes * std::size_t{k} + lane];
                    REQUIRE(shown == (has ? declared[body.constants.shape[p] + bond] : 0.0));
                }
                if (!has) continue;
                REQUIRE(bond < body.count(p));
                const std::uint32_t q = body.bonds.neighbour[body.bonds.row[p] + bond];
                REQUIRE(std::int64_t{q} == nearest + lane);
                for (std::size_t c = 0; c < 3; ++c)
                    REQUIRE(all.bond[4 * entry + c] == body.reference[4 * q + c] - body.reference[4 * p + c]);
                REQUIRE(all.bond[4 * entry + 3] == body.reference[4 * q + 3]);
                REQUIRE(all.length[entry] == body.constants.length[body.constants.shape[p] + bond]);
            }
        }
        for (std::uint32_t lane = 0; lane < lanes && slice.size > 0; ++lane)
            REQUIRE(found[lane] == body.count(first + lane));
    }
}

TEST_CASE("bond constants: axes of a slice hold the bonds on each line through a particle", "[state]") {
    const std::uint32_t lanes = GENERATE(4u, 8u);
    Body body(rows_of_particles(7, 40, 1 / 64.0), 2.01 / 64);
    std::mt19937 random(6);
    std::uniform_real_distribution<double> number(1, 2);
    AlignedArray<double>& share = body.constants.declared[1];
    for (std::size_t k = 0; k < share.size(); ++k) share[k] = number(random);
    const std::vector<double> before(share.data(), share.data() + share.size());
    body.constants.share(body.bonds, body.reference.data(), {.lanes = lanes, .axial = 1});
    const Slices<double> all = body.constants.slices.view();
    std::uint32_t slices = 0;
    for (std::uint32_t first = 0; first < 7 * 7 * 40; first += lanes) {
        const Slice& slice = all.slice[first / lanes];
        if (slice.size == 0) continue;
        ++slices;
        for (std::uint32_t lane = 0; lane < lanes; ++lane) {
            Eigen::Matrix3d expected = Eigen::Matrix3d::Zero(), found = expected;
            double fourth = 0, fourth_found = 0;  // what would differ if bonds of several directions were one axis
            const Vec3 along = Vec3(1, 2, 5).normalized();
            for (std::uint32_t slot = body.bonds.row[first + lane]; slot < body.bonds.row[first + lane + 1]; ++slot) {
                const double *from = body.reference.data() + 4 * (first + lane),
                             *to = body.reference.data() + 4 * body.bonds.neighbour[slot];
                const Vec3 X(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
                expected += before[slot] * X * X.transpose();
                fourth += before[slot] * std::pow(X.dot(along), 4) / X.squaredNorm();
            }
            for (std::uint32_t k = 0; k < slice.axes; ++k) {
                const double *nn = all.axis + 6 * (slice.axis + k),
                             sum = all.sum[slice.sums + lanes * std::size_t{k} + lane];
                Eigen::Matrix3d product;
                product << nn[0], nn[1], nn[2], nn[1], nn[3], nn[4], nn[2], nn[4], nn[5];
                found += sum * product;
                fourth_found += sum * std::pow(along.dot(product * along), 2);
            }
            REQUIRE((found - expected).norm() <= 1e-14 * expected.norm());
            REQUIRE(std::abs(fourth_found - fourth) <= 1e-14 * fourth);
        }
    }
    CHECK(slices >= 7 * 7 * 40 / lanes * 9 / 10);
    CHECK(all.slice[(3 * 7 + 3) * 40 / lanes + 2].size == 32);  // to 2 spacings
    CHECK(all.slice[(3 * 7 + 3) * 40 / lanes + 2].axes == 13);  // edges, diagonals of faces and of the cube
}

TEST_CASE("bond constants: slices know whether families in none see them", "[state]") {
    std::vector<Vec3> X = rows_of_particles(5, 16, 1 / 64.0);
    X.push_back(Vec3(2, 2, 16) / 64);  // in no slice
    Body body(X, 1.8 / 64);
    body.constants.share(body.bonds, body.reference.data(), {.lanes = 4});
    const AlignedArray<Slice>& slices = body.constants.slices.slice;
    std::set<std::size_t> seen;
    for (std::size_t p = 0; p < X.size(); ++p)
        for (std::uint32_t slot = body.bonds.row[p]; slot < body.bonds.row[p + 1]; ++slot)
            if (slices[p / 4].size == 0) seen.insert(body.bonds.neighbour[slot] / 4);
    REQUIRE(seen.size() >= 9);
    REQUIRE(seen.size() < slices.size());
    for (std::size_t k = 0; k < slices.size(); ++k) CHECK(slices[k].read_alone == seen.contains(k));
}

TEST_CASE("bond constants: slices of a lattice keep the same entries once", "[state]") {
    Body body(rows_of_particles(7, 40, 1 / 64.0), 1.8 / 64);
    body.constants.share(body.bonds, body.reference.data(), {.lanes = 8});
    const Slices<double> all = body.constants.slices.view();
    CHECK(all.slice[(3 * 7 + 3) * 5 + 2].masks == Slice::kWhole);
    CHECK(all.slice[(3 * 7 + 3) * 5].masks != Slice::kWhole);
    CHECK(all.slice[(3 * 7 + 3) * 5].first == all.slice[(2 * 7 + 4) * 5 + 3].first);
    CHECK(body.constants.slices.length.size() <= 9 * 26);  // inner rows, and those on faces and edges
}

TEST_CASE("bond constants: a neighbour of another volume makes another entry", "[state]") {
    Body body(rows_of_particles(7, 40, 1 / 64.0), 1.8 / 64);
    const std::size_t heavy = (3 * 7 + 3) * 40 + 20;
    body.reference[4 * heavy + 3] = 2;
    body.constants.share(body.bonds, body.reference.data(), {.lanes = 8});
    const Slice *around = body.constants.slices.slice.data() + heavy / 8, *elsewhere = around - 1;
    CHECK(elsewhere->size == 26);
    CHECK(around->size == 28);  // the neighbours before and after see it, and others at the same distance
}

TEST_CASE("bond constants: particles off a lattice share nothing and fill no slices", "[state]") {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> shift(-1e-3, 1e-3);
    std::vector<Vec3> X = rows_of_particles(5, 20, 1 / 64.0);
    for (Vec3& x : X) x += Vec3(shift(random), shift(random), shift(random));
    Body body(X, 1.6 / 64);
    const std::size_t bonds = body.bonds.size();
    body.constants.share(body.bonds, body.reference.data(), {.lanes = 4});
    CHECK(body.constants.length.size() == bonds);
    CHECK(body.constants.declared[0].size() == bonds);
    CHECK(body.constants.slices.lanes == 0);
    CHECK(body.constants.slices.bytes() == 0);
}

TEST_CASE("bond constants: slices made for other registers are left alone", "[state]") {
    const Slice slice{.size = 1};
    Block<double> b;
    b.size = 32;
    b.family.slices.slice = &slice;
    b.family.slices.lanes = kLanes<double>;
    CHECK(peridynamics::FamilySlice<double>::begins_at(b, 0));
    b.family.slices.lanes = 2 * kLanes<double>;
    CHECK_FALSE(peridynamics::FamilySlice<double>::begins_at(b, 0));
}
