// Files to triangles, by assimp.
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <utility>

#include "perimpm/error.hpp"
#include "triangle_mesh.hpp"

namespace perimpm {

namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kFormats = {"obj", "ply", "stl", "gltf", "glb"};

std::string lower_extension(const fs::path& path) {
    std::string extension = path.extension().string();
    if (!extension.empty()) extension.erase(0, 1);
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

bool is_mesh_format(const fs::path& path) {
    return std::find(kFormats.begin(), kFormats.end(), lower_extension(path)) != kFormats.end();
}

std::vector<std::string> mesh_files_in(const fs::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
        if (is_mesh_format(entry.path())) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

void require_file(const std::string& file) {
    const fs::path path = fs::absolute(file).lexically_normal();
    if (fs::is_regular_file(path)) return;
    const fs::path folder = path.parent_path();
    if (!fs::is_directory(folder))
        throw InputError(file, "no such mesh file: there is no folder '" + folder.string() + "'");

    std::string message = "no such mesh file in folder '" + folder.string() + "'";
    const auto meshes = mesh_files_in(folder);
    message += meshes.empty() ? ", which holds no meshes" : "\n  " + suggestion(path.filename().string(), meshes);
    throw InputError(file, message);
}

void require_format(const std::string& file) {
    if (is_mesh_format(file)) return;
    const std::string extension = lower_extension(file);
    throw InputError(file, "unknown mesh format '" + extension + "'\n  " + suggestion(extension, kFormats));
}

void require_finite(const aiMesh& part, const std::string& file) {
    const auto finite = [](const aiVector3D& v) {
        return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    };
    const auto bad = part.mNumVertices - std::count_if(part.mVertices, part.mVertices + part.mNumVertices, finite);
    if (bad != 0)
        throw InputError(file, std::to_string(bad) + " vertices have coordinates that are not finite numbers");
}

/// Gathers the triangles of all nodes of an assimp scene in its root's frame.
class Gatherer {
public:
    explicit Gatherer(const aiScene& scene) : scene_(scene) { visit(*scene.mRootNode, aiMatrix4x4()); }
    TriangleMesh take() { return std::move(mesh_); }

private:
    void visit(const aiNode& node, const aiMatrix4x4& parent) {
        const aiMatrix4x4 to_root = parent * node.mTransformation;
        for (unsigned m = 0; m < node.mNumMeshes; ++m) add(*scene_.mMeshes[node.mMeshes[m]], to_root);
        for (unsigned c = 0; c < node.mNumChildren; ++c) visit(*node.mChildren[c], to_root);
    }

    void add(const aiMesh& part, const aiMatrix4x4& to_root) {
        const bool mirrored = to_root.Determinant() < 0.0f;
        for (unsigned f = 0; f < part.mNumFaces; ++f) {
            const aiFace& face = part.mFaces[f];
            if (face.mNumIndices != 3) continue;  // loose points and lines bound no solid
            auto& triangle = mesh_.triangles.emplace_back();
            for (unsigned c = 0; c < 3; ++c) triangle[c] = index_of(to_root * part.mVertices[face.mIndices[c]]);
            if (mirrored) std::swap(triangle[1], triangle[2]);
        }
    }

    /// Files repeat a position for every normal or texture coordinate, and STL for every triangle.
    std::uint32_t index_of(const aiVector3D& v) {
        const std::array<float, 3> position = {v.x + 0.0f, v.y + 0.0f, v.z + 0.0f};  // -0 becomes 0
        const auto [entry, is_new] = index_.try_emplace(position, static_cast<std::uint32_t>(mesh_.points.size()));
        if (is_new) mesh_.points.emplace_back(v.x, v.y, v.z);
        return entry->second;
    }

    const aiScene& scene_;
    TriangleMesh mesh_;
    std::map<std::array<float, 3>, std::uint32_t> index_;
};

}  // namespace

TriangleMesh import_mesh(const std::string& file) {
    require_format(file);
    require_file(file);
    Assimp::Importer importer;
    const aiScene* scene = importer.ReadFile(file, aiProcess_ValidateDataStructure | aiProcess_Triangulate);
    if (!scene) throw InputError(file, std::string("cannot be read as a mesh: ") + importer.GetErrorString());
    for (unsigned m = 0; m < scene->mNumMeshes; ++m) require_finite(*scene->mMeshes[m], file);
    return Gatherer(*scene).take();
}

}  // namespace perimpm
