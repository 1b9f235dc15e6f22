#pragma once

#include <span>

#include "perimpm/model/params.hpp"

/// Every key that core itself reads in a scene. Models add their own tables.
namespace perimpm::keys {

extern const std::span<const ParamSpec> kScene;
extern const std::span<const ParamSpec> kSimulation;
extern const std::span<const ParamSpec> kGrid;
extern const std::span<const ParamSpec> kDomain;
extern const std::span<const ParamSpec> kFaces;
extern const std::span<const ParamSpec> kMaterial;
extern const std::span<const ParamSpec> kBody;
extern const std::span<const ParamSpec> kCollider;
extern const std::span<const ParamSpec> kCondition;
extern const std::span<const ParamSpec> kCrack;
extern const std::span<const ParamSpec> kOutput;

extern const std::span<const ParamSpec> kBox;
extern const std::span<const ParamSpec> kSphere;
extern const std::span<const ParamSpec> kCylinder;
extern const std::span<const ParamSpec> kRectangle;
extern const std::span<const ParamSpec> kDisc;
extern const std::span<const ParamSpec> kPolyline;
extern const std::span<const ParamSpec> kPlane;
extern const std::span<const ParamSpec> kMesh;

}  // namespace perimpm::keys
