#pragma once

#include <span>
#include <string>

#include "perimpm/scene/scene.hpp"

namespace perimpm {

/// Opens the plugin that "type" names and checks the table against its parameters. Keys in `extra` besides "type" are
/// let through. Throws InputError at the place of what is wrong.
ModelSpec read_model(const Value& table, Family family, const std::string& what,
                     std::span<const char* const> extra = {});

/// Reads [transfer]; says in `needs_grid` whether the kernel works on a grid of the given spacing [m] (0: none given).
TransferSpec read_transfer(const Value& table, double grid_spacing, bool& needs_grid);

}  // namespace perimpm
