#include <fmt/format.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>

#include "perimpm/error.hpp"
#include "state/morton.hpp"
#include "step/world.hpp"

namespace perimpm {

namespace {

/// Blocks are cut midway between the places where the spline's stencil jumps, so that particles may move half a cell
/// before their stencils leave the tile.
template <class Real>
SortEntry entry_of(const World<Real>& w, std::size_t at, std::uint32_t index) {
    const std::uint32_t order = w.transfer_needs.order;
    std::int32_t block[3];
    std::uint32_t cell = 0;
    for (int c = 0; c < 3; ++c) {
        const double u = static_cast<double>(w.x[c][at]) / w.spacing();
        if (!(std::abs(u) < farthest_cell<Real>()))
            throw SimulationError(fmt::format(
                "particle {} is at {:g} m along axis {}: farther from the origin than a grid of this spacing "
                "reaches in {} precision ({:g} m), or not a number",
                w.id[at], u * w.spacing(), "xyz"[c], std::is_same_v<Real, float> ? "single" : "double",
                farthest_cell<Real>() * w.spacing()));
        block[c] = static_cast<std::int32_t>(std::floor((order == 2 ? u : u + 0.5) / kBlockNodes));
        const auto base = static_cast<std::int32_t>(std::floor(order == 2 ? u - 0.5 : u)) - (order == 3 ? 1 : 0);
        cell = cell << 3 | static_cast<std::uint32_t>(base - (kBlockNodes * block[c] - kTileOffset));
    }
    return {morton(block), cell, index};
}

template <class Real>
void check_domain(const World<Real>& w) {
    const GridSpec& grid = w.scene.grid;
    if (!grid.bounded) return;
    for (int c = 0; c < 3; ++c)
        for (std::size_t p = 0; p < w.count; ++p) {
            const double x = static_cast<double>(w.x[c][p]);
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

/// Moves the entries of a material's part of an array to the new order.
template <class T>
void permute(Threads& threads, T* values, const std::vector<SortEntry>& order, std::vector<T>& buffer) {
    constexpr std::size_t kPiece = 8192;
    const std::size_t pieces = (order.size() + kPiece - 1) / kPiece;
    buffer.resize(std::max(buffer.size(), order.size()));
    const auto each = [&](auto body) {
        threads.run(pieces, [&](std::size_t piece) {
            for (std::size_t i = piece * kPiece; i < std::min(order.size(), (piece + 1) * kPiece); ++i) body(i);
        });
    };
    each([&](std::size_t i) { buffer[i] = values[order[i].index]; });
    each([&](std::size_t i) { values[i] = buffer[i]; });
}

template <class Real>
void permute_material(World<Real>& w, Material<Real>& m, const std::vector<SortEntry>& order) {
    const auto field = [&](FieldArray<Real>& f, std::size_t begin) {
        for (std::size_t c = 0; c < f.components(); ++c) permute(w.threads, f[c] + begin, order, w.sort_buffer);
    };
    field(w.x, m.begin), field(w.v, m.begin), field(w.C, m.begin), field(m.F, 0);
    permute(w.threads, w.mass.data() + m.begin, order, w.sort_buffer);
    permute(w.threads, w.volume.data() + m.begin, order, w.sort_buffer);
    permute(w.threads, w.id.data() + m.begin, order, w.sort_id_buffer);
    for (StateField<Real>& s : m.particle_state) field(s.values, 0);
    for (auto& [spec, values] : m.varying)
        if (!values.empty()) permute(w.threads, values.data(), order, w.sort_buffer);
}

}  // namespace

/// Sorts particles by grid block and stencil and rebuilds the grid's blocks. Particles of local laws move in memory;
/// those of bond laws keep their places and get a list of indices.
template <class Real>
void sort_particles(World<Real>& w) {
    check_domain(w);
    w.sort_keys.clear();
    for (Material<Real>& m : w.materials) {
        std::vector<SortEntry>& order = m.sort_order;
        order.resize(m.size);
        for_each_chunk(w, m, [&](std::size_t, Block<Real>& b) {
            for (std::uint32_t i = 0; i < b.size; ++i)
                order[b.first + i] = entry_of(w, m.begin + b.first + i, b.first + i);
        });
        w.threads.execute([&] { tbb::parallel_sort(order.begin(), order.end()); });
        for (std::size_t i = 0; i < m.size; ++i)
            if (i == 0 || order[i].block != order[i - 1].block) w.sort_keys.push_back(order[i].block);
    }
    std::sort(w.sort_keys.begin(), w.sort_keys.end());
    w.sort_keys.erase(std::unique(w.sort_keys.begin(), w.sort_keys.end()), w.sort_keys.end());
    w.grid.rebuild(w.sort_keys, w.transfer_needs.increment);
    w.farthest = 0;
    for (const ParticleBlock& block : w.grid.particle_blocks())
        for (const std::int32_t c : block.coordinate)
            w.farthest = std::max(w.farthest, (std::abs(c) + 2.0) * kBlockNodes * w.spacing());

    bool moved = false;
    for (Material<Real>& m : w.materials) {
        const std::vector<SortEntry>& order = m.sort_order;
        m.block_begin.resize(w.sort_keys.size() + 1);
        std::size_t next = 0;
        for (std::size_t b = 0; b < w.sort_keys.size(); ++b) {
            m.block_begin[b] = static_cast<std::uint32_t>(next);
            while (next < m.size && order[next].block == w.sort_keys[b]) ++next;
        }
        m.block_begin.back() = static_cast<std::uint32_t>(m.size);
        if (m.has_bonds()) {
            for (std::size_t i = 0; i < m.size; ++i) m.order[i] = order[i].index;
        } else {
            permute_material(w, m, order);
            moved = true;
        }
    }
    if (moved) ++w.generation;
    w.drift = 0;
}

template void sort_particles(World<float>&);
template void sort_particles(World<double>&);

}  // namespace perimpm
