#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>
#include <thread>
#include <vector>

#include "mesh_files.hpp"
#include "perimpm/geometry/shape.hpp"
#include "support/catch.hpp"
#include "support/environment.hpp"
#include "support/message.hpp"

using namespace mesh_files;

namespace {

class MeshFolder : public TemporaryFolder {
public:
    std::string write(const std::string& name, const std::string& content) const {
        std::ofstream(path / name, std::ios::binary) << content;
        return path / name;
    }
    std::string write(const std::string& name, const Mesh& mesh) const { return write(name, obj_text(mesh)); }
};

std::string error_of(const std::string& file, double voxel_size = 0.1) {
    return message_of([&] { perimpm::make_mesh(file, {}, voxel_size); });
}

std::string bunny() {
    const auto root = std::filesystem::path(PERIMPM_SOURCE);
    return root / "scenes/assets/bunny.obj";
}

/// Divergence theorem: a sixth of the sum of a . (b x c).
double obj_volume(const std::string& file) {
    std::ifstream in(file);
    std::vector<Vec3> points;
    double six_volumes = 0.0;
    for (std::string line; std::getline(in, line);) {
        std::istringstream fields(line);
        std::string kind;
        fields >> kind;
        if (kind == "v") fields >> points.emplace_back().x() >> points.back().y() >> points.back().z();
        if (kind != "f") continue;
        std::size_t a, b, c;
        fields >> a >> b >> c;
        six_volumes += points[a - 1].dot(points[b - 1].cross(points[c - 1]));
    }
    return six_volumes / 6.0;
}

}  // namespace

TEST_CASE("make_mesh: every format gives the same cube", "[geometry][mesh]") {
    const MeshFolder folder;
    const Mesh cube = unit_cube();
    for (const std::string& file :
         {folder.write("cube.obj", obj_text(cube)), folder.write("cube.ply", ply_text(cube)),
          folder.write("cube.stl", stl_text(cube)), folder.write("cube.gltf", gltf_text(cube)),
          folder.write("cube.glb", glb_bytes(cube)), folder.write("UPPER.OBJ", obj_text(cube))}) {
        INFO(file);
        const auto shape = perimpm::make_mesh(file, {}, 0.05);
        CHECK(std::abs(shape->signed_distance({0.5, 0.5, 0.9}) + 0.1) < 1e-6);
        CHECK(std::abs(shape->signed_distance({1.1, 0.5, 0.5}) - 0.1) < 1e-6);
        CHECK((shape->normal({0.5, 0.02, 0.5}) - Vec3(0, -1, 0)).norm() < 1e-6);
        CHECK((shape->bounds().max() - Vec3(1, 1, 1)).norm() < 1e-7);
        CHECK(perimpm::sample_lattice(*shape, 0.1).size() == 1000);
    }
}

TEST_CASE("make_mesh: a mirrored glTF node keeps its faces outward", "[geometry][mesh]") {
    const MeshFolder folder;
    const auto shape = perimpm::make_mesh(folder.write("mirror.gltf", gltf_text(unit_cube(), "[-1,2,1]")), {}, 0.05);
    CHECK(shape->signed_distance({-0.5, 1.5, 0.5}) < -0.4);
    CHECK(shape->signed_distance({0.5, 0.5, 0.5}) > 0.1);
}

TEST_CASE("make_mesh: quads with texture seams are welded", "[geometry][mesh]") {
    const MeshFolder folder;
    Mesh points_only = unit_cube();
    points_only.triangles.clear();
    const std::string faces =
        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 3/2 4/3 2/4\nf 5/1 6/2 8/3 7/4\nf 1/1 2/2 6/3 5/4\n"
        "f 3/1 7/2 8/3 4/4\nf 1/1 5/2 7/3 3/4\nf 2/1 4/2 8/3 6/4\n";
    const auto shape = perimpm::make_mesh(folder.write("quads.obj", obj_text(points_only) + faces), {}, 0.1);
    CHECK(perimpm::sample_lattice(*shape, 0.1).size() == 1000);
}

