#pragma once

#include <vector>

#include "perimpm/scene/scene.hpp"

namespace perimpm {

/// The particles of one body before they become state.
struct BodySample {
    const BodySpec* spec;
    std::vector<Vec3> points;
    Vec3 center;             ///< centre of mass [m]
    double spacing;          ///< lattice spacing h, or the same number density's [m]
    double particle_volume;  ///< [m^3]
};

/// Samples every body of the scene. Throws InputError: a shape without any particle, particles outside the domain.
std::vector<BodySample> sample_bodies(const Scene& scene);

/// Indices of the points along a Z-order curve with cells of `width`.
std::vector<std::uint32_t> morton_order(const std::vector<Vec3>& points, double width);
/// Indices of the points along rows of cells of `width`, which run along the longest axis of the points. Eight rows side by
/// side are one band, walked through the third axis: neighbours in the order are neighbours in a row, and those of a row
/// are still in the cache.
std::vector<std::uint32_t> row_order(const std::vector<Vec3>& points, double width);
/// The points of a lattice, moved by less than a hundredth of its spacing so that differences between them are exact in the
/// precision Real: then two bonds of the same shape have the same length, bit by bit. Other points, and lattices too
/// large for that, stay as they are.
template <class Real>
std::vector<Vec3> exact_lattice(const std::vector<Vec3>& points, double spacing);

/// Value of a ramp at a point: linear between its two points, constant beyond them.
double value_at(const Ramp& ramp, const Vec3& x);

}  // namespace perimpm
