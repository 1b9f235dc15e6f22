#include <map>
#include <numeric>

#include "step/stages.hpp"

namespace perimpm {

namespace {

/// Disjoint sets of particles whose representative is the least member.
class Sets {
public:
    explicit Sets(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0u); }
    std::uint32_t find(std::uint32_t p) {
        while (parent_[p] != p) p = parent_[p] = parent_[parent_[p]];
        return p;
    }
    void join(std::uint32_t p, std::uint32_t q) {
        p = find(p), q = find(q);
        parent_[std::max(p, q)] = std::min(p, q);
    }

private:
    std::vector<std::uint32_t> parent_;
};

/// The least id among the particles of each set, by particle of the material.
template <class Real>
void label_broken(const World<Real>& w, const Material<Real>& m, std::vector<std::uint32_t>& label) {
    Sets sets(m.size);
    for (std::uint32_t p = 0; p < m.size; ++p)
        for (std::uint32_t slot = m.bonds.row[p]; slot < m.bonds.row[p + 1]; ++slot)
            if (m.bonds.neighbour[slot] > p && !m.bonds.is_broken(slot)) sets.join(p, m.bonds.neighbour[slot]);
    std::vector<std::uint32_t> least(m.size, std::numeric_limits<std::uint32_t>::max());
    for (std::uint32_t p = 0; p < m.size; ++p) {
        std::uint32_t& id = least[sets.find(p)];
        id = std::min(id, w.id[m.begin + p]);
    }
    for (std::uint32_t p = 0; p < m.size; ++p) label[m.begin + p] = least[sets.find(p)];
}

}  // namespace

template <class Real>
std::vector<std::uint32_t> label_fragments(const World<Real>& w) {
    std::vector<std::uint32_t> label(w.count);
    for (const Material<Real>& m : w.materials) {
        if (m.can_break()) {
            label_broken(w, m, label);
            continue;
        }
        for (std::size_t p = m.begin; p < m.begin + m.size; ++p)
            label[p] = *std::prev(std::upper_bound(w.body_begin.begin(), w.body_begin.end(), w.id[p]));
    }
    return label;
}

template <class Real>
std::vector<Fragment> list_fragments(const World<Real>& w) {
    const std::vector<std::uint32_t> label = label_fragments(w);
    std::map<std::uint32_t, Fragment> found;
    for (std::size_t p = 0; p < w.count; ++p) {
        Fragment& f = found[label[p]];
        const double mass = static_cast<double>(w.mass[p]);
        f.id = label[p], f.mass += mass;
        ++f.particles;
        for (std::size_t c = 0; c < 3; ++c) {
            f.center[c] += mass * static_cast<double>(w.x[c][p]);
            f.velocity[c] += mass * static_cast<double>(w.v[c][p]);
        }
    }
    std::vector<Fragment> list;
    for (auto& [id, f] : found) {
        for (std::size_t c = 0; c < 3; ++c) f.center[c] /= f.mass, f.velocity[c] /= f.mass;
        list.push_back(f);
    }
    return list;
}

template std::vector<std::uint32_t> label_fragments(const World<float>&);
template std::vector<std::uint32_t> label_fragments(const World<double>&);
template std::vector<Fragment> list_fragments(const World<float>&);
template std::vector<Fragment> list_fragments(const World<double>&);

}  // namespace perimpm
