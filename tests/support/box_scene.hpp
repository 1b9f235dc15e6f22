#pragma once

#include <string>
#include <vector>

/// A cube of 8x8x8 particles at h = 0.05 m in cells of 0.1 m, double precision, without gravity: volume 0.064 m^3, mass
/// 64 kg, centre (0.2, 0.2, 0.2) m, lambda = mu = 4e4 Pa.
inline const char* const kBox = R"(format = 1
[simulation]
end_time = 1
precision = "double"
gravity = [0, 0, 0]
[grid]
spacing = 0.1
[transfer]
type = "apic"
[material.rubber]
density = 1000
constitutive = { type = "fixed_corotated", youngs_modulus = 1e5, poisson_ratio = 0.25 }
[[body]]
material = "rubber"
particle_spacing = 0.05
shape = { type = "box", min = [0, 0, 0], max = [0.4, 0.4, 0.4] }
)";

using Overrides = std::vector<std::string>;

// Overrides of it.
inline const std::string kBonds = R"(material.rubber.constitutive={ type = "pd_bond", youngs_modulus = 1e5 })";
inline const std::string kElastic =
    R"(material.rubber.constitutive={ type = "pd_elastic", youngs_modulus = 1e5, horizon = 1.1 })";
inline const std::string kStresses =
    R"(material.rubber.constitutive={ type = "pd_correspondence", divergence = "grid",)"
    R"( law = { type = "fixed_corotated", youngs_modulus = 1e5, poisson_ratio = 0.25 } })";
inline const std::string kNoGrid = R"(transfer={ type = "particle" })";
inline const std::string kNeverBreaks =
    R"(material.rubber.fracture={ type = "critical_stretch", critical_stretch = 1e3 })";
inline const std::string kOnGrid = R"(material.rubber.crack_surface="grid")";
/// Halves of the cube, above and below y = 0.2 m.
inline const std::string kCrack = R"(crack=[{ shape = { type = "plane", point = [0, 0.2, 0], normal = [0, 1, 0] } }])";
/// Four particles in a row along x, at 0.025, 0.075, 0.125 and 0.175 m.
inline const std::string kRow = R"(body.0.shape={ type = "box", min = [0, 0, 0], max = [0.2, 0.05, 0.05] })";
/// One particle at (0.025, 0.025, 0.025) m.
inline const std::string kPoint = R"(body.0.shape={ type = "box", min = [0, 0, 0], max = [0.05, 0.05, 0.05] })";
/// The half space below y = 0, rising at 5 m/s.
inline const std::string kRisingFloor =
    R"(collider=[{ shape = { type = "plane", point = [0, 0, 0], normal = [0, 1, 0] }, velocity = [0, 5, 0] }])";
inline const std::string kFloor = R"(collider=[{ shape = { type = "plane", point = [0, 0, 0], normal = [0, 1, 0] } }])";