TEST_CASE("make_mesh: scale, then rotation x y z, then translation", "[geometry][mesh]") {
    const MeshFolder folder;
    const std::string file = folder.write("cube.obj", unit_cube());
    // (1, 1, 1) scaled by 2, turned by 90 degrees about x: (2, -2, 2), then about z: (2, 2, 2), then moved
    const auto shape = perimpm::make_mesh(file, {2.0, {90, 0, 90}, {10, 20, 30}}, 0.1);
    // about x, y -> z and z -> -y: [0, 2] x [-2, 0] x [0, 2]; about z, x -> y and y -> -x: [0, 2]^3
    CHECK((shape->bounds().min() - Vec3(10, 20, 30)).norm() < 1e-6);
    CHECK((shape->bounds().max() - Vec3(12, 22, 32)).norm() < 1e-6);
    // the other order, z first, would end in [-2, 0] x [-2, 0] x [0, 2] (about x after z: y -> z)
    const auto turned = perimpm::make_mesh(file, {1.0, {90, 90, 0}, {0, 0, 0}}, 0.1);
    // about x: [0, 1] x [-1, 0] x [0, 1]; about y, z -> x and x -> -z: [0, 1] x [-1, 0] x [-1, 0]
    CHECK((turned->bounds().min() - Vec3(0, -1, -1)).norm() < 1e-6);
    CHECK((turned->bounds().max() - Vec3(1, 0, 0)).norm() < 1e-6);
    CHECK(contains(message_of([&] { perimpm::make_mesh(file, {-1.0, Vec3::Zero(), Vec3::Zero()}, 0.1); }), "scale"));
}

TEST_CASE("make_mesh: distance and normal stay usable far from the surface", "[geometry][mesh]") {
    const MeshFolder folder;
    const double voxel = 0.05;
    const auto shape = perimpm::make_mesh(folder.write("cube.obj", unit_cube()), {}, voxel);
    CHECK(std::abs(shape->signed_distance({0.5, 0.5, 0.5}) + 0.5) < voxel);  // trilinear across the medial axis
    CHECK(std::abs(shape->signed_distance({0.3, 0.5, 0.5}) + 0.3) < 1e-6);   // inside: the distance at every depth
    const double far = shape->signed_distance({0.5, 4, 0.5});
    CHECK(far >= 4 * voxel);
    CHECK(far <= 3.0 + 1e-6);  // never more than the distance
    for (const Vec3& x : {Vec3(0.5, 0.5, 0.5), Vec3(0.5, 4, 0.5), Vec3(1.5, 1.5, 1.5), Vec3(-30, 0, 2)})
        CHECK(std::abs(shape->normal(x).norm() - 1.0) < 1e-12);
    CHECK(shape->normal({0.5, 40, 0.5}).y() > 0.99);
}

TEST_CASE("make_mesh: the bunny's lattice volume is its mesh volume", "[geometry][mesh]") {
    const double expected = obj_volume(bunny());
    const double h = 0.002;
    const auto shape = perimpm::make_mesh(bunny(), {}, h);
    const double lattice = double(perimpm::sample_lattice(*shape, h).size()) * h * h * h;
    CHECK(std::abs(lattice / expected - 1.0) < 0.01);
    CHECK(std::abs(perimpm::measure_volume(*shape, h) / expected - 1.0) < 0.01);
}

TEST_CASE("sample_mesh_surface: Poisson-disk points on the triangles share their area", "[geometry][mesh]") {
    const MeshFolder folder;
    const std::string file = folder.write("cube.obj", unit_cube());
    const double h = 0.05;
    const auto surface = perimpm::sample_mesh_surface(file, {2.0, {0, 0, 0}, {10, 0, 0}}, h, 3);
    const auto count = static_cast<double>(surface.points.size());
    CHECK(std::abs(surface.measure * count - 24) < 1e-9);
    CHECK(std::abs(count * h * h / 24 - 1) < 0.1);
    double smallest = 1;
    for (std::size_t i = 0; i < surface.points.size(); i += 50)
        for (std::size_t j = 0; j < surface.points.size(); ++j)
            if (i != j) smallest = std::min(smallest, (surface.points[i] - surface.points[j]).norm());
    CHECK(smallest >= 0.83 * h);
    const auto on_face = [](double c) { return std::min(std::abs(c), std::abs(c - 2)) < 1e-6; };
    for (const Vec3& x : surface.points) CHECK((on_face(x[0] - 10) || on_face(x[1]) || on_face(x[2])));
    CHECK(perimpm::sample_mesh_surface(file, {2.0, {0, 0, 0}, {10, 0, 0}}, h, 3).points == surface.points);
}

