#include <algorithm>

#include "step/world.hpp"

namespace perimpm {

namespace {

/// Live bonds that the criterion singles out, in order of slot.
template <class Real>
void screen(World<Real>& w, Material<Real>& m) {
    for_each_chunk(w, m, [&](std::size_t c, Block<Real>& b) {
        CandidateList list{w.own_scratch().candidates.data(), 0};
        m.criterion->screen(b, list);
        m.found[c].assign(list.data, list.data + list.size);
    });
    m.candidates.clear();
    for (const auto& found : m.found) m.candidates.insert(m.candidates.end(), found.begin(), found.end());
}

/// Both directions of each bond; returns the chunks whose families changed, ascending.
template <class Real>
std::vector<std::size_t> cut(Material<Real>& m, const CandidateList& cuts) {
    std::vector<std::size_t> changed;
    for (std::uint32_t k = 0; k < cuts.size; ++k) {
        const auto [p, slot] = cuts.data[k];
        const std::uint32_t q = m.bonds.neighbour[slot];
        const bool first = m.bonds.break_direction(p, slot);
        const bool second = m.bonds.break_direction(q, m.bonds.opposite(p, slot));
        if (first) changed.push_back(p / kChunk);
        if (second) changed.push_back(q / kChunk);
    }
    std::sort(changed.begin(), changed.end());
    changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
    return changed;
}

}  // namespace

/// Asks each material's criterion which bonds break, and breaks them.
template <class Real>
void fracture(World<Real>& w) {
    for (Material<Real>& m : w.materials) {
        if (!m.criterion || (w.steps + 1) % m.criterion->interval() != 0) continue;
        pack_positions(w, m);
        screen(w, m);
        if (m.candidates.empty()) continue;
        CandidateList cuts{m.candidates.data(), static_cast<std::uint32_t>(m.candidates.size())};
        m.criterion->decide(make_block(w, m, 0, m.size), cuts);
        const std::vector<std::size_t> changed = cut(m, cuts);
        for (std::uint32_t round = 0; round < m.needs.rounds; ++round)
            w.threads.run(changed.size(), [&](std::size_t k) {
                Block<Real> b =
                    make_block(w, m, changed[k] * kChunk, std::min<std::size_t>(kChunk, m.size - changed[k] * kChunk));
                m.law->initialise(b, round);
            });
    }
}

template void fracture(World<float>&);
template void fracture(World<double>&);

}  // namespace perimpm
