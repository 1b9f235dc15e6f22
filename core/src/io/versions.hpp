#pragma once

#include <string>
#include <utility>
#include <vector>

namespace perimpm {

/// Names and versions of this program, of what built it and of the libraries that a run uses. `modules`: the opened
/// parts of perimpm, "mesh" or "hdf5", whose libraries count as well.
std::vector<std::pair<std::string, std::string>> versions(const std::vector<std::string>& modules);

}  // namespace perimpm
