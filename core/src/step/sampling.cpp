#include "step/sampling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "perimpm/error.hpp"
#include "state/morton.hpp"

namespace perimpm {

namespace {

/// Radius of a maximal Poisson-disk set with as many points as a lattice of spacing 1: such sets hold about 0.75/r^3
/// points.
constexpr double kPoissonRadius = 0.91;

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

}  // namespace

std::vector<BodySample> sample_bodies(const Scene& scene) {
    std::vector<BodySample> samples;
    for (const BodySpec& body : scene.bodies) {
        BodySample s{.spec = &body, .points = {}, .center = Vec3::Zero(), .spacing = 0, .particle_volume = 0};
        s.spacing =
            body.particle_spacing ? *body.particle_spacing : scene.grid.spacing / std::cbrt(body.particles_per_cell);
        const ShapePtr shape = build_shape(body.shape, scene.folder, 0.5 * s.spacing);
        s.points = body.poisson ? sample_poisson(*shape, kPoissonRadius * s.spacing, body.seed)
                                : sample_lattice(*shape, s.spacing);
        if (s.points.empty())
            throw InputError(
                body.source.place.text(),
                fmt::format("no particle of spacing {:g} m fits into body '{}': use a smaller grid.spacing or "
                            "particle_spacing",
                            s.spacing, body.name));
        s.particle_volume = body.poisson
                                ? measure_volume(*shape, 0.5 * s.spacing) / static_cast<double>(s.points.size())
                                : std::pow(s.spacing, 3);
        s.center = std::accumulate(s.points.begin(), s.points.end(), Vec3(Vec3::Zero())) /
                   static_cast<double>(s.points.size());
        check_inside_domain(scene, s);
        samples.push_back(std::move(s));
    }
    return samples;
}

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
    std::sort(keys.begin(), keys.end());
    std::vector<std::uint32_t> order(points.size());
    std::transform(keys.begin(), keys.end(), order.begin(), [](const auto& key) { return key.second; });
    return order;
}

double value_at(const Ramp& ramp, const Vec3& x) {
    const Vec3 start(ramp.start.data()), along = Vec3(ramp.end.data()) - start;
    const double share = std::clamp((x - start).dot(along) / along.squaredNorm(), 0.0, 1.0);
    return ramp.from + share * (ramp.to - ramp.from);
}

}  // namespace perimpm
