#pragma once

#include "perimpm/geometry/shape.hpp"
#include "perimpm/scene/reader.hpp"

namespace perimpm {

inline Vec3 vec3(const Reader& reader, const char* key, std::array<double, 3> fallback = {}) {
    const auto v = reader.vector(key, fallback);
    return {v[0], v[1], v[2]};
}

/// The box between the keys "min" and "max". Throws InputError unless it has a volume.
inline Box3 require_box(const Reader& reader) {
    const Box3 box{vec3(reader, "min"), vec3(reader, "max")};
    if ((box.min().array() >= box.max().array()).any()) reader.fail("max", "must be above 'min' in every component");
    return box;
}

}  // namespace perimpm
