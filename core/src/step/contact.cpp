#include <algorithm>
#include <array>
#include <cmath>

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

/// Marks the cells around crack surfaces, then lists the particles in them, in order of storage, and chains them by cell.
template <class Real>
void fill_cells(World<Real>& w, ContactCells& cells, double width) {
    std::size_t free = 0;
    for (const Material<Real>& m : w.materials)
        for (std::size_t p = 0; p < m.size; ++p) free += m.is_free(p);
    std::size_t buckets = 1024;
    while (buckets < 8 * free) buckets *= 2;
    cells.mask = buckets - 1, cells.width = width;
    cells.near.assign(buckets, 0), cells.first.assign(buckets, ContactCells::kNone);
    for (const Material<Real>& m : w.materials)
        for (std::size_t p = 0; p < m.size; ++p)
            if (m.is_free(p))
                for_each_around(cell_of(w, m.begin + p, width),
                                [&](std::uint64_t key) { cells.near[hash(key) & cells.mask] = 1; });
    cells.particle.clear(), cells.key.clear();
    for (std::size_t p = 0; p < w.count; ++p) {
        const std::uint64_t key = key_of(cell_of(w, p, width));
        if (!cells.near[hash(key) & cells.mask]) continue;
        cells.particle.push_back(static_cast<std::uint32_t>(p));
        cells.key.push_back(key);
    }
    cells.next.resize(cells.particle.size());
    for (std::size_t k = cells.particle.size(); k-- > 0;) {  // chains ascend
        std::uint32_t& chain = cells.first[hash(cells.key[k]) & cells.mask];
        cells.next[k] = chain, chain = static_cast<std::uint32_t>(k);
    }
}

template <class Real>
const Material<Real>& material_of(const World<Real>& w, std::size_t particle) {
    return *std::find_if(w.materials.begin(), w.materials.end(),
                         [&](const Material<Real>& m) { return particle < m.begin + m.size; });
}

/// Whether a bond joins two particles of a body, `apart` from each other at the start. Only bonds whose ends have both lost
/// some can be broken.
template <class Real>
bool bonded(const Material<Real>& m, std::uint32_t p, std::uint32_t q, double apart) {
    constexpr double kRounding = 1e-5;
    if (apart > m.needs.horizon * (1 + kRounding)) return false;
    const std::uint32_t* damage = m.bonds.damage.data();
    const std::uint32_t* row = m.bonds.row.data();
    if (damage[p] == 0 || damage[q] == 0) return true;
    if (damage[p] == row[p + 1] - row[p] || damage[q] == row[q + 1] - row[q]) return false;
    const std::uint32_t* end = m.bonds.neighbour.data() + row[p + 1];
    const std::uint32_t* found = std::lower_bound(m.bonds.neighbour.data() + row[p], end, q);
    return found != end && *found == q &&
           !m.bonds.is_broken(static_cast<std::uint32_t>(found - m.bonds.neighbour.data()));
}

template <class Real>
Vec3 place_of(const World<Real>& w, std::size_t p) {
    return {static_cast<double>(w.x[0][p]), static_cast<double>(w.x[1][p]), static_cast<double>(w.x[2][p])};
}
template <class Real>
Vec3 start_of(const Material<Real>& m, std::uint32_t p) {
    const Real* X = m.reference.data() + 4 * std::size_t{p};
    return {static_cast<double>(X[0]), static_cast<double>(X[1]), static_cast<double>(X[2])};
}

/// Distance below which two particles repel each other [m]; 0 where a bond joins them. Particles that were bonded repel each
/// other below their distance at the start at most: a crack that has not opened pushes nothing.
template <class Real>
double reach_of(const Material<Real>& m, std::size_t p, const Material<Real>& n, std::size_t q) {
    const double touching = 0.5 * (m.spacing + n.spacing);
    if (&m != &n) return touching;
    const auto own = static_cast<std::uint32_t>(p - m.begin), other = static_cast<std::uint32_t>(q - m.begin);
    if (!m.has_bonds() || !m.same_body(own, other)) return touching;
    const double apart = (start_of(m, other) - start_of(m, own)).norm();
    return bonded(m, own, other, apart) ? 0 : std::min(touching, apart);
}

/// What particle p may touch: anything if it is at a crack's surface, else what is.
template <class Real>
void find_pairs(const World<Real>& w, std::size_t p, double skin, ContactFinds<Real>& found) {
    const ContactCells& cells = w.contact.cells;
    const Material<Real>& m = material_of(w, p);
    const bool any = m.is_free(p - m.begin);
    const Vec3 at = place_of(w, p);
    const std::size_t before = found.other.size();
    for_each_around(cell_of(w, p, cells.width), [&](std::uint64_t key) {
        for (std::uint32_t k = cells.first[hash(key) & cells.mask]; k != ContactCells::kNone; k = cells.next[k]) {
            const std::size_t q = cells.particle[k];
            if (cells.key[k] != key || q == p) continue;
            const Material<Real>& n = material_of(w, q);
            if (!any && !n.is_free(q - n.begin)) continue;
            const double near = 0.5 * (m.spacing + n.spacing) + skin;
            if ((place_of(w, q) - at).squaredNorm() >= near * near) continue;
            const double reach = reach_of(m, p, n, q);
            if (reach == 0) continue;
            found.other.push_back(static_cast<std::uint32_t>(q));
            found.reach.push_back(static_cast<Real>(reach));
            found.stiffness.push_back(static_cast<Real>(2 * m.contact_stiffness * n.contact_stiffness /
                                                        (m.contact_stiffness + n.contact_stiffness)));
        }
    });
    if (found.other.size() == before) return;
    found.particle.push_back(static_cast<std::uint32_t>(p));
    found.count.push_back(static_cast<std::uint32_t>(found.other.size() - before));
}

template <class Real>
double widest_spacing(const World<Real>& w) {
    double widest = 0;
    for (const Material<Real>& m : w.materials) widest = std::max(widest, m.spacing);
    return widest;
}

template <class T>
void append(std::vector<T>& all, const std::vector<T>& part) {
    all.insert(all.end(), part.begin(), part.end());
}

template <class Real>
void list_pairs(World<Real>& w) {
    ContactPairs<Real>& list = w.contact;
    const double widest = widest_spacing(w), skin = kSkin * widest;
    fill_cells(w, list.cells, widest + skin);
    const std::size_t candidates = list.cells.particle.size(), chunks = (candidates + kChunk - 1) / kChunk;
    if (list.found.size() < chunks) list.found.resize(chunks);
    w.threads.run(chunks, [&](std::size_t chunk) {
        ContactFinds<Real>& found = list.found[chunk];
        found.clear();
        for (std::size_t k = chunk * kChunk; k < std::min(candidates, (chunk + 1) * kChunk); ++k)
            find_pairs(w, list.cells.particle[k], skin, found);
    });
    list.particle.clear(), list.row.clear(), list.other.clear(), list.reach.clear(), list.stiffness.clear();
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
        const ContactFinds<Real>& found = list.found[chunk];
        auto row = static_cast<std::uint32_t>(list.other.size());
        for (const std::uint32_t count : found.count) list.row.push_back(row), row += count;
        append(list.particle, found.particle), append(list.other, found.other);
        append(list.reach, found.reach), append(list.stiffness, found.stiffness);
    }
    list.row.push_back(static_cast<std::uint32_t>(list.other.size()));
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