TEST_CASE("sample_mesh_surface: the mesh may be open, but has triangles with area", "[geometry][mesh]") {
    const MeshFolder folder;
    const std::string open = folder.write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    CHECK(perimpm::sample_mesh_surface(open, {}, 0.1, 1).points.size() > 30);
    const std::string flat = folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    CHECK(contains(message_of([&] { perimpm::sample_mesh_surface(flat, {}, 0.1, 1); }), "degenerate"));
}

TEST_CASE("make_mesh: queries from several threads agree", "[geometry][mesh]") {
    const auto shape = perimpm::make_mesh(bunny(), {}, 0.004);
    const auto points = perimpm::sample_lattice(*shape, 0.004);
    std::array<std::vector<double>, 2> distances;
    std::vector<std::thread> threads;
    for (auto& result : distances)
        threads.emplace_back([&] {
            for (const Vec3& p : points) result.push_back(shape->signed_distance(p));
        });
    for (auto& thread : threads) thread.join();
    CHECK(distances[0] == distances[1]);
}

TEST_CASE("make_mesh: an open or inconsistent mesh is an error with its edges counted", "[geometry][mesh]") {
    const MeshFolder folder;
    Mesh missing = unit_cube(), flipped = unit_cube(), crowded = unit_cube();
    missing.triangles.pop_back();
    std::swap(flipped.triangles[0][1], flipped.triangles[0][2]);
    crowded.points.emplace_back(-1, -1, 0.5);
    crowded.triangles.push_back({0, 4, 8});  // a fin on the edge 0-4: two open edges and one with three triangles

    const std::string open = error_of(folder.write("missing.obj", missing));
    CHECK(contains(open, "missing.obj"));
    CHECK(contains(open, "3 open edges, 0 non-manifold edges, 0 inconsistently oriented edges of 18"));
    CHECK(contains(error_of(folder.write("flipped.obj", flipped)),
                   "0 open edges, 0 non-manifold edges, 3 inconsistently oriented edges"));
    CHECK(contains(error_of(folder.write("fin.obj", crowded)),
                   "2 open edges, 1 non-manifold edge, 0 inconsistently oriented edges"));
}

TEST_CASE("make_mesh: inverted meshes and cavities are errors", "[geometry][mesh]") {
    const MeshFolder folder;
    Mesh inverted = unit_cube();
    for (Triangle& t : inverted.triangles) std::swap(t[1], t[2]);
    CHECK(contains(error_of(folder.write("inverted.obj", inverted)), "inverted mesh: its faces point inwards"));

    Mesh hollow = unit_cube();
    for (Vec3& p : hollow.points) p *= 3.0;
    for (const Vec3& p : inverted.points) hollow.points.push_back(p + Vec3(1, 1, 1));
    for (const Triangle& t : inverted.triangles) hollow.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
    CHECK(contains(error_of(folder.write("hollow.obj", hollow)), "1 of the mesh's 2 closed parts point"));
}

TEST_CASE("make_mesh: triangles without area are counted", "[geometry][mesh]") {
    const MeshFolder folder;
    Mesh mesh = unit_cube();
    mesh.triangles.push_back({0, 1, 1});
    mesh.points.emplace_back(0.5, 0, 0);
    mesh.triangles.push_back({0, 8, 1});  // three points on a line
    CHECK(contains(error_of(folder.write("flat.obj", mesh)), "2 degenerate triangles (zero area) of 14"));
}

TEST_CASE("make_mesh: files that hold no mesh", "[geometry][mesh]") {
    const MeshFolder folder;
    for (const std::string extension : {"obj", "ply", "stl", "gltf", "glb"}) {
        const std::string message = error_of(folder.write("empty." + extension, ""));
        INFO(message);
        CHECK(contains(message, "empty." + extension));
        CHECK(contains(message, "cannot be read as a mesh"));
    }
    CHECK(contains(error_of(folder.write("line.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nl 2 3\n")), "no triangles"));
    CHECK(contains(error_of(folder.write("nan.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n")), "not finite"));
}

