#include <algorithm>
#include <array>
#include <limits>
#include <set>

#include "perimpm/error.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

template <class Real>
std::vector<std::uint32_t> ids(const World<Real>& w) {
    return {w.id.data(), w.id.data() + w.count};
}

/// Index of particle i of the material in grid order.
std::size_t placed(const World<double>& w, std::size_t i) {
    const Material<double>& m = w.materials[0];
    return m.begin + (m.has_bonds() ? m.order[i] : i);
}

/// Scatters the particles over a wider space, the same way for every storage order.
template <class Real>
void spread(World<Real>& w) {
    for (std::size_t p = 0; p < w.count; ++p)
        for (std::uint32_t c = 0; c < 3; ++c)
            w.x[c][p] = static_cast<Real>(0.013 * ((w.id[p] * (7 + 30 * c) + 11 * c) % 199) - 1.1);
}

}  // namespace

TEST_CASE("sort: every particle lies in the range of its block, whatever the degree", "[step]") {
    for (const int order : {1, 2, 3})
        for (const Overrides& law : {Overrides{}, Overrides{kBonds}}) {
            CAPTURE(order, law.size());
            Overrides overrides = law;
            overrides.push_back("transfer.order=" + std::to_string(order));
            const auto w = box_world(overrides);
            spread(*w);
            sort_particles(*w);
            const Material<double>& m = w->materials[0];
            const auto& blocks = w->grid.particle_blocks();
            REQUIRE(m.block_begin.size() == blocks.size() + 1);
            CHECK(m.block_begin.front() == 0);
            CHECK(m.block_begin.back() == m.size);
            std::set<std::size_t> seen;
            for (std::size_t b = 0; b < blocks.size(); ++b) {
                CHECK(m.block_begin[b] < m.block_begin[b + 1]);
                for (std::size_t i = m.block_begin[b]; i < m.block_begin[b + 1]; ++i) {
                    seen.insert(placed(*w, i));
                    const double margin = sort_margin(w->transfer_needs.order);
                    for (int c = 0; c < 3; ++c)
                        for (const double moved : {-margin, 0.0, margin}) {
                            // The first node of the stencil lies in the tile, the last one, `order` further, as well.
                            const double u = w->x[static_cast<std::size_t>(c)][placed(*w, i)] / 0.1 + moved;
                            const int first = static_cast<int>(std::floor(u - (order - 1) / 2.0));
                            const int in_tile = first - (4 * blocks[b].coordinate[c] - kTileOffset);
                            CHECK((in_tile >= 0 && in_tile + order < kTileNodes));
                        }
                }
            }
            CHECK(seen.size() == m.size);
        }
}

TEST_CASE("sort: particles of a cell lie side by side, and stay so while they move along an axis", "[step]") {
    for (const int axis : {0, 1, 2}) {
        const auto w = box_world({"body.0.particle_spacing=0.025"});
        for (std::size_t p = 0; p < w->count; ++p)
            for (std::size_t c = 0; c < 3; ++c) {
                w->x[c][p] += 0.0003 + 0.001 * static_cast<double>((w->id[p] * (7 + 30 * c)) % 23);
                w->v[c][p] = static_cast<int>(c) == axis ? -1.0 : 0.1;
            }
        sort_particles(*w);
        const Material<double>& m = w->materials[0];
        for (const double moved : {0.0, -0.05, -0.0875}) {  // whole levels of the order along a line
            CAPTURE(axis, moved);
            for (std::size_t b = 0; b + 1 < m.block_begin.size(); ++b) {
                std::set<std::array<int, 3>> cells;
                std::array<int, 3> last{1 << 20};
                for (std::size_t i = m.block_begin[b]; i < m.block_begin[b + 1]; ++i) {
                    std::array<int, 3> cell;
                    for (std::size_t c = 0; c < 3; ++c)
                        cell[c] = static_cast<int>(
                            std::floor((w->x[c][i] + (static_cast<int>(c) == axis ? moved : 0)) / 0.1 - 0.5));
                    if (cell != last) REQUIRE(cells.insert(cell).second);
                    last = cell;
                }
            }
        }
    }
}

TEST_CASE("sort: particles lie side by side that will share a cell half-way to the next sort", "[step]") {
    const auto w = box_world({"body.0.particle_spacing=0.025"});
    for (std::size_t p = 0; p < w->count; ++p)
        for (std::size_t c = 0; c < 3; ++c) {
            w->x[c][p] += 0.0003 + 0.001 * static_cast<double>((w->id[p] * (7 + 30 * c)) % 23);
            w->v[c][p] = c == 1 ? -2.0 : 0.1 * static_cast<double>((w->id[p] * (3 + 7 * c)) % 16);
        }
    w->gathered_speed = 2.5;
    const double until = 0.5 * sort_margin(w->transfer_needs.order) * 0.1 / w->gathered_speed;
    sort_particles(*w);
    const Material<double>& m = w->materials[0];
    /// Rows of particles of one cell, and such cells of a block, at time t.
    const auto rows_and_cells = [&](double t) {
        std::size_t rows = 0;
        std::set<std::array<int, 4>> cells;
        std::array<int, 4> last{-1};
        for (std::size_t b = 0; b + 1 < m.block_begin.size(); ++b)
            for (std::size_t i = m.block_begin[b]; i < m.block_begin[b + 1]; ++i) {
                std::array<int, 4> cell{static_cast<int>(b)};
                for (std::size_t c = 0; c < 3; ++c)
                    cell[c + 1] = static_cast<int>(std::floor((w->x[c][i] + t * w->v[c][i]) / 0.1 - 0.5));
                rows += cell != last;
                cells.insert(cell);
                last = cell;
            }
        return std::pair(rows, cells.size());
    };
    const auto mixed = [&](double t) { return rows_and_cells(t).first > rows_and_cells(t).second; };
    CHECK_FALSE(mixed(until));
    CHECK(mixed(0));
    CHECK(mixed(2 * until));
}

