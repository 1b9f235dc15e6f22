#include "step/velocity_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "perimpm/error.hpp"
#include "state/morton.hpp"
#include "step/transfer.hpp"

namespace perimpm {

namespace {

constexpr std::uint32_t kDust = 27;  ///< fragments of fewer particles share one field: a grid sees no solid in them

/// Calls body(particle) for those of bodies that are in pieces.
template <class Real, class Body>
void for_each_owned(const World<Real>& w, Body body) {
    const std::uint32_t* label = w.fields.label.data();
    for (const Material<Real>& m : w.materials)
        for (std::size_t k = 0; m.has_own_fields() && k < m.bodies.size(); ++k) {
            const std::size_t begin = m.begin + m.bodies[k],
                              end = m.begin + (k + 1 < m.bodies.size() ? m.bodies[k + 1] : m.size);
            const auto is_other = [&](std::uint32_t fragment) { return fragment != label[begin]; };
            if (std::none_of(label + begin, label + end, is_other)) continue;
            for (std::size_t p = begin; p < end; ++p) body(p);
        }
}

template <class Real>
void find_blocks_of_owners(World<Real>& w) {
    VelocityFields<Real>& f = w.fields;
    for (FieldOwner& one : f.owners) one.blocks.clear();
    for (std::size_t p = 0; p < w.count; ++p) {
        std::vector<std::uint64_t>& blocks = f.owners[f.owner[p]].blocks;
        if (blocks.empty() || blocks.back() != w.sort.block[p]) blocks.push_back(w.sort.block[p]);
    }
    for (FieldOwner& one : f.owners) sort_unique(one.blocks);
}

/// Whether tiles of one set of blocks overlap those of the other.
bool meet(const std::vector<std::uint64_t>& one, const std::vector<std::uint64_t>& other) {
    const auto& [fewer, more] = one.size() < other.size() ? std::tie(one, other) : std::tie(other, one);
    return std::any_of(fewer.begin(), fewer.end(), [&, &all = more](std::uint64_t key) {
        std::int32_t c[3];
        morton_decode(key, c);
        for (std::int32_t i = -1; i <= 1; ++i)
            for (std::int32_t j = -1; j <= 1; ++j)
                for (std::int32_t k = -1; k <= 1; ++k) {
                    const std::int32_t at[3] = {c[0] + i, c[1] + j, c[2] + k};
                    if (std::binary_search(all.begin(), all.end(), morton(at))) return true;
                }
        return false;
    });
}

/// Integral of the spline from t >= 0 on [cells].
double tail(std::uint32_t order, double t) {
    const double end = 0.5 * (order + 1) - t;
    if (end <= 0) return 0;
    if (order == 1) return end * end / 2;
    if (order == 2) return t < 0.5 ? 0.5 - t * (0.75 - t * t / 3) : end * end * end / 6;
    return t < 1 ? 0.5 - t * (2.0 / 3 - t * t * (1.0 / 3 - t / 8)) : end * end * end * end / 24;
}

/// How far a body's surface is ahead of a node [cells], by what it fills of it and how fast that grows towards the body. Of
/// a flat surface at d the node has the share f(d), the integral of the spline from d on, and central differences see
/// (f(d - 1) - f(d + 1))/2: their ratio grows with d and does not depend on how far the body reaches sideways. A body thinner
/// than the spline seems nearer than it is.
class SurfaceAhead {
public:
    explicit SurfaceAhead(std::uint32_t order) : reach_{0.5 * (order + 1)} {
        const auto share = [&](double d) { return d < 0 ? 1 - tail(order, -d) : tail(order, d); };
        for (int k = 0; k < kSteps; ++k) {  // at reach_ the ratio is infinite
            const double d = reach_ * (2.0 * k / kSteps - 1);
            ratios_[k] = (share(d - 1) - share(d + 1)) / (2 * share(d));
        }
    }
    double operator()(double ratio) const {
        const double* above = std::upper_bound(ratios_, ratios_ + kSteps, ratio);
        if (above == ratios_) return -reach_;
        double k = static_cast<double>(above - ratios_) - 1;
        if (above < ratios_ + kSteps) k += (ratio - above[-1]) / (*above - above[-1]);
        return reach_ * (2 * k / kSteps - 1);
    }

private:
    static constexpr int kSteps = 64;
    double reach_, ratios_[kSteps];
};

/// Gradient of a field's mass, by central differences, over its mass at the node [1/cells].
template <class Real>
Vec3 gradient(World<Real>& w, const SharedBlock& s, int n) {
    constexpr int kStride[3] = {kBlockNodes * kBlockNodes, kBlockNodes, 1};
    Vec3 g;
    for (int axis = 0; axis < 3; ++axis) {
        const int at = n / kStride[axis] % kBlockNodes, stride = kStride[axis];
        const auto mass = [&](int side) {
            const int to = at + 2 * side - 1;
            const bool inside = to >= 0 && to < kBlockNodes;
            const std::uint32_t block = inside ? s.block : s.beside[axis][side];
            if (block == SharedBlock::kNone) return 0.0;
            const int node = n + stride * ((to + kBlockNodes) % kBlockNodes - at);
            return static_cast<double>(w.grid.nodes(block)[4 * node + 3]);
        };
        g[axis] = 0.5 * (mass(1) - mass(0));
    }
    return g / static_cast<double>(w.grid.nodes(s.block)[4 * n + 3]);
}

/// Of node n of a place, the fields that have mass there.
template <class Real>
void find_present(World<Real>& w, std::span<const SharedBlock> here, int n, std::vector<FieldAtNode<Real>>& present) {
    present.clear();
    for (const SharedBlock& s : here) {
        Real* node = w.grid.nodes(s.block) + 4 * n;
        if (!(node[3] > 0)) continue;
        Real* impulse = w.transfer_needs.increment ? w.grid.increments(s.block) + 4 * n : nullptr;
        FieldAtNode<Real> field{
            .shared = &s, .mass = static_cast<double>(node[3]), .momentum = impulse ? impulse : node};
        for (int c = 0; c < 3; ++c)
            field.velocity[c] = static_cast<double>(impulse ? node[c] + impulse[c] : node[c]) / field.mass;
        present.push_back(field);
    }
}

/// Two fields that touch at a node lose what they approach each other by, along a normal that is one for both; impulses are
/// equal and opposite.
template <class Real>
void resolve_pair(World<Real>& w, const SurfaceAhead& surface, int n, FieldAtNode<Real>& a, FieldAtNode<Real>& b) {
    const Vec3 relative = a.velocity - b.velocity;
    if (relative.isZero(0)) return;
    for (FieldAtNode<Real>* field : {&a, &b})
        if (!std::exchange(field->has_slope, true)) field->slope = gradient(w, *field->shared, n);
    const auto share = [&](const FieldAtNode<Real>& field) {
        return field.mass / static_cast<double>(w.fields.full_mass[field.shared->block]);
    };
    const Vec3 normal = (share(b) * b.slope - share(a) * a.slope).stableNormalized();
    const double approach = normal.dot(relative);
    if (!(approach > 0) || surface(-a.slope.dot(normal)) + surface(b.slope.dot(normal)) > 0) return;
    const Vec3 impulse = a.mass * b.mass / (a.mass + b.mass) * approach * normal;
    a.velocity -= impulse / a.mass, b.velocity += impulse / b.mass;
    for (int c = 0; c < 3; ++c)
        a.momentum[c] -= static_cast<Real>(impulse[c]), b.momentum[c] += static_cast<Real>(impulse[c]);
}

}  // namespace

/// Owners: the common field's, then fragments from the largest on, those of equal size by their least id; last all that are
/// smaller than kDust.
template <class Real>
bool find_owners(World<Real>& w) {
    VelocityFields<Real>& f = w.fields;
    f.is_stale = false;
    std::vector<std::uint32_t> label = label_fragments(w);
    if (label == f.label) return false;
    f.label = std::move(label);
    std::vector<std::uint32_t> size(w.count, 0), number(w.count), labels;
    for_each_owned(w, [&](std::size_t p) {
        if (size[f.label[p]]++ == 0) labels.push_back(f.label[p]);
    });
    std::sort(labels.begin(), labels.end(),
              [&](std::uint32_t a, std::uint32_t b) { return std::pair(size[b], a) < std::pair(size[a], b); });
    std::uint32_t count = 1;
    for (const std::uint32_t each : labels) number[each] = size[each] < kDust ? count : count++;
    f.owner.assign(w.count, 0);
    for_each_owned(w, [&](std::size_t p) { f.owner[p] = number[f.label[p]]; });
    f.owners.resize(count + 1);
    return true;
}

template <class Real>
void assign_fields(World<Real>& w) {
    VelocityFields<Real>& f = w.fields;
    if (f.is_stale) find_owners(w);
    find_blocks_of_owners(w);
    for (std::vector<std::uint64_t>& blocks : f.occupied) blocks.clear();
    for (FieldOwner& one : f.owners) {
        one.field = 0;
        while (one.field < f.occupied.size() && meet(one.blocks, f.occupied[one.field])) ++one.field;
        if (one.field == kMostFields)
            throw SimulationError(
                fmt::format("more than {} fragments are near each other: too many velocity fields\n  "
                            "use crack_surface = \"grid\"",
                            kMostFields));
        if (one.field == f.occupied.size()) f.occupied.emplace_back();
        std::vector<std::uint64_t>& blocks = f.occupied[one.field];
        f.merged.clear();
        std::set_union(blocks.begin(), blocks.end(), one.blocks.begin(), one.blocks.end(),
                       std::back_inserter(f.merged));
        std::swap(blocks, f.merged);
    }
    for (std::size_t p = 0; p < w.count; ++p)
        w.sort.block[p] |= std::uint64_t{f.owners[f.owner[p]].field} << kFieldShift;
}

template <class Real>
void prepare_field_contact(World<Real>& w) {
    w.fields.full_mass.assign(w.grid.size(), Real(0));
    const double cell = std::pow(w.spacing(), 3);
    for (std::size_t b = 0; b < w.grid.particle_blocks().size(); ++b) {
        Real mass = 0;
        for (const Material<Real>& m : w.materials)
            if (m.block_begin[b] < m.block_begin[b + 1]) mass = std::max(mass, static_cast<Real>(m.density * cell));
        for (const std::uint32_t link : w.grid.particle_blocks()[b].links)
            w.fields.full_mass[link] = std::max(w.fields.full_mass[link], mass);
    }
}

template <class Real>
void resolve_field_contact(World<Real>& w) {
    const std::vector<std::uint32_t>& begin = w.grid.shared_begin();
    const SurfaceAhead surface(w.transfer_needs.order);
    w.threads.run(begin.size() - 1, [&](std::size_t k) {
        const std::span<const SharedBlock> here(w.grid.shared().data() + begin[k], begin[k + 1] - begin[k]);
        std::vector<FieldAtNode<Real>>& present = w.own_scratch().present;
        for (int n = 0; n < kNodesPerBlock; ++n) {
            find_present(w, here, n, present);
            for (std::size_t a = 0; a < present.size(); ++a)
                for (std::size_t b = a + 1; b < present.size(); ++b)
                    resolve_pair(w, surface, n, present[a], present[b]);
        }
    });
}

template bool find_owners(World<float>&);
template bool find_owners(World<double>&);
template void assign_fields(World<float>&);
template void assign_fields(World<double>&);
template void prepare_field_contact(World<float>&);
template void prepare_field_contact(World<double>&);
template void resolve_field_contact(World<float>&);
template void resolve_field_contact(World<double>&);

}  // namespace perimpm
