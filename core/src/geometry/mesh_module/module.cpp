// The symbols of this module; perimpm opens it with the first mesh of a scene.
#include <assimp/version.h>
#include <openvdb/version.h>

#include <string>

#include "factory.hpp"
#include "triangle_mesh.hpp"

extern "C" {
PERIMPM_API perimpm::MakeMesh perimpm_make_mesh;
PERIMPM_API perimpm::SampleMeshSurface perimpm_sample_mesh_surface;
PERIMPM_API perimpm::ReadMesh perimpm_read_mesh;
PERIMPM_API perimpm::SurfaceAround perimpm_surface_around;
PERIMPM_API const char* perimpm_module_versions();
}

perimpm::Shape* perimpm_make_mesh(const std::string& file, const perimpm::MeshPlacement& placement, double voxel_size) {
    perimpm::TriangleMesh mesh = perimpm::import_mesh(file);
    perimpm::check_solid(mesh, file);
    perimpm::place(mesh, placement, file);
    return perimpm::make_level_set(mesh, voxel_size, file).release();
}

void perimpm_sample_mesh_surface(const std::string& file, const perimpm::MeshPlacement& placement, double spacing,
                                 std::uint64_t seed, perimpm::LayerSample& sample) {
    perimpm::TriangleMesh mesh;
    perimpm_read_mesh(file, placement, mesh);
    sample = perimpm::sample_triangles(mesh, spacing, seed);
}

void perimpm_read_mesh(const std::string& file, const perimpm::MeshPlacement& placement, perimpm::TriangleMesh& mesh) {
    mesh = perimpm::import_mesh(file);
    perimpm::check_triangles(mesh, file);
    perimpm::place(mesh, placement, file);
}

void perimpm_surface_around(const std::vector<perimpm::Vec3>& points, double spacing, perimpm::TriangleMesh& mesh) {
    mesh = perimpm::enclose(points, spacing);
}

const char* perimpm_module_versions() {
    static const std::string text = "assimp " + std::to_string(aiGetVersionMajor()) + "." +
                                    std::to_string(aiGetVersionMinor()) + "." + std::to_string(aiGetVersionPatch()) +
                                    ", OpenVDB " + openvdb::getLibraryVersionString();
    return text.c_str();
}
