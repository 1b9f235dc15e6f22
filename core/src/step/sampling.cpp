#include "step/sampling.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "perimpm/error.hpp"
#include "scene/shapes.hpp"
#include "state/morton.hpp"

namespace perimpm {

namespace {

/// Radius of a maximal Poisson-disk set with as many points as a lattice of spacing 1: such sets hold about 0.75/r^3
/// points.
constexpr double kPoissonRadius = 0.91;

/// Memory that a particle takes at least: two copies of its sample point, x, v, C, F, mass, volume, id [bytes].
constexpr double kBytesPerParticle = 150;
constexpr int kProbes = 32;  ///< along each axis of a shape's bounds

/// Number of particles that a shape will hold, from its bounds and a coarse look at what they enclose.
double expected_count(const Shape& shape, double spacing) {
    const Box3 box = shape.bounds();
    int inside = 0;
    for (int k = 0; k < kProbes; ++k)
        for (int j = 0; j < kProbes; ++j)
            for (int i = 0; i < kProbes; ++i) {
                const Vec3 share = (Vec3(i, j, k) + Vec3::Constant(0.5)) / kProbes;
                inside += shape.signed_distance(box.min() + share.cwiseProduct(box.sizes())) < 0;
            }
    return box.volume() / std::pow(spacing, 3) * inside / std::pow(kProbes, 3);
}

/// Before any particle is made, so that a slip in a spacing is answered at once. count: of all bodies so far.
void refuse_too_many(const BodySpec& body, double spacing, double count) {
    const double memory = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
    if (count * kBytesPerParticle <= memory) return;
    const Value* key = body.source.find(body.particle_spacing ? "particle_spacing" : "particles_per_cell");
    throw InputError(
        (key ? *key : body.source).place.text(),
        fmt::format(
            "body '{}' with particles {:g} m apart brings the scene to about {:.2g} particles, which take {:.2g} "
            "GB or more; this machine has {:.2g} GB: use a larger {} (lengths are in m)",
            body.name, spacing, count, 1e-9 * count * kBytesPerParticle, 1e-9 * memory,
            body.particle_spacing ? "particle_spacing" : "grid.spacing"));
}

void check_inside_domain(const Scene& scene, const BodySample& s) {
    if (!scene.grid.bounded) return;
    std::size_t outside = 0;
    Box3 box;
    for (const Vec3& x : s.points) outside += !scene.grid.domain.contains(x), box.extend(x);
    if (outside == 0) return;
    const auto text = [](const Vec3& v) { return fmt::format("[{:g}, {:g}, {:g}]", v[0], v[1], v[2]); };
    throw InputError(
        s.spec->source.place.text(),
        fmt::format(
            "{} of {} particles of body '{}' lie outside grid.domain: the body spans {} to {} m, the domain {} to {} m",
            outside, s.points.size(), s.spec->name, text(box.min()), text(box.max()), text(scene.grid.domain.min()),
            text(scene.grid.domain.max())));
}

/// expected: particles of the bodies before, to which this one's are added.
void fill_solid(BodySample& s, const std::string& folder, double& expected) {
    const BodySpec& body = *s.spec;
    const ShapePtr shape = build_shape(body.shape, folder, 0.5 * s.spacing);
    refuse_too_many(body, s.spacing, expected += expected_count(*shape, s.spacing));
    s.points = body.poisson ? sample_poisson(*shape, kPoissonRadius * s.spacing, body.seed)
                            : sample_lattice(*shape, s.spacing);
    if (body.jitter > 0) jitter(s.points, body.jitter * s.spacing, body.seed);
    s.particle_volume = body.poisson ? measure_volume(*shape, 0.5 * s.spacing) / static_cast<double>(s.points.size())
                                     : std::pow(s.spacing, 3);
}

void fill_layer(BodySample& s, const std::string& folder, double& expected) {
    refuse_too_many(*s.spec, s.spacing, expected + layer_count(*s.spec, s.spacing));
    LayerSample layer = sample_layer(*s.spec, folder, s.spacing);
    s.points = std::move(layer.points);
    s.particle_volume = layer.measure * s.spec->across;
    expected += static_cast<double>(s.points.size());
}

}  // namespace

std::vector<BodySample> sample_bodies(const Scene& scene) {
    std::vector<BodySample> samples;
    double expected = 0;
    for (const BodySpec& body : scene.bodies) {
        BodySample s{.spec = &body, .points = {}, .center = Vec3::Zero(), .spacing = 0, .particle_volume = 0};
        s.spacing = body.spacing(scene.grid);
        body.dimension == 3 ? fill_solid(s, scene.folder, expected) : fill_layer(s, scene.folder, expected);
        if (s.points.empty())
            throw InputError(
                body.source.place.text(),
                fmt::format("no particle of spacing {:g} m fits into body '{}': use a smaller grid.spacing or "
                            "particle_spacing",
                            s.spacing, body.name));
        s.center = std::accumulate(s.points.begin(), s.points.end(), Vec3(Vec3::Zero())) /
                   static_cast<double>(s.points.size());
        check_inside_domain(scene, s);
        samples.push_back(std::move(s));
    }
    return samples;
}

namespace {

/// The indices beside the keys, in the order of the keys.
template <class Key>
std::vector<std::uint32_t> order_of(std::vector<std::pair<Key, std::uint32_t>>& keys) {
    std::sort(keys.begin(), keys.end());
    std::vector<std::uint32_t> order(keys.size());
    std::transform(keys.begin(), keys.end(), order.begin(), [](const auto& key) { return key.second; });
    return order;
}

}  // namespace

std::vector<std::uint32_t> morton_order(const std::vector<Vec3>& points, double width) {
    Box3 box;
    for (const Vec3& x : points) box.extend(x);
    // bodies more than 2^18 cells wide get coarser cells: the order only serves locality
    width = std::max(width, box.sizes().maxCoeff() / (2 * kMortonBias - 1));
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(points.size());
    for (std::uint32_t p = 0; p < points.size(); ++p) {
        std::int32_t cell[3];
        for (int c = 0; c < 3; ++c)
            cell[c] = static_cast<std::int32_t>((points[p][c] - box.min()[c]) / width) - kMortonBias;
        keys[p] = {morton(cell), p};
    }
    return order_of(keys);
}

std::vector<std::uint32_t> row_order(const std::vector<Vec3>& points, double width) {
    constexpr std::int64_t kBand = 8;
    Box3 box;
    for (const Vec3& x : points) box.extend(x);
    std::array<int, 3> axis{0, 1, 2};  // slowest first
    std::stable_sort(axis.begin(), axis.end(), [&](int a, int b) {
        const auto cells = [&](int c) { return std::llround(box.sizes()[c] / width); };
        return cells(a) < cells(b);
    });
    using Key = std::array<std::int64_t, 4>;
    std::vector<std::pair<Key, std::uint32_t>> keys(points.size());
    for (std::uint32_t p = 0; p < points.size(); ++p) {
        const auto cell = [&](int c) { return std::llround((points[p][c] - box.min()[c]) / width); };
        const std::int64_t side = cell(axis[1]);
        keys[p] = {{side / kBand, cell(axis[0]), side, cell(axis[2])}, p};
    }
    return order_of(keys);
}

template <class Real>
std::vector<Vec3> exact_lattice(const std::vector<Vec3>& points, double spacing) {
    Box3 box;
    for (const Vec3& x : points) box.extend(x);
    const double farthest = std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff()) + spacing;
    const double step = std::exp2(std::ilogb(farthest) + 1 - std::numeric_limits<Real>::digits);
    const auto exact = [&](double x) { return step * std::round(x / step); };
    const double h = exact(spacing);
    const Vec3 start = points.front() + spacing * ((box.center() - points.front()) / spacing).array().round().matrix();
    std::vector<Vec3> moved(points.size());
    for (std::size_t p = 0; p < points.size(); ++p) {
        const Vec3 cell = ((points[p] - start) / spacing).array().round();
        for (int c = 0; c < 3; ++c) moved[p][c] = exact(start[c]) + h * cell[c];
        const double off = (points[p] - start - spacing * cell).cwiseAbs().maxCoeff(),
                     rounding = (moved[p] - points[p]).cwiseAbs().maxCoeff();
        if (off > 1e-9 * spacing || rounding > 0.01 * spacing) return points;
    }
    return moved;
}
template std::vector<Vec3> exact_lattice<float>(const std::vector<Vec3>&, double);
template std::vector<Vec3> exact_lattice<double>(const std::vector<Vec3>&, double);

double value_at(const Ramp& ramp, const Vec3& x) {
    const Vec3 start(ramp.start.data()), along = Vec3(ramp.end.data()) - start;
    const double share = std::clamp((x - start).dot(along) / along.squaredNorm(), 0.0, 1.0);
    return ramp.from + share * (ramp.to - ramp.from);
}

}  // namespace perimpm
