#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "perimpm/error.hpp"
#include "state/morton.hpp"
#include "step/stages.hpp"

namespace perimpm {

namespace {

constexpr std::size_t kPiece = 8192;  ///< particles that one task counts or copies

/// Calls body(piece, first, end) for pieces of `length` of the range below `size`, in parallel.
template <class Body>
void for_each_piece(Threads& threads, std::size_t size, std::size_t length, const Body& body) {
    threads.run((size + length - 1) / length,
                [&](std::size_t piece) { body(piece, piece * length, std::min(size, (piece + 1) * length)); });
}

template <class Real>
[[noreturn]] void throw_far_away(const World<Real>& w, std::size_t p, int axis) {
    throw SimulationError(fmt::format(
        "particle {} is at {:g} m along axis {}: farther from the origin than a grid of this spacing "
        "reaches in {} precision ({:g} m), or not a number\n  a run that ends like this is often unstable: a smaller "
        "simulation.safety or dt, or transfer.order 2 or 3 instead of 1, may mend it",
        w.id[p], w.x[axis][p], "xyz"[axis], std::is_same_v<Real, float> ? "single" : "double",
        farthest_cell<Real>() * w.spacing()));
}

template <class Real>
void check_domain(const World<Real>& w, std::size_t p) {
    const GridSpec& grid = w.scene.grid;
    for (int c = 0; c < 3; ++c) {
        const double x = static_cast<double>(w.x[c][p]);
        if (w.images.axis[c].period > 0) continue;
        const bool below = grid.faces[2 * c] != Face::open && x < grid.domain.min()[c] - grid.spacing;
        const bool above = grid.faces[2 * c + 1] != Face::open && x > grid.domain.max()[c] + grid.spacing;
        if (below || above)
            throw SimulationError(
                fmt::format("particle {} left the domain through its {} {} face at t = {:g} s (position {:g} m): "
                            "the time step may be too "
                            "large, or the face should be \"open\"",
                            w.id[p], below ? "lower" : "upper", "xyz"[c], w.time, x));
    }
}

/// Cells from the tile's first node to where the stencil would be cut: its whole part is the stencil's cell.
template <class Real>
double tile_position(const World<Real>& w, int axis, std::size_t p, std::int32_t block) {
    const double u = static_cast<double>(w.x[axis][p]) / w.spacing();
    return (w.transfer_needs.order == 2 ? u - 0.5 : u) - (kBlockNodes * block - kTileOffset);
}

/// The tile of eight nodes holds the stencils of a block's four cells and of one more on each side: blocks are cut where
/// the stencil jumps, and particles may move a cell before their stencils leave the tile. Of the cubic spline it holds five:
/// blocks are cut midway between two jumps, and particles may move half a cell.
template <class Real>
std::uint64_t block_of(const World<Real>& w, std::size_t p) {
    const double shift = w.transfer_needs.order == 1 ? 1.0 : 0.5;
    std::int32_t block[3];
    for (int c = 0; c < 3; ++c) {
        const double u = static_cast<double>(w.x[c][p]) / w.spacing();
        if (!(std::abs(u) < farthest_cell<Real>())) throw_far_away(w, p, c);
        block[c] = static_cast<std::int32_t>(std::floor((u + shift) / kBlockNodes));
    }
    return morton(block);
}

/// Finds every particle's block, and the blocks in their order.
template <class Real>
void find_blocks(World<Real>& w) {
    SortBuffers<Real>& s = w.sort;
    s.block.resize(w.count);
    s.found.resize((w.count + kPiece - 1) / kPiece);
    for_each_piece(w.threads, w.count, kPiece, [&](std::size_t, std::size_t first, std::size_t end) {
        for (std::size_t p = first; p < end; ++p) {
            if (w.scene.grid.bounded) check_domain(w, p);
            s.block[p] = block_of(w, p);
        }
    });
    if (has_own_fields(w)) assign_fields(w);
    for_each_piece(w.threads, w.count, kPiece, [&](std::size_t piece, std::size_t first, std::size_t end) {
        std::vector<std::uint64_t>& found = s.found[piece];
        found.clear();
        for (std::size_t p = first; p < end; ++p)
            if (found.empty() || found.back() != s.block[p]) found.push_back(s.block[p]);
        sort_unique(found);
    });
    s.blocks.clear();
    for (const std::vector<std::uint64_t>& found : s.found) s.blocks.insert(s.blocks.end(), found.begin(), found.end());
    sort_unique(s.blocks);
}

/// Puts the material's particles into the order of their blocks (a counting sort) and notes where each block begins.
template <class Real>
void order_blocks(World<Real>& w, Material<Real>& m) {
    SortBuffers<Real>& s = w.sort;
    const std::size_t blocks = s.blocks.size();
    const std::size_t length = std::max(kPiece, blocks);  // no more counters than particles
    const std::size_t pieces = (m.size + length - 1) / length;
    s.count.assign(pieces * blocks, 0);
    s.slot.resize(m.size), s.index.resize(m.size), s.other_index.resize(m.size);
    for_each_piece(w.threads, m.size, length, [&](std::size_t piece, std::size_t first, std::size_t end) {
        std::uint32_t* count = s.count.data() + piece * blocks;
        std::uint32_t slot = 0;
        for (std::size_t p = first; p < end; ++p) {
            const std::uint64_t block = s.block[m.begin + p];
            if (s.blocks[slot] != block)
                slot = static_cast<std::uint32_t>(std::lower_bound(s.blocks.begin(), s.blocks.end(), block) -
                                                  s.blocks.begin());
            s.slot[p] = slot;
            ++count[slot];
        }
    });
    m.block_begin.resize(blocks + 1);
    std::uint32_t next = 0;
    for (std::size_t b = 0; b < blocks; ++b) {
        m.block_begin[b] = next;
        for (std::size_t piece = 0; piece < pieces; ++piece) next += std::exchange(s.count[piece * blocks + b], next);
    }
    m.block_begin[blocks] = next;
    for_each_piece(w.threads, m.size, length, [&](std::size_t piece, std::size_t first, std::size_t end) {
        std::uint32_t* place = s.count.data() + piece * blocks;
        for (std::size_t p = first; p < end; ++p) s.index[place[s.slot[p]]++] = static_cast<std::uint32_t>(p);
    });
}

/// A stable counting sort of a block's particles by seven bits of their keys.
template <class Real>
void sort_by_bits(SortBuffers<Real>& s, std::size_t first, std::size_t end, int shift) {
    constexpr std::size_t kBuckets = 128;
    std::uint32_t place[kBuckets + 1] = {};
    const auto bucket = [&](std::size_t i) { return std::size_t{s.key[i]} >> shift & (kBuckets - 1); };
    for (std::size_t i = first; i < end; ++i) ++place[bucket(i) + 1];
    std::partial_sum(place, place + kBuckets, place);
    for (std::size_t i = first; i < end; ++i) {
        const std::size_t to = first + place[bucket(i)]++;
        s.other_key[to] = s.key[i];
        s.other_index[to] = s.index[i];
    }
    std::copy(s.other_key.data() + first, s.other_key.data() + end, s.key.data() + first);
    std::copy(s.other_index.data() + first, s.other_index.data() + end, s.index.data() + first);
}

/// Half of the time to the next sort [s], as the fastest particle moves, or less: velocities last no longer than waves need
/// to cross some cells, so that parts of a ringing body do not leave the places where they ring.
template <class Real>
double time_ahead(const World<Real>& w) {
    constexpr double kCells = 8;
    const auto time = [&](double cells, double speed) { return speed > 0 ? cells * w.spacing() / speed : 0; };
    return std::min(time(sort_margin(w.transfer_needs.order) / 2, w.gathered_speed), time(kCells, w.wave_speed));
}

/// Within each block, particles of one cell side by side, and so that this lasts: lines of cells along the axis of
/// largest motion, particles in the order of their positions along the line. Motion then shifts the cells' borders
/// along the line instead of mixing the particles of two cells. Positions are those half-way to the next sort: motion across
/// the lines, which does mix them, is half as far from there.
template <class Real>
void order_cells(World<Real>& w, Material<Real>& m) {
    SortBuffers<Real>& s = w.sort;
    const double cells_per_speed = time_ahead(w) / w.spacing();
    s.key.resize(m.size), s.other_key.resize(m.size);
    w.threads.run(s.blocks.size(), [&](std::size_t b) {
        const std::size_t first = m.block_begin[b], end = m.block_begin[b + 1];
        double motion[3] = {};
        for (int c = 0; c < 3; ++c)
            for (std::size_t i = first; i < end; ++i)
                motion[c] += std::abs(static_cast<double>(w.v[c][m.begin + s.index[i]]));
        const int along = static_cast<int>(std::max_element(motion, motion + 3) - motion);
        const int across[2] = {(along + 1) % 3, (along + 2) % 3};
        const std::int32_t* block = w.grid.particle_blocks()[b].coordinate;
        for (std::size_t i = first; i < end; ++i) {
            const std::size_t p = m.begin + s.index[i];
            const auto steps = [&](int axis, int per_cell) {
                double moves = cells_per_speed * static_cast<double>(w.v[axis][p]);
                if (!(std::abs(moves) < 1)) moves = 0;  // written since the speed was found: keys are inside the tile
                return static_cast<std::uint32_t>(per_cell * (tile_position(w, axis, p, block[axis]) + moves));
            };
            const std::uint32_t line = steps(along, 8), u = steps(across[0], 2), v = steps(across[1], 2);
            s.key[i] = static_cast<std::uint16_t>((u / 2) << 11 | (v / 2) << 8 | line << 2 | u % 2 << 1 | v % 2);
        }
        sort_by_bits(s, first, end, 0);
        sort_by_bits(s, first, end, 7);
    });
}

/// Moves the material's part of an array to the new order.
template <class T>
void permute(Threads& threads, T* values, const std::vector<std::uint32_t>& order, std::vector<T>& buffer) {
    buffer.resize(std::max(buffer.size(), order.size()));
    for_each_piece(threads, order.size(), kPiece, [&](std::size_t, std::size_t first, std::size_t end) {
        for (std::size_t i = first; i < end; ++i) buffer[i] = values[order[i]];
    });
    for_each_piece(threads, order.size(), kPiece, [&](std::size_t, std::size_t first, std::size_t end) {
        std::copy(buffer.data() + first, buffer.data() + end, values + first);
    });
}

template <class Real>
void permute_material(World<Real>& w, Material<Real>& m) {
    SortBuffers<Real>& s = w.sort;
    const auto field = [&](FieldArray<Real>& f, std::size_t begin) {
        for (std::size_t c = 0; c < f.components(); ++c) permute(w.threads, f[c] + begin, s.index, s.values);
    };
    field(w.x, m.begin), field(w.v, m.begin), field(w.C, m.begin), field(m.F, 0);
    permute(w.threads, w.mass.data() + m.begin, s.index, s.values);
    permute(w.threads, w.volume.data() + m.begin, s.index, s.values);
    permute(w.threads, w.id.data() + m.begin, s.index, s.other_index);
    for (StateField<Real>& state : m.particle_state) field(state.values, 0);
    for (auto& [spec, values] : m.varying)
        if (!values.empty()) permute(w.threads, values.data(), s.index, s.values);
}

}  // namespace

/// Sorts particles by grid block and stencil and rebuilds the grid's blocks. Particles of local laws move in memory;
/// those of bond laws keep their places and get a list of indices.
template <class Real>
void sort_particles(World<Real>& w) {
    if (w.images.periodic()) wrap_particles(w);
    find_blocks(w);
    w.grid.rebuild(w.sort.blocks, w.transfer_needs.increment, w.images, w.defers_gather, w.threads.count());
    w.farthest = 0;
    for (const ParticleBlock& block : w.grid.particle_blocks())
        for (const std::int32_t c : block.coordinate)
            w.farthest = std::max(w.farthest, (std::abs(c) + 2.0) * kBlockNodes * w.spacing());

    bool moved = false;
    for (Material<Real>& m : w.materials) {
        order_blocks(w, m);
        order_cells(w, m);
        if (m.has_bonds()) {
            std::copy(w.sort.index.begin(), w.sort.index.end(), m.order.data());
        } else {
            permute_material(w, m);
            moved = true;
        }
    }
    if (!w.grid.shared().empty()) prepare_field_contact(w);
    if (moved) ++w.generation;
    ++w.sorts;
    w.drift = 0;
}

template void sort_particles(World<float>&);
template void sort_particles(World<double>&);

}  // namespace perimpm
