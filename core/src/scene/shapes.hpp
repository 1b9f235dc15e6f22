#pragma once

#include <span>
#include <string>

#include "perimpm/model/params.hpp"
#include "perimpm/scene/scene.hpp"

namespace perimpm {

/// Throws InputError unless `shape` describes a shape that can be built; mesh files are only looked for.
/// what: the owner in messages, e.g. "body 0 ('ball')". A body must be bounded: no plane.
void check_shape(const Value& shape, const std::string& what, const std::string& folder, bool for_body);

/// Throws InputError unless the keys `edge_u` and `edge_v` span a rectangle.
void check_rectangle(const Reader& shape);

/// Of the bodies that a checked shape is made for: 3 solids (and the surfaces of meshes), 2 sheets, 1 strands.
std::uint32_t shape_dimension(const Value& shape);

/// Fills a sheet or strand with particles; relative files start in `folder`.
PERIMPM_API LayerSample sample_layer(const BodySpec& body, const std::string& folder, double spacing);
/// How many particles that will be, as far as the scene tells without opening a mesh, of which 0 are counted.
PERIMPM_API double layer_count(const BodySpec& body, double spacing);

/// The triangles of a checked shape of type "mesh"; relative files start in `folder`.
PERIMPM_API TriangleMesh read_triangles(const Value& shape, const std::string& folder);

/// The keys of a checked shape's type.
std::span<const ParamSpec> shape_keys(const Value& shape);

}  // namespace perimpm
