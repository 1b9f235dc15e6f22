#pragma once

#include "perimpm/scene/scene.hpp"

namespace perimpm {

/// Opens the plugin that "type" names and checks the table against its parameters.
ModelSpec read_model(const Value& table, Family family, const std::string& what);

/// The same for the transfer; also asks the kernel whether it uses a grid.
ModelSpec read_transfer(const Value& table, double grid_spacing, bool& needs_grid);

}  // namespace perimpm
