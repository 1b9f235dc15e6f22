#include <cmath>
#include <limits>
#include <random>

#include "perimpm/geometry/shape.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"

using perimpm::Vec3;

namespace {

bool near(double a, double b) { return std::abs(a - b) < 1e-12; }
bool near(const Vec3& a, const Vec3& b) { return (a - b).norm() < 1e-12; }

/// The normal is the gradient of the distance; the distance changes by at most the way walked.
void check_gradient(const perimpm::Shape& shape) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> coordinate(-2.0, 2.0);
    const double step = 1e-6;
    for (int i = 0; i < 200; ++i) {
        const Vec3 x(coordinate(random), coordinate(random), coordinate(random));
        Vec3 gradient;
        for (int axis = 0; axis < 3; ++axis) {
            const Vec3 d = step * Vec3::Unit(axis);
            gradient(axis) = (shape.signed_distance(x + d) - shape.signed_distance(x - d)) / (2 * step);
        }
        CHECK((gradient - shape.normal(x)).norm() < 1e-4);
        CHECK(near(shape.normal(x).norm(), 1.0));
        CHECK(shape.signed_distance(x - shape.signed_distance(x) * shape.normal(x)) < 1e-9);
    }
}

}  // namespace

TEST_CASE("half space: distance along the normalised normal", "[geometry]") {
    const auto shape = perimpm::make_half_space({0, 1, 0}, {0, 3, 4});
    CHECK(near(shape->signed_distance({5, 1, 0}), 0.0));
    CHECK(near(shape->signed_distance({0, 2, 0}), 0.6));    // (0, 1, 0) . (0, 3, 4) / 5
    CHECK(near(shape->signed_distance({0, 1, -1}), -0.8));  // (0, 0, -1) . (0, 3, 4) / 5
    CHECK(near(shape->normal({9, 9, 9}), Vec3(0, 0.6, 0.8)));
    CHECK(shape->bounds().min().x() == -std::numeric_limits<double>::infinity());
    CHECK(shape->bounds().max().y() == std::numeric_limits<double>::infinity());
}

TEST_CASE("box: distances to face, edge and corner are exact", "[geometry]") {
    const auto shape = perimpm::make_box({-1, -2, -3}, {1, 2, 3});
    CHECK(near(shape->signed_distance({0, 0, 0}), -1.0));
    CHECK(near(shape->signed_distance({0, 1.75, 0}), -0.25));
    CHECK(near(shape->signed_distance({3, 0, 0}), 2.0));
    CHECK(near(shape->signed_distance({4, 6, 0}), 5.0));    // edge: 3, 4
    CHECK(near(shape->signed_distance({-2, -4, 5}), 3.0));  // corner: 1, 2, 2
    CHECK(near(shape->normal({-2, -4, 5}), Vec3(-1, -2, 2) / 3.0));
    CHECK(near(shape->normal({0, -1.75, 0}), Vec3(0, -1, 0)));
    CHECK(near(shape->normal({1, 0, 0}), Vec3(1, 0, 0)));
    CHECK(near(shape->bounds().sizes(), Vec3(2, 4, 6)));
}

TEST_CASE("sphere: distance and normal", "[geometry]") {
    const auto shape = perimpm::make_sphere({1, 0, 0}, 2.0);
    CHECK(near(shape->signed_distance({1, 0, 0}), -2.0));
    CHECK(near(shape->signed_distance({4, 4, 0}), 3.0));  // 5 from the centre
    CHECK(near(shape->normal({4, 4, 0}), Vec3(0.6, 0.8, 0)));
    CHECK(near(shape->normal({1, 0, 0}).norm(), 1.0));
    CHECK(near(shape->bounds().min(), Vec3(-1, -2, -2)));
}

TEST_CASE("cylinder: distances to side, cap and rim are exact", "[geometry]") {
    const auto shape = perimpm::make_cylinder({0, 0, 0}, {0, 4, 0}, 1.0);
    CHECK(near(shape->signed_distance({0, 2, 0}), -1.0));
    CHECK(near(shape->signed_distance({0.2, 3.9, 0}), -0.1));
    CHECK(near(shape->signed_distance({0, 2, 3}), 2.0));
    CHECK(near(shape->signed_distance({0.5, 6, 0}), 2.0));
    CHECK(near(shape->signed_distance({4, 8, 0}), 5.0));  // rim: 3, 4
    CHECK(near(shape->normal({4, 8, 0}), Vec3(0.6, 0.8, 0)));
    CHECK(near(shape->normal({0, -1, 0}), Vec3(0, -1, 0)));
    CHECK(near(shape->normal({0, 2, 0}).norm(), 1.0));
    CHECK(near(shape->bounds().min(), Vec3(-1, 0, -1)));
    CHECK(near(shape->bounds().max(), Vec3(1, 4, 1)));
}

TEST_CASE("cylinder: bounds of an oblique cylinder", "[geometry]") {
    // axis (1, 1, 0) / sqrt(2): the end disks reach r sqrt(1 - 1/2) along x and y and r along z
    const auto shape = perimpm::make_cylinder({0, 0, 0}, {1, 1, 0}, 1.0);
    CHECK(near(shape->bounds().max(), Vec3(1 + std::sqrt(0.5), 1 + std::sqrt(0.5), 1)));
}

TEST_CASE("analytic shapes: the normal is the gradient of the distance", "[geometry]") {
    check_gradient(*perimpm::make_half_space({0.1, 0.2, 0.3}, {1, 2, -1}));
    check_gradient(*perimpm::make_box({-0.7, -0.5, -1.1}, {0.3, 0.8, 0.9}));
    check_gradient(*perimpm::make_sphere({0.1, -0.2, 0.3}, 0.9));
    check_gradient(*perimpm::make_cylinder({-0.6, -0.3, 0.2}, {0.5, 0.6, -0.1}, 0.7));
}

TEST_CASE("analytic shapes: impossible sizes are errors", "[geometry]") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(contains(message_of([] { perimpm::make_half_space({0, 0, 0}, {0, 0, 0}); }), "normal is zero"));
    CHECK(contains(message_of([] { perimpm::make_box({0, 0, 0}, {1, 0, 1}); }), "box: min [0, 0, 0]"));
    CHECK(contains(message_of([] { perimpm::make_sphere({0, 0, 0}, -1.0); }), "sphere: radius"));
    CHECK(contains(message_of([&] { perimpm::make_sphere({0, nan, 0}, 1.0); }), "sphere: center"));
    CHECK(contains(message_of([] { perimpm::make_cylinder({1, 2, 3}, {1, 2, 3}, 1.0); }), "[1, 2, 3]"));
    CHECK(contains(message_of([&] { perimpm::make_cylinder({0, 0, 0}, {1, 0, 0}, nan); }), "cylinder: radius"));
}
