// The one symbol of this module; perimpm opens it with the first mesh of a scene.
#include "factory.hpp"
#include "triangle_mesh.hpp"

extern "C" PERIMPM_API perimpm::MakeMesh perimpm_make_mesh;

perimpm::Shape* perimpm_make_mesh(const std::string& file, const perimpm::MeshPlacement& placement, double voxel_size) {
    perimpm::TriangleMesh mesh = perimpm::import_mesh(file);
    perimpm::check_solid(mesh, file);
    perimpm::place(mesh, placement, file);
    return perimpm::make_level_set(mesh, voxel_size, file).release();
}