TEST_CASE("make_mesh: a missing file names the folder and the nearest file", "[geometry][mesh]") {
    const MeshFolder folder;
    folder.write("bunny.obj", unit_cube());
    const std::string message = error_of(folder.path / "buny.obj");
    CHECK(contains(message, "in folder '" + folder.path.string() + "'"));
    CHECK(contains(message, "did you mean 'bunny.obj'?"));
    CHECK(contains(error_of(folder.path / "nowhere/bunny.obj"), "there is no folder"));
    CHECK(contains(error_of(folder.write("cube.objj", unit_cube())), "unknown mesh format 'objj'"));
}

TEST_CASE("make_mesh: cloth-thin meshes and unfit voxels are errors", "[geometry][mesh]") {
    const MeshFolder folder;
    for (const double thickness : {0.01, 0.03}) {
        Mesh cloth = unit_cube();
        for (Vec3& p : cloth.points) p.y() *= thickness;
        const std::string message = error_of(folder.write("cloth.obj", cloth), 0.1);
        CHECK(contains(message, "thinner than a voxel"));
        CHECK(contains(message, "smaller"));
    }
    const std::string cube = folder.write("cube.obj", unit_cube());
    CHECK(contains(error_of(cube, 0.0), "voxel size is 0"));
    CHECK(contains(error_of(cube, 1e-4), "larger spacing"));
}

namespace {

/// Enclosed by the divergence theorem, and whether every edge has two triangles of opposite direction.
std::pair<double, bool> volume_of(const perimpm::TriangleMesh& mesh) {
    double six_volumes = 0;
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& t : mesh.triangles) {
        six_volumes += mesh.points[t[0]].dot(mesh.points[t[1]].cross(mesh.points[t[2]]));
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = t[static_cast<std::size_t>(k)], b = t[static_cast<std::size_t>((k + 1) % 3)];
            edges[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
        }
    }
    const bool closed = std::all_of(edges.begin(), edges.end(), [](const auto& e) { return e.second == 0; });
    return {six_volumes / 6, closed};
}

}  // namespace

TEST_CASE("surface_around: a lattice of particles has the volume of their cells", "[geometry][mesh]") {
    for (const double spacing : {1.0, 0.01}) {
        std::vector<Vec3> points;
        for (int i = 0; i < 10; ++i)
            for (int j = 0; j < 8; ++j)
                for (int k = 0; k < 6; ++k) points.push_back(Vec3(3, -2, 50) + spacing * Vec3(i, j, k));
        const perimpm::TriangleMesh mesh = perimpm::surface_around(points, spacing);
        const auto [volume, closed] = volume_of(mesh);
        CHECK(closed);
        CHECK_THAT(volume / std::pow(spacing, 3), WithinRel(480.0, 0.05));  // edges are round
        double highest = -1e9;
        for (const Vec3& p : mesh.points) highest = std::max(highest, (p[0] - 3) / spacing);
        CHECK_THAT(highest, WithinAbs(9.5, 0.15));
    }
}

TEST_CASE("surface_around: a particle alone is a ball, two parts apart are two", "[geometry][mesh]") {
    const auto [ball, closed] = volume_of(perimpm::surface_around({Vec3(1, 2, 3)}, 0.1));
    CHECK(closed);
    CHECK_THAT(ball, WithinRel(4.0 / 3 * std::numbers::pi * std::pow(0.05, 3), 0.25));
    const auto [two, both] = volume_of(perimpm::surface_around({Vec3(1, 2, 3), Vec3(9, 2, 3)}, 0.1));
    CHECK(both);
    CHECK_THAT(two, WithinRel(2 * ball, 0.05));
}

TEST_CASE("surface_around: what has no surface", "[geometry][mesh]") {
    CHECK(perimpm::surface_around({}, 0.1).triangles.empty());
    CHECK(contains(message_of([] { perimpm::surface_around({Vec3::Zero()}, 0); }), "expected a positive length in m"));
    CHECK(contains(message_of([] { perimpm::surface_around({Vec3(0, std::nan(""), 0)}, 1); }), "is not finite"));
}
