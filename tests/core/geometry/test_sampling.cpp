#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "perimpm/geometry/shape.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"

using perimpm::Vec3;

namespace {

double sphere_volume(double radius) { return 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3); }

double nearest_distance(const Vec3& x, const std::vector<Vec3>& points) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3& p : points) nearest = std::min(nearest, (p - x).norm());
    return nearest;
}

double smallest_distance(const std::vector<Vec3>& points) {
    double smallest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) smallest = std::min(smallest, (points[i] - points[j]).norm());
    return smallest;
}

/// Distance from the worst of many random places inside to the nearest point.
double largest_hole(const perimpm::Shape& shape, const std::vector<Vec3>& points) {
    std::mt19937_64 random(11);
    const perimpm::Box3 box = shape.bounds();
    double hole = 0.0;
    for (int i = 0; i < 20000; ++i) {
        Vec3 x;
        for (int a = 0; a < 3; ++a) x(a) = std::uniform_real_distribution<double>(box.min()(a), box.max()(a))(random);
        if (shape.signed_distance(x) < 0.0) hole = std::max(hole, nearest_distance(x, points));
    }
    return hole;
}

}  // namespace

TEST_CASE("sample_lattice: a box of whole spacings is filled exactly", "[geometry]") {
    const auto box = perimpm::make_box({0.3, -0.1, 7.0}, {0.6, 0.3, 7.5});  // 3 x 4 x 5 spacings
    const auto points = perimpm::sample_lattice(*box, 0.1);
    REQUIRE(points.size() == 60);
    CHECK((points.front() - Vec3(0.35, -0.05, 7.05)).norm() < 1e-12);
    CHECK((points.back() - Vec3(0.55, 0.25, 7.45)).norm() < 1e-12);
}

TEST_CASE("sample_lattice: the last layer of a box of broken spacings depends on its centre", "[geometry]") {
    CHECK(perimpm::sample_lattice(*perimpm::make_box({0, 0, 0}, {0.24, 0.1, 0.1}), 0.1).size() == 2);
    CHECK(perimpm::sample_lattice(*perimpm::make_box({0, 0, 0}, {0.26, 0.1, 0.1}), 0.1).size() == 3);
}

TEST_CASE("sample_lattice: a sphere's points times the cell volume approach its volume", "[geometry]") {
    const auto sphere = perimpm::make_sphere({0.1, 0.2, 0.3}, 1.0);
    for (const double h : {0.1, 0.05, 0.025}) {
        const double volume = double(perimpm::sample_lattice(*sphere, h).size()) * h * h * h;
        // Only cells that the surface cuts can be wrong; their errors have random signs: about area / h^2 of them.
        const double cut_cells = 4.0 * std::numbers::pi / (h * h);
        CHECK(std::abs(volume - sphere_volume(1.0)) < 3.0 * std::sqrt(cut_cells) * h * h * h);
    }
}

TEST_CASE("measure_volume: exact for a box of whole spacings", "[geometry]") {
    const auto box = perimpm::make_box({0, 0, 0}, {0.3, 0.4, 0.5});
    CHECK(std::abs(perimpm::measure_volume(*box, 0.1) - 0.06) < 1e-12);
}

TEST_CASE("measure_volume: second order on a sphere", "[geometry]") {
    const auto sphere = perimpm::make_sphere({0, 0, 0}, 1.0);
    for (const double h : {0.2, 0.1, 0.05, 0.025}) {
        const double error = std::abs(perimpm::measure_volume(*sphere, h) / sphere_volume(1.0) - 1.0);
        CHECK(error < h * h);  // the shell of thickness h holds 3 h of the volume; its curvature is another h
    }
}

TEST_CASE("sample_poisson: no two points nearer than the radius, no hole larger", "[geometry]") {
    const double radius = 0.12;
    for (const auto& shape : {perimpm::make_sphere({0, 0, 0}, 0.8), perimpm::make_box({-0.1, 0, 0}, {1, 0.9, 0.3}),
                              perimpm::make_cylinder({0, 0, 0}, {1, 1, 1}, 0.3)}) {
        const auto points = perimpm::sample_poisson(*shape, radius, 3);
        CHECK(smallest_distance(points) >= radius);
        CHECK(largest_hole(*shape, points) < radius * (1.0 + std::ldexp(1.0, -10)));
        CHECK(std::all_of(points.begin(), points.end(), [&](const Vec3& p) { return shape->signed_distance(p) < 0; }));
    }
}

TEST_CASE("sample_poisson: the seed alone decides", "[geometry]") {
    const auto sphere = perimpm::make_sphere({0, 0, 0}, 1.0);
    const auto points = perimpm::sample_poisson(*sphere, 0.2, 5);
    CHECK(perimpm::sample_poisson(*sphere, 0.2, 5) == points);
    CHECK(perimpm::sample_poisson(*sphere, 0.2, 6) != points);
}

TEST_CASE("sample_poisson: a shape smaller than the radius gets one point", "[geometry]") {
    CHECK(perimpm::sample_poisson(*perimpm::make_sphere({0, 0, 0}, 0.1), 1.0, 1).size() == 1);
}

TEST_CASE("sample_rectangle: cells of the lattice share its area", "[geometry]") {
    const Vec3 corner(1, 2, 3), u(0.3, 0, 0.4), v(-0.16, 0.24, 0.12);  // at right angles, 0.5 and sqrt(0.0976) m long
    const auto sheet = perimpm::sample_rectangle(corner, u, v, 0.02);
    CHECK(sheet.points.size() == 25 * 16);
    CHECK(std::abs(sheet.measure - 4e-4) < 1e-15);
    CHECK((sheet.points.front() - corner - 0.01 * (u.normalized() + v.normalized())).norm() < 1e-12);
    CHECK(std::abs(smallest_distance(sheet.points) - 0.02) < 1e-12);
    for (const Vec3& x : sheet.points) CHECK(std::abs((x - corner).dot(u.cross(v).normalized())) < 1e-12);
}

TEST_CASE("sample_polyline: points lie evenly along the line, across its corners", "[geometry]") {
    const auto strand = perimpm::sample_polyline({{0, 0, 0}, {1.05, 0, 0}, {1.05, 0.95, 0}}, 0.1);
    REQUIRE(strand.points.size() == 20);
    CHECK(strand.measure == 0.1);
    CHECK((strand.points[9] - Vec3(0.95, 0, 0)).norm() < 1e-12);
    CHECK((strand.points[11] - Vec3(1.05, 0.1, 0)).norm() < 1e-12);
    CHECK((strand.points[19] - Vec3(1.05, 0.9, 0)).norm() < 1e-12);
}

TEST_CASE("sampling: what cannot be filled is an error", "[geometry]") {
    const auto plane = perimpm::make_half_space({0, 0, 0}, {0, 1, 0});
    const auto box = perimpm::make_box({0, 0, 0}, {1, 1, 1});
    CHECK(contains(message_of([&] { perimpm::sample_lattice(*plane, 0.1); }), "half space"));
    CHECK(contains(message_of([&] { perimpm::sample_lattice(*box, 0.0); }), "particle spacing is 0"));
    CHECK(contains(message_of([&] { perimpm::sample_lattice(*box, 1e-5); }), "cells"));
    CHECK(contains(message_of([&] { perimpm::sample_poisson(*box, -1.0, 1); }), "expected a positive length"));
    CHECK(contains(message_of([&] { perimpm::measure_volume(*plane, 0.1); }), "half space"));
}
