#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "step/stages.hpp"

namespace perimpm {

namespace {

constexpr std::size_t kPiece = 1024;  ///< images that one task goes through
constexpr std::uint8_t kAllComponents = 7;

/// A mirror needs nodes behind the face that are images of nodes in front. Friction has no place in it: what a mirror
/// holds back is never seen as approach.
AxisImages::End end_of(const GridSpec& grid, int f) {
    const int axis = f / 2;
    const double at = 2 * (f % 2 ? grid.domain.max() : grid.domain.min())[axis] / grid.spacing;
    AxisImages::End end{.mirrors = false, .at = static_cast<std::int32_t>(std::lround(at))};
    if (!on_half_cell(at / 2)) return end;
    const Face face = grid.faces[f];
    end.mirrors = face == Face::symmetry || face == Face::sticky || (face == Face::slip && grid.face_friction == 0);
    end.flip = face == Face::sticky ? kAllComponents : static_cast<std::uint8_t>(1 << axis);
    return end;
}

/// Calls body(image) for all images in parallel; those of one node in their order by one task.
template <class Real, class Body>
void for_each_image(World<Real>& w, Body body) {
    const std::vector<NodeImage>& images = w.grid.images();
    const auto border = [&](std::size_t i) {
        while (i > 0 && i < images.size() && images[i].of == images[i - 1].of) ++i;
        return std::min(i, images.size());
    };
    w.threads.run((images.size() + kPiece - 1) / kPiece, [&](std::size_t piece) {
        const std::size_t end = border((piece + 1) * kPiece);
        for (std::size_t i = border(piece * kPiece); i < end; ++i) body(images[i]);
    });
}

template <class Real>
void vanish(Real* node, std::uint8_t zero) {
    for (int c = 0; c < 3; ++c)
        if (zero >> c & 1) node[c] = 0;
}

template <class Real>
void fold(const NodeImage& image, const Real* from, Real* to) {
    if (from == to) return vanish(to, image.zero);
    for (int c = 0; c < 3; ++c) to[c] += image.flip >> c & 1 ? -from[c] : from[c];
    to[3] += from[3];
}

template <class Real>
void unfold(const NodeImage& image, const Real* from, Real* to) {
    for (int c = 0; c < 3; ++c) to[c] = image.flip >> c & 1 ? -from[c] : from[c];
    vanish(to, image.zero);
}

}  // namespace

DomainImages find_images(const GridSpec& grid) {
    DomainImages images;
    if (!grid.bounded) return images;
    for (int c = 0; c < 3; ++c) {
        AxisImages& axis = images.axis[c];
        axis.low = end_of(grid, 2 * c), axis.high = end_of(grid, 2 * c + 1);
        if (grid.faces[2 * c] != Face::periodic) continue;
        axis.period = static_cast<std::int32_t>(std::lround(grid.domain.sizes()[c] / grid.spacing));
    }
    return images;
}

std::vector<std::string> inexact_faces(const GridSpec& grid, const DomainImages& images) {
    std::vector<std::string> messages;
    for (int f = 0; grid.bounded && f < 6; ++f) {
        const bool slip = grid.faces[f] == Face::slip;
        if (!(slip || grid.faces[f] == Face::sticky) || !sets_nodes(grid, images, f)) continue;
        const double at = (f % 2 ? grid.domain.max() : grid.domain.min())[f / 2] / grid.spacing;
        if (on_half_cell(at)) continue;  // a slip face with friction
        messages.push_back(fmt::format(
            "face {}_{} ({}) lies between grid nodes, so it acts up to a cell away from its plane: put it at {:.9g} m",
            f % 2 ? "max" : "min", "xyz"[f / 2], slip ? "slip" : "sticky", std::round(2 * at) / 2 * grid.spacing));
    }
    return messages;
}

template <class Real>
void wrap_particles(World<Real>& w) {
    for (int c = 0; c < 3; ++c) {
        if (w.images.axis[c].period == 0) continue;
        const double low = w.scene.grid.domain.min()[c], length = w.scene.grid.domain.sizes()[c];
        Real* x = w.x[c];
        for (std::size_t p = 0; p < w.count; ++p) {
            const double at = static_cast<double>(x[p]), turns = std::floor((at - low) / length);
            if (turns != 0 && std::isfinite(turns)) x[p] = static_cast<Real>(at - turns * length);
        }
    }
}

template <class Real>
void fold_images(World<Real>& w) {
    for_each_image(w, [&](const NodeImage& image) {
        fold(image, w.grid.node(image.node), w.grid.node(image.of));
        if (w.transfer_needs.increment) fold(image, w.grid.increment(image.node), w.grid.increment(image.of));
    });
}

template <class Real>
void unfold_images(World<Real>& w) {
    for_each_image(w, [&](const NodeImage& image) {
        unfold(image, w.grid.node(image.of), w.grid.node(image.node));
        if (w.transfer_needs.increment) unfold(image, w.grid.increment(image.of), w.grid.increment(image.node));
    });
}

template void wrap_particles(World<float>&);
template void wrap_particles(World<double>&);
template void fold_images(World<float>&);
template void fold_images(World<double>&);
template void unfold_images(World<float>&);
template void unfold_images(World<double>&);

}  // namespace perimpm
