#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "step/stages.hpp"

namespace perimpm {

namespace {

constexpr double kSkin = 0.5;  ///< spacings: how much farther pairs are looked for than they act

using Cell = std::array<std::int64_t, 3>;

template <class Real>
Cell cell_of(const World<Real>& w, std::size_t p, double width) {
    Cell c;
    for (std::size_t a = 0; a < 3; ++a)
        c[a] = static_cast<std::int64_t>(std::floor(static_cast<double>(w.x[a][p]) / width));
    return c;
}

/// 21 bits per axis: cells that far apart do not meet in one search.
std::uint64_t key_of(const Cell& c) {
    constexpr std::uint64_t low = (1u << 21) - 1;
    return (static_cast<std::uint64_t>(c[0]) & low) << 42 | (static_cast<std::uint64_t>(c[1]) & low) << 21 |
           (static_cast<std::uint64_t>(c[2]) & low);
}
/// Its upper bits depend on all bits of the key.
std::uint64_t hash(std::uint64_t key) { return (key * 0x9e3779b97f4a7c15u) >> 38; }

template <class Body>
void for_each_around(const Cell& c, Body body) {
    for (std::int64_t i = -1; i <= 1; ++i)
        for (std::int64_t j = -1; j <= 1; ++j)
            for (std::int64_t k = -1; k <= 1; ++k) body(key_of({c[0] + i, c[1] + j, c[2] + k}));
}

template <class Real>
void find_free(const World<Real>& w, ContactCells<Real>& cells) {
    cells.free.clear(), cells.is_free.assign(w.count, 0);
    for (const Material<Real>& m : w.materials)
        for (std::size_t p = 0; p < m.size; ++p) {
            if (!m.is_free(p)) continue;
            cells.free.push_back(static_cast<std::uint32_t>(m.begin + p));
            cells.is_free[m.begin + p] = 1;
        }
}

/// Marks the cells around crack surfaces, then sorts the particles in them by their cells' hashes.
template <class Real>
void fill_cells(const World<Real>& w, ContactCells<Real>& cells, double width) {
    find_free(w, cells);
    std::size_t buckets = 1024;
    while (buckets < 8 * cells.free.size()) buckets *= 2;
    cells.mask = buckets - 1, cells.width = width;
    cells.near.assign(buckets, 0), cells.begin.assign(buckets + 1, 0);
    for (const std::uint32_t p : cells.free)
        for_each_around(cell_of(w, p, width), [&](std::uint64_t key) { cells.near[hash(key) & cells.mask] = 1; });
    cells.found.clear();
    for (std::uint32_t p = 0; p < w.count; ++p) {
        const std::uint64_t key = key_of(cell_of(w, p, width)), bucket = hash(key) & cells.mask;
        if (!cells.near[bucket]) continue;
        cells.found.push_back({key, p, {w.x[0][p], w.x[1][p], w.x[2][p]}});
        ++cells.begin[bucket + 1];
    }
    std::partial_sum(cells.begin.begin(), cells.begin.end(), cells.begin.begin());
    cells.entries.resize(cells.found.size());
    for (const auto& entry : cells.found) cells.entries[cells.begin[hash(entry.key) & cells.mask]++] = entry;
    std::copy_backward(cells.begin.begin(), cells.begin.end() - 1, cells.begin.end());
    cells.begin.front() = 0;
    cells.surface.clear();
    for (std::uint32_t k = 0; k < cells.entries.size(); ++k)
        if (cells.is_free[cells.entries[k].particle]) cells.surface.push_back(k);
}

template <class Real>
const Material<Real>& material_of(const World<Real>& w, std::size_t particle) {
    return *std::find_if(w.materials.begin(), w.materials.end(),
                         [&](const Material<Real>& m) { return particle < m.begin + m.size; });
}

/// By particle of the world: whether a whole bond joins it to particle p of the material.
template <class Real>
void mark_bonded(const Material<Real>& m, std::size_t p, std::vector<char>& is_bonded, bool mark) {
    const std::size_t own = p - m.begin;
    for (std::uint32_t slot = m.bonds.row[own]; slot < m.bonds.row[own + 1]; ++slot)
        is_bonded[m.begin + m.bonds.neighbour[slot]] = mark && !m.bonds.is_broken(slot);
}

template <class Real>
Vec3 start_of(const Material<Real>& m, std::uint32_t p) {
    const Real* X = m.reference.data() + 4 * std::size_t{p};
    return {static_cast<double>(X[0]), static_cast<double>(X[1]), static_cast<double>(X[2])};
}

/// Distance below which two particles that no bond joins repel each other [m]: of one body, their distance at the start at
/// most, so that a crack that has not opened pushes nothing.
template <class Real>
double reach_of(const Material<Real>& m, std::size_t p, const Material<Real>& n, std::size_t q) {
    const double touching = 0.5 * (m.spacing + n.spacing);
    if (&m != &n) return touching;
    const auto own = static_cast<std::uint32_t>(p - m.begin), other = static_cast<std::uint32_t>(q - m.begin);
    if (!m.same_body(own, other)) return touching;
    return std::min(touching, (start_of(m, other) - start_of(m, own)).norm());
}

/// Gathers what lies in the 27 cells about a cell.
template <class Real>
void look_around(const ContactCells<Real>& cells, const Cell& cell, ContactSearch<Real>& search) {
    std::size_t count = 0;
    for_each_around(cell, [&](std::uint64_t key) {
        const std::size_t bucket = hash(key) & cells.mask;
        search.make_room(count + cells.begin[bucket + 1] - cells.begin[bucket]);
        for (std::uint32_t k = cells.begin[bucket]; k < cells.begin[bucket + 1]; ++k) {
            const auto& entry = cells.entries[k];
            search.particle[count] = entry.particle;
            for (std::size_t c = 0; c < 3; ++c) search.x[c][count] = entry.x[c];
            count += entry.key == key;
        }
    });
    search.count = count;
}

/// Of what was gathered, from `at` [m].
template <class Real>
void measure_distances(const Real* at, ContactSearch<Real>& search) {
    using Numbers = Eigen::Map<Eigen::Array<Real, Eigen::Dynamic, 1>>;
    const auto count = static_cast<Eigen::Index>(search.count);
    const auto along = [&](std::size_t c) { return Numbers(search.x[c].data(), count) - at[c]; };
    Numbers(search.apart2.data(), count) = along(0).square() + along(1).square() + along(2).square();
}

/// What a particle at a crack's surface may touch of those found around: of others at crack surfaces, those after it.
template <class Real>
void find_pairs(const World<Real>& w, const typename ContactCells<Real>::Entry& own, double skin,
                ContactSearch<Real>& search, ContactFinds<Real>& found) {
    const ContactCells<Real>& cells = w.contact.cells;
    const std::size_t p = own.particle, before = found.other.size();
    const Material<Real>& m = material_of(w, p);
    const auto farthest2 = static_cast<Real>(cells.width * cells.width);
    measure_distances(own.x, search);
    mark_bonded(m, p, search.is_bonded, true);
    for (std::size_t k = 0; k < search.count; ++k) {
        const std::size_t q = search.particle[k];
        if (search.apart2[k] >= farthest2 || search.is_bonded[q] || (cells.is_free[q] && q <= p)) continue;
        const Material<Real>& n = material_of(w, q);
        const double near = 0.5 * (m.spacing + n.spacing) + skin;
        if (static_cast<double>(search.apart2[k]) >= near * near) continue;
        found.other.push_back(search.particle[k]);
        found.reach.push_back(static_cast<Real>(reach_of(m, p, n, q)));
        found.stiffness.push_back(static_cast<Real>(2 * m.contact_stiffness * n.contact_stiffness /
                                                    (m.contact_stiffness + n.contact_stiffness)));
    }
    mark_bonded(m, p, search.is_bonded, false);
    found.count.push_back(static_cast<std::uint32_t>(found.other.size() - before));
}

template <class Real>
double widest_spacing(const World<Real>& w) {
    double widest = 0;
    for (const Material<Real>& m : w.materials) widest = std::max(widest, m.spacing);
    return widest;
}

/// Calls body(particle, other, reach, stiffness) for the pairs found, each both ways.
template <class Real, class Body>
void for_each_found(const ContactPairs<Real>& list, Body body) {
    const std::vector<std::uint32_t>& surface = list.cells.surface;
    for (std::size_t k = 0, piece = 0; k < surface.size(); ++piece) {
        const ContactFinds<Real>& found = list.found[piece];
        std::size_t pair = 0;
        for (const std::uint32_t count : found.count) {
            const std::uint32_t p = list.cells.entries[surface[k++]].particle;
            for (const std::size_t end = pair + count; pair < end; ++pair) {
                const std::uint32_t q = found.other[pair];
                body(p, q, found.reach[pair], found.stiffness[pair]);
                body(q, p, found.reach[pair], found.stiffness[pair]);
            }
        }
    }
}

template <class Real>
void list_pairs(World<Real>& w) {
    ContactPairs<Real>& list = w.contact;
    const double widest = widest_spacing(w), skin = kSkin * widest;
    fill_cells(w, list.cells, widest + skin);
    const std::vector<std::uint32_t>& surface = list.cells.surface;
    const std::size_t pieces = (surface.size() + kChunk - 1) / kChunk;
    if (list.found.size() < pieces) list.found.resize(pieces);
    w.threads.run(pieces, [&](std::size_t piece) {
        ContactFinds<Real>& found = list.found[piece];
        ContactSearch<Real>& search = w.own_scratch().contact;
        found.clear();
        const std::size_t first = piece * kChunk, end = std::min(surface.size(), first + kChunk);
        for (std::size_t k = first; k < end; ++k) {
            const auto& own = list.cells.entries[surface[k]];
            if (k == first || own.key != list.cells.entries[surface[k - 1]].key)
                look_around(list.cells, cell_of(w, own.particle, list.cells.width), search);
            find_pairs(w, own, skin, search, found);
        }
    });
    list.place.assign(w.count, 0);
    for_each_found(list, [&](std::uint32_t p, auto...) { ++list.place[p]; });
    list.particle.clear(), list.row.assign(1, 0);
    for (std::uint32_t p = 0; p < w.count; ++p) {
        const std::uint32_t count = std::exchange(list.place[p], list.row.back());
        if (count > 0) list.particle.push_back(p), list.row.push_back(list.row.back() + count);
    }
    list.other.resize(list.row.back()), list.reach.resize(list.row.back()), list.stiffness.resize(list.row.back());
    for_each_found(list, [&](std::uint32_t p, std::uint32_t q, Real reach, Real stiffness) {
        const std::uint32_t at = list.place[p]++;
        list.other[at] = q, list.reach[at] = reach, list.stiffness[at] = stiffness;
    });
    list.valid = true, list.moved = 0, list.generation = w.generation;
}

template <class Real>
void renew_pairs(World<Real>& w) {
    const ContactPairs<Real>& list = w.contact;
    const bool near_enough = 2 * list.moved <= kSkin * widest_spacing(w);
    if (!list.valid || list.generation != w.generation || !near_enough) list_pairs(w);
}

/// Calls body(i) for particles of the list, in parallel.
template <class Real, class Body>
void for_each_touching(World<Real>& w, const Body& body) {
    const std::size_t count = w.contact.particle.size();
    w.threads.run((count + kChunk - 1) / kChunk, [&](std::size_t chunk) {
        for (std::size_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) body(i);
    });
}

/// Calls body(vector from the other particle, distance, overlap, stiffness) for what the list's particle i touches.
template <class Real, class Body>
void for_each_touch(const World<Real>& w, std::size_t i, Body body) {
    const ContactPairs<Real>& list = w.contact;
    const std::size_t p = list.particle[i];
    for (std::uint32_t k = list.row[i]; k < list.row[i + 1]; ++k) {
        Real away[3], length2 = 0;
        for (int c = 0; c < 3; ++c) away[c] = w.x[c][p] - w.x[c][list.other[k]], length2 += away[c] * away[c];
        if (length2 >= list.reach[k] * list.reach[k] || length2 == 0) continue;
        const Real length = std::sqrt(length2);
        body(away, length, list.reach[k] - length, list.stiffness[k]);
    }
}

}  // namespace

/// Short-range forces between particles (Silling & Askari 2005, section 5): springs that only push, without friction. They
/// change velocities before the grid gets its share, equally and oppositely.
template <class Real>
void apply_contact(World<Real>& w) {
    renew_pairs(w);
    for_each_touching(w, [&](std::size_t i) {
        Real force[3] = {};
        for_each_touch(w, i, [&](const Real* away, Real length, Real overlap, Real stiffness) {
            for (int c = 0; c < 3; ++c) force[c] += stiffness * overlap / length * away[c];
        });
        const std::size_t p = w.contact.particle[i];
        for (int c = 0; c < 3; ++c) w.v[c][p] += static_cast<Real>(w.dt) / w.mass[p] * force[c];
    });
    w.contact.moved += w.dt * w.max_speed;
}

template <class Real>
double contact_energy(World<Real>& w) {
    renew_pairs(w);
    double energy = 0;
    for (std::size_t i = 0; i < w.contact.particle.size(); ++i)
        for_each_touch(w, i, [&](const Real*, Real, Real overlap, Real stiffness) {
            energy += 0.25 * static_cast<double>(stiffness * overlap * overlap);  // each pair is there twice
        });
    return energy;
}

template void apply_contact(World<float>&);
template void apply_contact(World<double>&);
template double contact_energy(World<float>&);
template double contact_energy(World<double>&);

}  // namespace perimpm