TEST_CASE("sort: speeds that nobody found do not matter, nor do those of a ringing body", "[step]") {
    for (const int order : {1, 2, 3})
        for (const double speed : {1e3, std::numeric_limits<double>::infinity(), std::nan("")}) {
            CAPTURE(order, speed);
            const auto sorted = [&](double v, double gathered, double wave) {
                const auto w = box_world({"transfer.order=" + std::to_string(order)});
                w->v[0][5] = v;
                w->gathered_speed = gathered, w->wave_speed = wave;
                sort_particles(*w);
                return ids(*w);
            };
            CHECK(sorted(speed, 1.0, 1.0) == sorted(0.0, 1.0, 1.0));
            // waves cross eight cells in 0.8 us: nothing moves
            CHECK(sorted(0.1, 0.1, 1e6) == sorted(0.0, 0.1, 1e6));
        }
}

TEST_CASE("sort: local laws' particles move with everything they own, bond laws' stay", "[step]") {
    for (const bool bonds : {false, true}) {
        const auto w = box_world(bonds ? Overrides{kBonds} : Overrides{});
        const auto before = ids(*w);
        const std::uint64_t generation = w->generation;
        spread(*w);
        for (std::size_t p = 0; p < w->count; ++p) {
            w->v[0][p] = w->mass[p] = w->id[p];
            if (!bonds) w->materials[0].F[8][p] = w->id[p];
        }
        std::vector<Vec3> places(w->count);
        for (std::size_t p = 0; p < w->count; ++p) places[w->id[p]] = at(w->x, p);
        w->drift = 1;
        sort_particles(*w);
        CHECK((ids(*w) == before) == bonds);
        CHECK(w->generation == generation + (bonds ? 0 : 1));
        CHECK(w->drift == 0);
        for (std::size_t p = 0; p < w->count; ++p) {
            CHECK(at(w->x, p) == places[w->id[p]]);
            CHECK(w->v[0][p] == w->id[p]);
            CHECK(w->mass[p] == w->id[p]);
            if (!bonds) CHECK(w->materials[0].F[8][p] == w->id[p]);
        }
        auto sorted = ids(*w);
        std::sort(sorted.begin(), sorted.end());
        for (std::uint32_t i = 0; i < w->count; ++i) CHECK(sorted[i] == i);
    }
}

TEST_CASE("sort: the order does not depend on the number of threads", "[step]") {
    const auto sorted = [](int threads) {
        const auto w = box_world<float>({"body.0.particle_spacing=0.02"}, threads);
        spread(*w);
        sort_particles(*w);
        return ids(*w);
    };
    CHECK(sorted(1) == sorted(2));
    CHECK(sorted(2) == sorted(2));
}

TEST_CASE("sort: particles too far away or nowhere are named", "[step]") {
    const auto failure = [](double x) {
        const auto w = box_world<float>();
        w->x[1][7] = static_cast<float>(x);
        const std::string name = "particle " + std::to_string(w->id[7]) + " is at ";
        const std::string message = message_of<SimulationError>([&] { sort_particles(*w); });
        CHECK((message == "(no error)" || contains(message, name)));
        return message;
    };
    CHECK(failure(3276.7) == "(no error)");  // 32768 cells of 0.1 m
    CHECK(contains(failure(3277), "along axis y: farther from the origin than a grid of this spacing reaches"));
    CHECK(contains(failure(-3277), "in single precision (3276.8 m)"));
    CHECK(contains(failure(std::numeric_limits<double>::quiet_NaN()), "not a number"));
    CHECK(contains(failure(std::numeric_limits<double>::infinity()), "not a number"));
}

TEST_CASE("sort: a particle that left through a closed face is named, an open face lets it go", "[step]") {
    const auto failure = [](const char* faces, double x) {
        const auto w =
            box_world({std::string(R"(grid.domain={ min = [-1, -1, -1], max = [1, 1, 1], faces = )") + faces + " }"});
        w->x[2][3] = x;
        return message_of<SimulationError>([&] { sort_particles(*w); });
    };
    CHECK(contains(failure("\"slip\"", 1.11), "left the domain through its upper z face at t = 0 s (position 1.11 m)"));
    CHECK(contains(failure("\"slip\"", -1.11), "left the domain through its lower z face"));
    CHECK(failure("\"slip\"", 1.09) == "(no error)");  // less than a cell outside
    CHECK(failure("\"open\"", 1.11) == "(no error)");
}
