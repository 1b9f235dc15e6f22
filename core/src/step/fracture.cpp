#include <algorithm>

#include "step/stages.hpp"

namespace perimpm {

namespace {

/// Live bonds that the criterion singles out, in order of slot. Chunks without a bond in question are passed over.
template <class Real>
void screen(World<Real>& w, Material<Real>& m) {
    const double harmless = m.criterion->harmless_stretch();
    for_each_chunk(w, m, [&](std::size_t c, Block<Real>& b) {
        m.found[c].clear();
        if (m.stretch[c] <= harmless) return;
        Scratch<Real>& scratch = w.own_scratch();
        CandidateList list{scratch.candidates.data(), 0};
        if (m.criterion->asks_bond_energy()) {
            b.stored = {scratch.own_energy.data(), scratch.other_energy.data()};
            m.law->bond_energy(b);
        }
        m.criterion->screen(b, list);
        for (std::uint32_t k = 0; k < list.size; ++k)
            if (m.may_part(list.data[k].particle, m.bonds.neighbour[list.data[k].bond]))
                m.found[c].push_back(list.data[k]);
    });
    m.candidates.clear();
    for (const auto& found : m.found) m.candidates.insert(m.candidates.end(), found.begin(), found.end());
}

/// Both directions of each bond; returns the chunks whose families changed, ascending.
template <class Real>
std::vector<std::size_t> cut(Material<Real>& m) {
    std::vector<std::size_t> changed;
    m.freed.clear();
    for (const auto [p, slot] : m.cuts) {
        const std::uint32_t q = m.bonds.neighbour[slot];
        if (!m.may_part(p, q)) continue;
        for (const std::uint32_t end : {p, q})
            if (m.bonds.damage[end] == 0) m.freed.push_back(end);
        const bool first = m.bonds.break_direction(p, slot);
        const bool second = m.bonds.break_direction(q, m.bonds.opposite(p, slot));
        if (first) changed.push_back(p / kChunk);
        if (second) changed.push_back(q / kChunk);
    }
    std::sort(changed.begin(), changed.end());
    changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
    return changed;
}

/// Renews what depends on the cut families: their reference quantities, and the forces of all that they act on. With the
/// first cut families of slices may go one by one: `prepare` runs for all, since their neighbours must know.
template <class Real>
void renew(World<Real>& w, Material<Real>& m, const std::vector<std::size_t>& changed, bool is_first) {
    const auto run = [&](const auto& chunks, auto body) {
        w.threads.run(chunks.size(), [&](std::size_t k) {
            const std::size_t first = chunks[k] * kChunk;
            Block<Real> b = make_block(w, m, first, std::min<std::size_t>(kChunk, m.size - first));
            body(chunks[k], b);
        });
    };
    run(changed, [&](std::size_t, Block<Real>& b) { m.law->renew(b); });
    const auto prepare = [&](std::size_t, Block<Real>& b) { m.law->prepare(b); };
    if (m.needs.prepare) is_first ? for_each_chunk(w, m, prepare) : run(changed, prepare);
    std::fill(m.touched.begin(), m.touched.end(), char(0));
    for (const std::size_t c : changed) {
        m.touched[c] = 1;
        const std::size_t end = std::min<std::size_t>(m.size, (c + 1) * kChunk);
        for (std::uint32_t slot = m.bonds.row[c * kChunk]; slot < m.bonds.row[end]; ++slot)
            m.touched[m.bonds.neighbour[slot] / kChunk] = 1;
    }
    std::vector<std::size_t> touched;
    for (std::size_t c = 0; c < m.chunks(); ++c)
        if (m.touched[c]) touched.push_back(c);
    run(touched, [&](std::size_t c, Block<Real>& b) { evaluate_bonds(w, m, c, b); });
}

}  // namespace

/// Asks the material's criterion which bonds break, and breaks them.
template <class Real>
void fracture(World<Real>& w, Material<Real>& m) {
    screen(w, m);
    if (m.candidates.empty()) return;
    m.cuts.clear();
    m.criterion->decide(make_block(w, m, 0, m.size), m.candidates, m.cuts);
    const bool is_first = !m.bonds.is_cut;
    const std::vector<std::size_t> changed = cut(m);
    if (changed.empty()) return;
    w.contact.valid = false;
    leave_grid(w, m, m.freed);
    w.fields.is_stale = w.fields.is_stale || m.parts_fragments;
    w.has_crack_surfaces = w.has_crack_surfaces || m.frees_crack_surfaces;
    renew(w, m, changed, is_first);
}

template void fracture(World<float>&, Material<float>&);
template void fracture(World<double>&, Material<double>&);

}  // namespace perimpm
