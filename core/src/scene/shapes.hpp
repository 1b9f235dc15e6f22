#pragma once

#include <span>
#include <string>

#include "perimpm/model/params.hpp"
#include "perimpm/scene/tree.hpp"

namespace perimpm {

/// Throws InputError unless `shape` describes a shape that can be built; mesh files are only looked for.
/// what: the owner in messages, e.g. "body 0 ('ball')". A body must be bounded: no plane.
void check_shape(const Value& shape, const std::string& what, const std::string& folder, bool for_body);

/// The keys of a checked shape's type.
std::span<const ParamSpec> shape_keys(const Value& shape);

}  // namespace perimpm
