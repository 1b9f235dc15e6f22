// Lattice points and volume of a shape. Layers (constant z) are visited in parallel and joined in order, so that the
// result does not depend on the number of threads.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

#include "lattice.hpp"
#include "perimpm/error.hpp"
#include "random.hpp"

namespace perimpm {

namespace {

constexpr double kMostCells = 4294967296.0;  // 2^32

void refuse_cells(double cells, double spacing, const std::string& what) {
    std::ostringstream message;
    message << what << " of " << spacing << " m needs " << cells << " cells to cover the shape; at most " << kMostCells
            << " are supported";
    throw InputError(message.str());
}

double covered_share(double distance, double spacing) { return std::clamp(0.5 - distance / spacing, 0.0, 1.0); }

}  // namespace

Lattice lattice_over(const Shape& shape, double spacing, const std::string& what) {
    if (!std::isfinite(spacing) || spacing <= 0.0)
        throw InputError(what + " is " + std::to_string(spacing) + "; expected a positive length in m");
    const Box3 box = shape.bounds();
    if (!box.min().allFinite() || !box.max().allFinite())
        throw InputError("this shape has no end (a half space?) and cannot be filled; expected a bounded shape");

    const Vec3 counts = (box.sizes() / spacing).array().ceil().max(1.0);
    if (counts.prod() > kMostCells) refuse_cells(counts.prod(), spacing, what);
    return {box.min(), spacing, {std::size_t(counts.x()), std::size_t(counts.y()), std::size_t(counts.z())}};
}

std::vector<Vec3> sample_lattice(const Shape& shape, double spacing) {
    const Lattice lattice = lattice_over(shape, spacing, "particle spacing");
    std::vector<std::vector<Vec3>> layers(lattice.count[2]);
    tbb::parallel_for(std::size_t{0}, layers.size(), [&](std::size_t k) {
        for (std::size_t j = 0; j < lattice.count[1]; ++j)
            for (std::size_t i = 0; i < lattice.count[0]; ++i)
                if (const Vec3 x = lattice.center(i, j, k); shape.signed_distance(x) < 0.0) layers[k].push_back(x);
    });

    std::vector<Vec3> points;
    for (const auto& layer : layers) points.insert(points.end(), layer.begin(), layer.end());
    return points;
}

void jitter(std::vector<Vec3>& points, double reach, std::uint64_t seed) {
    Random random(seed);
    for (Vec3& x : points)
        for (int c = 0; c < 3; ++c) x[c] += reach * (2 * random.unit() - 1);
}

LayerSample sample_rectangle(const Vec3& corner, const Vec3& edge_u, const Vec3& edge_v, double spacing) {
    const Vec3 u = edge_u.normalized(), v = edge_v.normalized();
    LayerSample sample{{}, spacing * spacing};
    for (double j = 0.5; j * spacing < edge_v.norm(); ++j)
        for (double i = 0.5; i * spacing < edge_u.norm(); ++i)
            sample.points.emplace_back(corner + spacing * (i * u + j * v));
    return sample;
}

LayerSample sample_polyline(const std::vector<Vec3>& corners, double spacing) {
    LayerSample sample{{}, spacing};
    double start = 0, number = 0.5;  // of the segment along the line; of the next point
    for (std::size_t k = 1; k < corners.size(); ++k) {
        const Vec3 segment = corners[k] - corners[k - 1];
        for (; number * spacing < start + segment.norm(); ++number)
            sample.points.emplace_back(corners[k - 1] + (number * spacing - start) * segment.normalized());
        start += segment.norm();
    }
    return sample;
}

double measure_volume(const Shape& shape, double spacing) {
    const Lattice lattice = lattice_over(shape, spacing, "quadrature spacing");
    std::vector<double> layers(lattice.count[2], 0.0);
    tbb::parallel_for(std::size_t{0}, layers.size(), [&](std::size_t k) {
        for (std::size_t j = 0; j < lattice.count[1]; ++j)
            for (std::size_t i = 0; i < lattice.count[0]; ++i)
                layers[k] += covered_share(shape.signed_distance(lattice.center(i, j, k)), spacing);
    });
    return std::accumulate(layers.begin(), layers.end(), 0.0) * spacing * spacing * spacing;
}

}  // namespace perimpm
