#include <algorithm>
#include <set>

#include "step/sampling.hpp"
#include "support/box_scene.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/scene.hpp"

using namespace perimpm;

TEST_CASE("sampling: a body's particles share its volume, about its centre", "[step]") {
    const Scene scene = scene_from(kBox);
    const auto samples = sample_bodies(scene);
    REQUIRE(samples.size() == 1);
    CHECK(samples[0].points.size() == 512);
    CHECK(samples[0].spec == &scene.bodies[0]);
    CHECK_THAT(samples[0].particle_volume, WithinRel(0.05 * 0.05 * 0.05, 1e-12));
    CHECK((samples[0].center - Vec3::Constant(0.2)).norm() < 1e-12);
    const Scene by_cell = scene_from(kBox, {R"(body=[{ material = "rubber", particles_per_cell = 64,)"
                                            R"( shape = { type = "box", min = [0, 0, 0], max = [0.4, 0.4, 0.4] } }])"});
    CHECK_THAT(sample_bodies(by_cell)[0].spacing, WithinRel(0.025, 1e-12));
}

TEST_CASE("sampling: Poisson-disk particles share the shape's volume", "[step]") {
    const Scene scene = scene_from(kBox, {R"(body.0.sampling="poisson")"});
    const BodySample sample = sample_bodies(scene)[0];
    CHECK_THAT(sample.particle_volume * static_cast<double>(sample.points.size()), WithinRel(0.064, 1e-9));
    CHECK_THAT(static_cast<double>(sample.points.size()),
               WithinRel(512.0, 0.25));  // the lattice's, and more at surfaces
}

TEST_CASE("sampling: jitter moves the lattice's points within their cells, by the seed alone", "[step]") {
    const auto points = [](const Overrides& overrides) { return sample_bodies(scene_from(kBox, overrides))[0].points; };
    const auto even = points({}), uneven = points({"body.0.jitter=0.5"}), less = points({"body.0.jitter=0.25"});
    REQUIRE(uneven.size() == even.size());
    Vec3 mean = Vec3::Zero(), square = Vec3::Zero();
    for (std::size_t p = 0; p < even.size(); ++p) {
        const Vec3 shift = uneven[p] - even[p];
        CHECK(shift.cwiseAbs().maxCoeff() <= 0.025);
        CHECK((less[p] - even[p] - 0.5 * shift).norm() <= 1e-15);
        mean += shift / 512, square += shift.cwiseAbs2() / 512;
    }
    CHECK(mean.norm() < 3 * 0.025 / std::sqrt(512.0));  // of a uniform shift: 0 to three deviations of the norm
    CHECK_THAT(std::sqrt(square.sum() / 3), WithinRel(0.025 / std::sqrt(3.0), 0.05));
    CHECK(points({"body.0.jitter=0.5"}) == uneven);
    CHECK(points({"body.0.jitter=0.5", "body.0.seed=2"}) != uneven);
    CHECK(contains(message_of([&] {
                       points({"body.0.sampling=\"poisson\"", "body.0.jitter=0.1"});
                   }),
                   "Poisson points"));
}

TEST_CASE("sampling: what cannot be filled is refused where it is given", "[step]") {
    const auto refusal = [](const std::string& change) {
        return message_of([&] { sample_bodies(scene_from(kBox, {change})); });
    };
    const std::string outside = refusal("grid.domain={ min = [0, 0, 0.1], max = [1, 1, 1] }");
    CHECK(contains(outside, "128 of 512 particles of body 'body 0' lie outside grid.domain"));
    CHECK(contains(outside, "s.toml:"));
    const std::string tiny = R"(body.0.shape={ type = "sphere", center = [0, 0, 0], radius = 1e-3 })";
    CHECK(contains(refusal(tiny), "no particle of spacing 0.05 m fits into body 'body 0'"));
}

