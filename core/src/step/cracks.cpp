#include <fmt/format.h>

#include "geometry/triangle_tree.hpp"
#include "perimpm/error.hpp"
#include "scene/shapes.hpp"
#include "step/stages.hpp"

namespace perimpm {

namespace {

/// Cuts the bonds of the material's body, or of all its bodies, that cross the surface. Returns their number.
template <class Real, class Surface>
std::size_t cut_across(const World<Real>& w, Material<Real>& m, const CrackSpec& crack, const Surface& surface) {
    const auto reference = [&](std::uint32_t p) {
        const Real* X = m.reference.data() + 4 * std::size_t{p};
        return Vec3(static_cast<double>(X[0]), static_cast<double>(X[1]), static_cast<double>(X[2]));
    };
    const auto in_body = [&](std::uint32_t p) {
        const std::uint32_t id = w.id[m.begin + p];
        return !crack.body || (id >= w.body_begin[*crack.body] && id < w.body_begin[*crack.body + 1]);
    };
    std::size_t count = 0;
    for (std::uint32_t p = 0; p < m.size; ++p) {
        if (!in_body(p)) continue;
        const Vec3 X = reference(p);
        for (std::uint32_t slot = m.bonds.row[p]; slot < m.bonds.row[p + 1]; ++slot) {
            const std::uint32_t q = m.bonds.neighbour[slot];
            if (q < p || !surface.crosses(X, reference(q)) || !m.bonds.break_direction(p, slot)) continue;
            m.bonds.break_direction(q, m.bonds.opposite(p, slot));
            ++count;
        }
    }
    return count;
}

template <class Real, class Surface>
std::size_t cut_across(World<Real>& w, const CrackSpec& crack, const Surface& surface) {
    std::size_t count = 0;
    for (Material<Real>& m : w.materials)
        if (m.has_bonds()) count += cut_across(w, m, crack, surface);
    return count;
}

}  // namespace

template <class Real>
void open_cracks(World<Real>& w) {
    for (const CrackSpec& crack : w.scene.cracks) {
        const std::size_t count =
            crack.patch
                ? cut_across(w, crack, *crack.patch)
                : cut_across(w, crack, TriangleTree(read_triangles(*crack.source.find("shape"), w.scene.folder)));
        if (count == 0)
            throw InputError(crack.source.place.text(),
                             fmt::format("{} crosses no bond that is still whole: it must lie inside a body whose law "
                                         "has bonds (pd_elastic, pd_bond, pd_lps, ...)",
                                         crack.name));
    }
    if (w.scene.cracks.empty()) return;
    w.has_crack_surfaces = std::any_of(w.materials.begin(), w.materials.end(),
                                       [](const Material<Real>& m) { return m.frees_crack_surfaces; });
    for (const Material<Real>& m : w.materials)
        for (std::size_t p = 0; p < m.size; ++p)
            for (std::size_t c = 0; m.is_free(p) && c < w.C.components(); ++c) w.C[c][m.begin + p] = 0;
    for (Material<Real>& m : w.materials)
        if (m.has_bonds()) for_each_chunk(w, m, [&](std::size_t, Block<Real>& b) { m.law->renew(b); });
}

template void open_cracks(World<float>&);
template void open_cracks(World<double>&);

}  // namespace perimpm
