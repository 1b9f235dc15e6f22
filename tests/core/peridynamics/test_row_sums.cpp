#include <array>
#include <random>

#include "perimpm/peridynamics/row_sums.hpp"
#include "support/catch.hpp"
#include "support/lattice_families.hpp"

using namespace perimpm;
using peridynamics::RowSums;

namespace {

/// Sums for the places [begin, end) of each row, and nothing elsewhere.
template <class Real>
FieldArray<Real> sums_of(const BondRows<Real>& rows, FieldArray<Real>& H, std::size_t particles, std::int32_t strip) {
    FieldArray<Real> sums(particles, 3);
    for (std::size_t k = 0; k < rows.row.size(); ++k) {
        const LatticeRow& row = rows.row[k];
        const auto size = static_cast<std::int32_t>(row.size);
        for (std::int32_t begin = 0; begin < size; begin += strip)
            for (std::size_t r = 0; r < 3; ++r)
                RowSums<Real>(rows.view(), row, H.view())(r, begin, std::min(begin + strip, size), sums[r] + row.first);
    }
    return sums;
}

}  // namespace

TEMPLATE_TEST_CASE("row sums: those of the families, the same bits in whatever parts", "[peridynamics]", float,
                   double) {
    const bool is_box = GENERATE(true, false);
    const int axis = GENERATE(0, 1, 2);
    const double horizon = GENERATE(1.01, 2.2, 3.015, 4.3);
    LatticeFamilies<TestType> families(rows_along(axis, is_box, 6, 80), horizon * kSpacing);
    const BondRows<TestType> rows = families.rows();
    const std::size_t size = families.reference.size() / 4;
    FieldArray<TestType> H(size, 9);
    std::mt19937 random(2);
    std::uniform_real_distribution<TestType> entry(-1, 1);
    for (std::size_t c = 0; c < 9; ++c)
        for (std::size_t p = 0; p < size; ++p) H[c][p] = entry(random);
    const FieldArray<TestType> sums = sums_of(rows, H, size, 1000);
    std::size_t compared = 0;
    for (std::size_t k = 0; k < rows.row.size(); ++k)
        for (std::size_t p = rows.row[k].first; p < rows.row[k].first + rows.row[k].size; ++p, ++compared) {
            Vec3 expected = Vec3::Zero();
            double scale = 0;
            for (const auto& [q, moment] : families.moments(p)) {
                scale += moment.norm();
                for (int c = 0; c < 9; ++c)
                    expected[c / 3] += static_cast<double>(H[static_cast<std::size_t>(c)][q]) * moment[c % 3];
            }
            const double rounding = 10 * static_cast<double>(std::numeric_limits<TestType>::epsilon()) * scale;
            for (std::size_t r = 0; r < 3; ++r)
                REQUIRE(std::abs(static_cast<double>(sums[r][p]) - expected[static_cast<int>(r)]) <= rounding);
        }
    CHECK(compared > size / 2);
    for (const std::int32_t strip : {1, 7, 16}) {
        const FieldArray<TestType> parts = sums_of(rows, H, size, strip);
        for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t p = 0; p < size; ++p) REQUIRE(parts[r][p] == sums[r][p]);
    }
}

TEST_CASE("row sums: rows of several strips, and what lies out of reach does not get in", "[peridynamics]") {
    std::vector<Vec3> X = rows_of_particles(3, 200, kSpacing);
    LatticeFamilies<double> families(X, 2.2 * kSpacing);
    const BondRows<double> rows = families.rows();
    REQUIRE(rows.row.size() == 9);
    FieldArray<double> H(X.size(), 9);
    for (std::size_t p = 0; p < X.size(); ++p) H[0][p] = H[4][p] = H[8][p] = X[p].squaredNorm();
    const FieldArray<double> sums = sums_of(rows, H, X.size(), 1000);
    for (std::size_t p = 0; p < X.size(); ++p) {
        Vec3 expected = Vec3::Zero();
        for (const auto& [q, moment] : families.moments(p)) expected += X[q].squaredNorm() * moment;
        for (std::size_t r = 0; r < 3; ++r)
            REQUIRE(std::abs(sums[r][p] - expected[static_cast<int>(r)]) <= 1e-12 * X.back().squaredNorm());
    }
    // part of the middle row
    const LatticeRow& middle = rows.row[4];
    for (std::size_t p = 0; p < X.size(); ++p)
        if (p % 200 > 60)
            for (std::size_t c = 0; c < 9; ++c) H[c][p] = std::numeric_limits<double>::infinity();
    std::vector<double> part(200);
    RowSums<double>(rows.view(), middle, H.view())(2, 0, 59, part.data());
    for (std::size_t place = 0; place < 59; ++place) CHECK(part[place] == sums[2][middle.first + place]);
}

TEST_CASE("row sums: rows of a block", "[peridynamics]") {
    LatticeFamilies<double> families(rows_of_particles(3, 20, kSpacing), 1.8 * kSpacing);
    const BondRows<double> rows = families.rows();
    Block<double> b;
    b.family.rows = rows.view();
    b.first = 30, b.size = 45;
    std::vector<std::array<std::uint32_t, 3>> found;
    peridynamics::for_each_row(b, [&](const LatticeRow& row, std::uint32_t begin, std::uint32_t end) {
        found.push_back({row.first, begin, end});
    });
    CHECK(found == std::vector<std::array<std::uint32_t, 3>>{{20, 0, 10}, {40, 10, 30}, {60, 30, 45}});
    b.family.rows = {};
    peridynamics::for_each_row(b, [&](const auto&...) { FAIL("there is none"); });
}
