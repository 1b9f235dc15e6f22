#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "perimpm/geometry/shape.hpp"
#include "perimpm/scene/scene.hpp"

namespace perimpm {

/// Small-strain stiffness of families: sheets in plane stress, strands along their line.
struct FamilyStiffness {
    double youngs_modulus, poisson_ratio;  ///< of the isotropic average over directions [Pa], [1]
    double softest, stiffest;              ///< Young's modulus by direction [Pa]
};

/// What a material's law was asked for, and what its families have.
struct MeasuredStiffness {
    std::string material;
    std::uint32_t dimension;               ///< 3: solids, 2: sheets, 1: strands
    double youngs_modulus, poisson_ratio;  ///< asked
    std::uint64_t bulk_particles;          ///< whose neighbours miss none on any side either; local laws: all
    FamilyStiffness bulk;                  ///< their mean, and the extremes among them; NaN when there are none
    double wave_speed;                     ///< of longitudinal waves in the bulk's mean [m/s]
    std::uint64_t surface_particles;       ///< the others
    FamilyStiffness worst;                 ///< of the one whose modulus by direction lies farthest from the one asked
    Vec3 worst_position;                   ///< [m]
    std::uint64_t unstable_particles;      ///< whose families have a negative stiffness
};

/// Measures every material of a scene from the energies of its particles under small affine strains, in double precision;
/// NaN for laws that have no energy. Builds a world of its own; nothing of a run does this.
PERIMPM_API std::vector<MeasuredStiffness> measure_stiffness(Scene scene, int threads = 0);

}  // namespace perimpm
