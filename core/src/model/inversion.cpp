#include "perimpm/model/inversion.hpp"

#include <fmt/format.h>

namespace perimpm {

void throw_inverted(const char* law, double det_F, const double x[3]) {
    throw SimulationError(
        fmt::format("{}: the particle at ({:.4g}, {:.4g}, {:.4g}) m is {}: det F = {:g}, but this law ends at 0\n"
                    "  lower simulation.safety or dt, check the initial F, or use 'fixed_corotated', which goes on",
                    law, x[0], x[1], x[2], det_F < 0 ? "turned inside out" : "crushed to nothing", det_F));
}

}  // namespace perimpm
