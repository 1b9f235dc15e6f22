#include "step/velocity_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <span>

#include "perimpm/error.hpp"
#include "state/morton.hpp"
#include "step/transfer.hpp"

namespace perimpm {

namespace {

constexpr std::uint32_t kDust = 8;  ///< fragments of fewer particles share one field: they are no solids

/// Numbers the owners of fields: common first, then fragments from the largest on, those of equal size by their least id;
/// last what is smaller than kDust.
template <class Real>
void find_owners(World<Real>& w) {
    VelocityFields<Real>& f = w.fields;
    const std::vector<std::uint32_t> label = label_fragments(w);
    std::vector<std::uint32_t> size(w.count, 0), number(w.count), labels;
    const auto for_each_owned = [&](auto body) {
        for (const Material<Real>& m : w.materials)
            for (std::size_t p = m.begin; m.has_own_fields() && p < m.begin + m.size; ++p) body(p);
    };
    for_each_owned([&](std::size_t p) {
        if (size[label[p]]++ == 0) labels.push_back(label[p]);
    });
    std::sort(labels.begin(), labels.end(),
              [&](std::uint32_t a, std::uint32_t b) { return std::pair(size[b], a) < std::pair(size[a], b); });
    std::uint32_t count = 1;
    for (const std::uint32_t each : labels) number[each] = size[each] < kDust ? count : count++;
    f.owner.assign(w.count, 0);
    for_each_owned([&](std::size_t p) { f.owner[p] = number[label[p]]; });
    f.owners.resize(count + 1);
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
/// (f(d - 1) - f(d + 1))/2: their ratio grows with d and does not depend on how far the body reaches sideways.
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

/// Momentum of a node with what forces add to it, and its mass.
template <class Real>
struct NodeOf {
    Real *momentum, *change;  ///< change: where an impulse goes
    Real mass;

    NodeOf(World<Real>& w, const SharedBlock& s, int n)
        : momentum{w.grid.nodes(s.block) + 4 * n},
          change{w.transfer_needs.increment ? w.grid.increments(s.block) + 4 * n : momentum},
          mass{momentum[3]} {}
    Vec3 velocity() const {
        Vec3 v;
        for (int c = 0; c < 3; ++c)
            v[c] = static_cast<double>(change == momentum ? momentum[c] : momentum[c] + change[c]) /
                   static_cast<double>(mass);
        return v;
    }
    void push(const Vec3& impulse) {
        for (int c = 0; c < 3; ++c) change[c] += static_cast<Real>(impulse[c]);
    }
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

/// Two fields that touch at a node lose what they approach each other by, along a normal that is one for both; impulses are
/// equal and opposite.
template <class Real>
void resolve_pair(World<Real>& w, const SurfaceAhead& surface, const SharedBlock& a, const SharedBlock& b, int n) {
    NodeOf<Real> one(w, a, n), other(w, b, n);
    if (!(one.mass > 0 && other.mass > 0)) return;
    const double m = static_cast<double>(one.mass), M = static_cast<double>(other.mass);
    const double full = static_cast<double>(w.fields.full_mass[a.block]),
                 other_full = static_cast<double>(w.fields.full_mass[b.block]);
    const Vec3 slope = gradient(w, a, n), other_slope = gradient(w, b, n);
    const Vec3 normal = (other_slope * (M / other_full) - slope * (m / full)).stableNormalized();
    if (surface(-slope.dot(normal)) + surface(other_slope.dot(normal)) > 0) return;
    const double approach = normal.dot(one.velocity() - other.velocity());
    if (!(approach > 0)) return;
    const Vec3 impulse = m * M / (m + M) * approach * normal;
    one.push(-impulse), other.push(impulse);
}

}  // namespace

template <class Real>
void assign_fields(World<Real>& w) {
    VelocityFields<Real>& f = w.fields;
    if (std::exchange(f.is_stale, false)) find_owners(w);
    find_blocks_of_owners(w);
    for (std::vector<std::uint64_t>& blocks : f.occupied) blocks.clear();
    for (FieldOwner& one : f.owners) {
        one.field = 0;
        while (one.field < f.occupied.size() && meet(one.blocks, f.occupied[one.field])) ++one.field;
        if (one.field == kMostFields)
            throw SimulationError(
                fmt::format("more than {} fragments are near each other: too many velocity fields\n  "
                            "use crack_surface = \"particle\"",
                            kMostFields));
        if (one.field == f.occupied.size()) f.occupied.emplace_back();
        std::vector<std::uint64_t>& blocks = f.occupied[one.field];
        blocks.insert(blocks.end(), one.blocks.begin(), one.blocks.end());
        sort_unique(blocks);
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
        for (int n = 0; n < kNodesPerBlock; ++n)
            for (std::size_t a = 0; a < here.size(); ++a)
                for (std::size_t b = a + 1; b < here.size(); ++b) resolve_pair(w, surface, here[a], here[b], n);
    });
}

template void assign_fields(World<float>&);
template void assign_fields(World<double>&);
template void prepare_field_contact(World<float>&);
template void prepare_field_contact(World<double>&);
template void resolve_field_contact(World<float>&);
template void resolve_field_contact(World<double>&);

}  // namespace perimpm
