#include "mesh_module/factory.hpp"
#include "perimpm/plugin/registry.hpp"

namespace perimpm {

ShapePtr make_mesh(const std::string& file, const MeshPlacement& placement, double voxel_size) {
    const auto factory = reinterpret_cast<MakeMesh*>(open_module("mesh", "perimpm_make_mesh"));
    return ShapePtr(factory(file, placement, voxel_size));
}

LayerSample sample_mesh_surface(const std::string& file, const MeshPlacement& placement, double spacing,
                                std::uint64_t seed) {
    LayerSample sample{};
    reinterpret_cast<SampleMeshSurface*>(open_module("mesh", "perimpm_sample_mesh_surface"))(file, placement, spacing,
                                                                                             seed, sample);
    return sample;
}

TriangleMesh read_mesh(const std::string& file, const MeshPlacement& placement) {
    TriangleMesh mesh;
    reinterpret_cast<ReadMesh*>(open_module("mesh", "perimpm_read_mesh"))(file, placement, mesh);
    return mesh;
}

TriangleMesh surface_around(const std::vector<Vec3>& points, double spacing) {
    TriangleMesh mesh;
    reinterpret_cast<SurfaceAround*>(open_module("mesh", "perimpm_surface_around"))(points, spacing, mesh);
    return mesh;
}

}  // namespace perimpm
