#include <map>
#include <random>

#include "geometry/triangle_tree.hpp"
#include "support/catch.hpp"

using namespace perimpm;

namespace {

/// Unit octahedron, cut finer and pushed to the sphere; outward.
TriangleMesh ball(int times) {
    TriangleMesh m{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                   {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
    for (; times > 0; --times) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
        const auto between = [&](std::uint32_t i, std::uint32_t j) {
            const auto [at, is_new] =
                middle.try_emplace(std::minmax(i, j), static_cast<std::uint32_t>(m.points.size()));
            if (is_new) m.points.push_back((m.points[i] + m.points[j]).normalized());
            return at->second;
        };
        TriangleMesh finer{{}, {}};
        for (const auto& [a, b, c] : m.triangles) {
            const std::uint32_t ab = between(a, b), bc = between(b, c), ca = between(c, a);
            for (const auto& t : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
                finer.triangles.push_back(t);
        }
        m.triangles = finer.triangles;
    }
    return m;
}

}  // namespace

TEST_CASE("triangle_tree: every way out of a closed surface crosses it, through edges and corners as well",
          "[geometry]") {
    const TriangleMesh mesh = ball(3);
    const TriangleTree tree(mesh);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> share(-1, 1);
    const auto any = [&] { return Vec3(share(random), share(random), share(random)); };
    std::vector<Vec3> targets = mesh.points;
    for (const auto& t : mesh.triangles) {
        targets.push_back(0.5 * (mesh.points[t[0]] + mesh.points[t[1]]));
        targets.push_back((mesh.points[t[0]] + mesh.points[t[1]] + mesh.points[t[2]]) / 3);
    }
    for (const Vec3& through : targets) {
        const Vec3 inside = 0.5 * any();
        for (const Vec3& from : {inside, Vec3(Vec3::Zero())}) {
            const Vec3 beyond = from + 1.5 * (through - from);
            CHECK(tree.crosses(from, beyond));
            CHECK(tree.crosses(beyond, from));
        }
    }
    for (int k = 0; k < 1000; ++k) CHECK_FALSE(tree.crosses(0.5 * any(), 0.5 * any()));  // 0.87 at most
}

TEST_CASE("triangle_tree: a point on a triangle counts to the side of its normal", "[geometry]") {
    const TriangleTree tree({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});
    CHECK(tree.crosses({0.2, 0.2, -1}, {0.2, 0.2, 0}));
    CHECK_FALSE(tree.crosses({0.2, 0.2, 1}, {0.2, 0.2, 0}));
    CHECK_FALSE(tree.crosses({0.7, 0.7, 1}, {0.7, 0.7, -1}));
    CHECK_FALSE(tree.crosses({0.2, 0.2, 2}, {0.2, 0.2, 1}));
}