TEST_CASE("sampling: the Z-order curve visits every point once, one octant after the other", "[step]") {
    std::vector<Vec3> points;
    for (int n = 0; n < 64; ++n) points.emplace_back(n / 16, n / 4 % 4, n % 4);
    const auto order = morton_order(points, 1.0);
    auto sorted = order;
    std::sort(sorted.begin(), sorted.end());
    for (std::uint32_t i = 0; i < 64; ++i) CHECK(sorted[i] == i);
    for (std::size_t octant = 0; octant < 8; ++octant)
        for (std::size_t i = 0; i < 8; ++i) {
            const Vec3& x = points[order[8 * octant + i]];
            CHECK((x[0] >= 2) * 4u + (x[1] >= 2) * 2u + (x[2] >= 2) * 1u == octant);
        }
    CHECK(morton_order({Vec3(0, 0, 0), Vec3(1e9, 0, 0), Vec3(5e8, 0, 0)}, 1e-3) == std::vector<std::uint32_t>{0, 2, 1});
}

TEST_CASE("sampling: rows run along the longest axis, eight side by side through the shortest", "[step]") {
    std::vector<Vec3> points;
    for (int n = 0; n < 3 * 40 * 20; ++n) points.push_back(0.1 * Vec3(n / 20 % 40, n % 20, n / 800));
    const auto order = row_order(points, 0.1);
    REQUIRE(order.size() == points.size());
    std::set<std::uint32_t> seen(order.begin(), order.end());
    CHECK(seen.size() == points.size());
    const auto cell = [&](std::size_t n, int axis) { return std::lround(points[order[n]][axis] / 0.1); };
    for (std::size_t n = 0; n < points.size(); ++n) {
        CHECK(cell(n, 0) == static_cast<long>(n % 40));
        const std::size_t row = n / 40, first = row / 24 * 8, wide = first == 16 ? 4 : 8;
        CHECK(cell(n, 1) == static_cast<long>(first + row % 24 % wide));
        CHECK(cell(n, 2) == static_cast<long>(row % 24 / wide));
    }
}

TEMPLATE_TEST_CASE("sampling: differences on an exact lattice are exact, and it is where it was", "[step]", float,
                   double) {
    const double h = 0.1 / 3;
    std::vector<Vec3> points;
    for (int n = 0; n < 1000; ++n) points.push_back(Vec3(0.3, -0.7, 1.1) + h * Vec3(n / 100, n / 10 % 10, n % 10));
    const std::vector<Vec3> exact = exact_lattice<TestType>(points, h);
    std::set<TestType> differences;
    for (std::size_t n = 0; n < points.size(); ++n) {
        CHECK((exact[n] - points[n]).norm() <= 1e-5 * h);
        if (n % 10 == 9) continue;
        const auto here = static_cast<TestType>(exact[n][2]), next = static_cast<TestType>(exact[n + 1][2]);
        CHECK(static_cast<double>(here) == exact[n][2]);
        differences.insert(next - here);
    }
    CHECK(differences.size() == 1);

    for (const double jitter : {1e-6, 0.003, 0.02}) {
        std::vector<Vec3> moved = points;
        moved[500][1] += jitter * h;
        CHECK(exact_lattice<TestType>(moved, h) == moved);
    }
}

TEST_CASE("sampling: a row too long for exact differences in single precision stays where it is", "[step]") {
    std::vector<Vec3> row;
    for (int n = 0; n < 3000; ++n) row.emplace_back(0, 0, n * 1e-3 / 3);
    CHECK(exact_lattice<float>(row, 1e-3 / 3) == row);
    CHECK(exact_lattice<double>(row, 1e-3 / 3) != row);
}

TEST_CASE("sampling: a ramp is linear between its ends and constant beyond", "[step]") {
    const Ramp ramp{1.0, 5.0, {0, 0, 0}, {2, 0, 0}};
    CHECK(value_at(ramp, {-1, 0, 0}) == 1.0);
    CHECK(value_at(ramp, {0.5, 7, -7}) == 2.0);
    CHECK(value_at(ramp, {3, 0, 0}) == 5.0);
}
