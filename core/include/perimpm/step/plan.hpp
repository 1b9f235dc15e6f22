#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "perimpm/export.hpp"

namespace perimpm {

/// What a scene compiles to: the passes of one step with the fields they touch, the memory, and what was left out.
struct Plan {
    struct Pass {
        std::string name;  ///< as in `Simulation::pass_times`
        std::string when;  ///< e.g. "each step"
        std::vector<std::string> reads, writes;
        std::string models;  ///< plugins that run in it
    };
    struct Array {
        std::string name;  ///< e.g. "x", "rubber.bonds.neighbour", "grid"
        std::uint64_t bytes;
    };
    struct Material {
        std::string name, law, criterion;
        std::uint64_t particles, bonds;
        double youngs_modulus, poisson_ratio;  ///< as the law has them [Pa], [1]
        double wave_speed;                     ///< [m/s]
    };
    struct TimeStepBound {
        std::string source;  ///< e.g. "apic: 0.6 dx / (c + |v|)"
        double dt;           ///< [s]
    };
    struct Skipped {
        std::string what, why;
    };

    std::vector<Pass> passes;
    std::vector<Array> arrays;
    std::vector<Material> materials;
    std::vector<TimeStepBound> bounds;
    double dt;     ///< the step the run starts with [s]
    double steps;  ///< to the scene's end, were all as long as the first
    std::uint64_t particles;
    std::vector<std::string> libraries;  ///< plugins and modules opened for this scene
    std::vector<Skipped> skipped;
    std::vector<std::string> warnings;  ///< what is allowed but seldom meant, e.g. a body that starts inside a collider
};

}  // namespace perimpm
