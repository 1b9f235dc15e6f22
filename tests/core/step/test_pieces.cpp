// kBox in Voronoi pieces.
#include <set>

#include "perimpm/error.hpp"
#include "step/pieces.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

const std::string kFragile = R"(material.rubber.fracture={ type = "critical_stretch", critical_stretch = 0.01 })";

}  // namespace

TEST_CASE("pieces: each particle is in the piece of its nearest centre, each centre in its own", "[step]") {
    const auto w = box_world({kBonds, kFragile, "material.rubber.pieces=5"});
    const Material<double>& m = w->materials[0];
    REQUIRE(m.piece.size() == m.size);
    CHECK(std::set(m.piece.begin(), m.piece.end()).size() == 5);
    // Convex: what lies between two particles of a piece does, too.
    for (std::uint32_t p = 0; p < m.size; ++p)
        for (std::uint32_t slot = m.bonds.row[p]; slot < m.bonds.row[p + 1]; ++slot) {
            const std::uint32_t q = m.bonds.neighbour[slot];
            for (std::uint32_t s = m.bonds.row[p]; s < m.bonds.row[p + 1]; ++s) {
                const std::uint32_t r = m.bonds.neighbour[s];
                const Vec3 middle = 0.5 * (at(w->x, p) + at(w->x, q));
                if (m.piece[p] == m.piece[q] && (at(w->x, r) - middle).norm() < 1e-9) CHECK(m.piece[r] == m.piece[p]);
            }
        }
}

TEST_CASE("pieces: whatever the strain, bonds break between them only", "[step]") {
    const auto w = box_world({kBonds, kFragile, "material.rubber.pieces=5"});
    for (std::size_t p = 0; p < w->count; ++p) w->x[0][p] *= 1.5;
    compute_bond_forces(*w);
    const Material<double>& m = w->materials[0];
    std::size_t broken = 0;
    for (std::uint32_t p = 0; p < m.size; ++p)
        for (std::uint32_t slot = m.bonds.row[p]; slot < m.bonds.row[p + 1]; ++slot)
            if (m.bonds.is_broken(slot)) {
                ++broken;
                CHECK(m.piece[p] != m.piece[m.bonds.neighbour[slot]]);
            }
    CHECK(broken > 0);
    CHECK(list_fragments(*w).size() <= 5);
}

TEST_CASE("pieces: the seed alone decides, bodies have pieces of their own", "[step]") {
    MaterialSpec spec{};
    spec.name = "m", spec.pieces = 4, spec.pieces_seed = 3;
    std::vector<Vec3> X;
    for (int k = 0; k < 200; ++k) X.emplace_back(0.1 * k, 0.01 * (k * k % 17), 0);
    const std::vector<std::size_t> bodies{0, 100, 200};
    const auto one = voronoi_pieces(X, bodies, spec);
    CHECK(one == voronoi_pieces(X, bodies, spec));
    CHECK(*std::max_element(one.begin(), one.begin() + 100) == 3);
    CHECK(*std::min_element(one.begin() + 100, one.end()) == 4);
    spec.pieces_seed = 9;
    CHECK(one != voronoi_pieces(X, bodies, spec));
    spec.pieces = 101;
    CHECK(
        contains(message_of([&] { voronoi_pieces(X, bodies, spec); }), "100 particles, which cannot make 101 pieces"));
}

TEST_CASE("pieces: without a criterion they mean nothing", "[step]") {
    CHECK(contains(message_of([] { box_world({kBonds, "material.rubber.pieces=5"}); }), "add a criterion"));
}
