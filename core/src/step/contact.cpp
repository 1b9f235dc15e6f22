#include <algorithm>
#include <array>
#include <cmath>

#include "step/world.hpp"

namespace perimpm {

namespace {

constexpr double kSkin = 0.5;  ///< spacings: how much farther pairs are looked for than they act

struct Pair {
    std::uint32_t first, second;
    double reach, stiffness;
    friend bool operator<(const Pair& a, const Pair& b) {
        return a.first != b.first ? a.first < b.first : a.second < b.second;
    }
};

/// Crack-surface particles by cubic cells, in a hash table.
template <class Real>
class CellTable {
public:
    CellTable(const World<Real>& w, double width) : w_{w}, width_{width} {
        for (const Material<Real>& m : w.materials)
            for (std::size_t p = 0; p < m.size; ++p)
                if (m.is_free(p)) particle_.push_back(static_cast<std::uint32_t>(m.begin + p));
        std::size_t buckets = 64;
        while (buckets < 2 * particle_.size()) buckets *= 2;
        mask_ = buckets - 1;
        first_.assign(buckets, kNone), next_.resize(particle_.size()), key_.resize(particle_.size());
        near_.assign(8 * buckets, 0);
        for (std::size_t k = particle_.size(); k-- > 0;) {  // chains ascend
            const Cell home = cell(particle_[k]);
            key_[k] = key(home);
            std::uint32_t& chain = first_[hash(key_[k]) & mask_];
            next_[k] = chain, chain = static_cast<std::uint32_t>(k);
            for_each_around(home, [&](std::uint64_t around) { near_[hash(around) & (8 * mask_ + 7)] = 1; });
        }
    }

    /// Calls body(crack-surface particle) for those in the 27 cells around a particle.
    template <class Body>
    void for_each_near(std::size_t particle, Body body) const {
        const Cell home = cell(particle);
        if (!near_[hash(key(home)) & (8 * mask_ + 7)]) return;
        for_each_around(home, [&](std::uint64_t around) {
            for (std::uint32_t k = first_[hash(around) & mask_]; k != kNone; k = next_[k])
                if (key_[k] == around) body(particle_[k]);
        });
    }

private:
    using Cell = std::array<std::int64_t, 3>;
    static constexpr std::uint32_t kNone = 0xffffffff;
    Cell cell(std::size_t p) const {
        Cell c;
        for (std::size_t a = 0; a < 3; ++a)
            c[a] = static_cast<std::int64_t>(std::floor(static_cast<double>(w_.x[a][p]) / width_));
        return c;
    }
    /// 21 bits per axis: cells that far apart do not meet in one search.
    static std::uint64_t key(const Cell& c) {
        constexpr std::uint64_t low = (1u << 21) - 1;
        return (static_cast<std::uint64_t>(c[0]) & low) << 42 | (static_cast<std::uint64_t>(c[1]) & low) << 21 |
               (static_cast<std::uint64_t>(c[2]) & low);
    }
    static std::uint64_t hash(std::uint64_t k) { return (k * 0x9e3779b97f4a7c15u) >> 24; }
    template <class Body>
    static void for_each_around(const Cell& c, Body body) {
        for (std::int64_t i = -1; i <= 1; ++i)
            for (std::int64_t j = -1; j <= 1; ++j)
                for (std::int64_t k = -1; k <= 1; ++k) body(key({c[0] + i, c[1] + j, c[2] + k}));
    }

    const World<Real>& w_;
    double width_;
    std::size_t mask_ = 0;
    std::vector<std::uint32_t> particle_, first_, next_;
    std::vector<std::uint64_t> key_;
    std::vector<char> near_;  ///< by hash: whether a crack-surface particle may be around
};

template <class Real>
const Material<Real>& material_of(const World<Real>& w, std::size_t particle) {
    return *std::find_if(w.materials.begin(), w.materials.end(),
                         [&](const Material<Real>& m) { return particle < m.begin + m.size; });
}

/// What acts between two particles; no stiffness where a bond joins them. Particles that were bonded repel each other below
/// their distance at the start at most: a crack that has not opened pushes nothing.
template <class Real>
Pair contact_of(const Material<Real>& m, std::size_t p, const Material<Real>& n, std::size_t q) {
    Pair pair{static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(q), 0.5 * (m.spacing + n.spacing),
              2 * m.contact_stiffness * n.contact_stiffness / (m.contact_stiffness + n.contact_stiffness)};
    if (&m != &n) return pair;
    const auto own = static_cast<std::uint32_t>(p - m.begin), other = static_cast<std::uint32_t>(q - m.begin);
    const std::uint32_t* end = m.bonds.neighbour.data() + m.bonds.row[own + 1];
    const std::uint32_t* found = std::lower_bound(m.bonds.neighbour.data() + m.bonds.row[own], end, other);
    if (found == end || *found != other) return pair;
    const auto slot = static_cast<std::uint32_t>(found - m.bonds.neighbour.data());
    pair.reach = std::min(pair.reach, static_cast<double>(m.length[slot]));
    if (!m.bonds.is_broken(slot)) pair.stiffness = 0;
    return pair;
}

template <class Real>
double distance(const World<Real>& w, std::size_t p, std::size_t q) {
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
        const double d = static_cast<double>(w.x[c][p]) - static_cast<double>(w.x[c][q]);
        sum += d * d;
    }
    return std::sqrt(sum);
}

/// Pairs of the chunk's particles with crack-surface particles; with those of its own that are on the grid, both ways.
template <class Real>
void find_pairs(const World<Real>& w, const Material<Real>& m, const CellTable<Real>& cells, const Block<Real>& b,
                double skin, std::vector<Pair>& found) {
    for (std::size_t p = m.begin + b.first; p < m.begin + b.first + b.size; ++p)
        cells.for_each_near(p, [&](std::size_t q) {
            if (p == q) return;
            const Material<Real>& n = material_of(w, q);
            const double apart = distance(w, p, q);
            if (apart >= 0.5 * (m.spacing + n.spacing) + skin) return;
            const Pair pair = contact_of(m, p, n, q);
            if (pair.stiffness == 0) return;
            found.push_back(pair);
            if (!m.is_free(p - m.begin)) found.push_back({pair.second, pair.first, pair.reach, pair.stiffness});
        });
}

template <class Real>
double widest_spacing(const World<Real>& w) {
    double widest = 0;
    for (const Material<Real>& m : w.materials) widest = std::max(widest, m.spacing);
    return widest;
}

template <class Real>
void list_pairs(World<Real>& w) {
    const double widest = widest_spacing(w), skin = kSkin * widest;
    const CellTable<Real> cells(w, widest + skin);
    std::vector<Pair> all;
    for (Material<Real>& m : w.materials) {
        std::vector<std::vector<Pair>> found(m.chunks());
        for_each_chunk(w, m, [&](std::size_t c, Block<Real>& b) { find_pairs(w, m, cells, b, skin, found[c]); });
        for (const std::vector<Pair>& part : found) all.insert(all.end(), part.begin(), part.end());
    }
    std::sort(all.begin(), all.end());
    ContactPairs<Real>& list = w.contact;
    list.particle.clear(), list.row.clear(), list.other.clear(), list.reach.clear(), list.stiffness.clear();
    for (const Pair& pair : all) {
        if (list.particle.empty() || list.particle.back() != pair.first) {
            list.particle.push_back(pair.first);
            list.row.push_back(static_cast<std::uint32_t>(list.other.size()));
        }
        list.other.push_back(pair.second);
        list.reach.push_back(static_cast<Real>(pair.reach));
        list.stiffness.push_back(static_cast<Real>(pair.stiffness));
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
