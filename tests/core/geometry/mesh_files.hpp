#pragma once

#include <array>
#include <sstream>
#include <string>
#include <vector>

#include "perimpm/geometry/shape.hpp"

/// Small meshes as the text of mesh files.
namespace mesh_files {

using perimpm::Vec3;

using Triangle = std::array<int, 3>;

struct Mesh {
    std::vector<Vec3> points;
    std::vector<Triangle> triangles;
};

/// Unit cube; point i has the coordinates of i's bits. Two outward triangles per side.
inline Mesh unit_cube() {
    Mesh cube;
    for (int i = 0; i < 8; ++i) cube.points.emplace_back(i & 1, i >> 1 & 1, i >> 2);
    cube.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                      {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    return cube;
}

inline std::string obj_text(const Mesh& mesh) {
    std::ostringstream out;
    for (const Vec3& p : mesh.points) out << "v " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
    for (const Triangle& t : mesh.triangles) out << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
    return out.str();
}

inline std::string ply_text(const Mesh& mesh) {
    std::ostringstream out;
    out << "ply\nformat ascii 1.0\nelement vertex " << mesh.points.size()
        << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << mesh.triangles.size()
        << "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const Vec3& p : mesh.points) out << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
    for (const Triangle& t : mesh.triangles) out << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
    return out.str();
}

inline std::string stl_text(const Mesh& mesh) {
    std::ostringstream out;
    out << "solid cube\n";
    for (const Triangle& t : mesh.triangles) {
        out << "facet normal 0 0 0\nouter loop\n";
        for (const int i : t) {
            const Vec3& p = mesh.points[std::size_t(i)];
            out << "vertex " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
        }
        out << "endloop\nendfacet\n";
    }
    out << "endsolid cube\n";
    return out.str();
}

inline std::string base64(const std::string& bytes) {
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {  // the buffers below have whole triples
        const auto byte = [&](std::size_t k) {
            return static_cast<unsigned>(static_cast<unsigned char>(bytes[i + k]));
        };
        const unsigned triple = byte(0) << 16 | byte(1) << 8 | byte(2);
        for (const int shift : {18, 12, 6, 0}) out += digits[triple >> shift & 63];
    }
    return out;
}

/// Eight float positions (96 bytes), then 36 16-bit indices (72 bytes); little endian as glTF asks.
inline std::string gltf_buffer(const Mesh& cube) {
    std::string bytes;
    for (const Vec3& p : cube.points)
        for (const double c : p) bytes += c == 0.0 ? std::string(4, '\0') : std::string("\0\0\x80\x3f", 4);  // 0 or 1
    for (const Triangle& t : cube.triangles)
        for (const int i : t) bytes += {static_cast<char>(i), '\0'};
    return bytes;
}

inline std::string gltf_json(const std::string& uri, const std::string& scale) {
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"scale":)" + scale +
           R"(}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"buffers":[{"byteLength":168)" +
           uri + R"(}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":96},{"buffer":0,"byteOffset":96,)" +
           R"("byteLength":72}],"accessors":[{"bufferView":0,"componentType":5126,"count":8,"type":"VEC3",)" +
           R"("min":[0,0,0],"max":[1,1,1]},{"bufferView":1,"componentType":5123,"count":36,"type":"SCALAR"}]})";
}

inline std::string gltf_text(const Mesh& cube, const std::string& scale = "[1,1,1]") {
    return gltf_json(R"(,"uri":"data:application/octet-stream;base64,)" + base64(gltf_buffer(cube)) + '"', scale);
}

inline std::string word(std::size_t value) {  // 32 bits, little endian
    std::string bytes;
    for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift & 255);
    return bytes;
}

inline std::string glb_bytes(const Mesh& cube) {
    std::string json = gltf_json("", "[1,1,1]");
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::string buffer = gltf_buffer(cube);
    return "glTF" + word(2) + word(12 + 8 + json.size() + 8 + buffer.size()) + word(json.size()) + "JSON" + json +
           word(buffer.size()) + std::string("BIN\0", 4) + buffer;
}

}  // namespace mesh_files
