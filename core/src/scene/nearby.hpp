#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace perimpm {

/// For the end of a message about a file that is not there: that its folder is missing, or which file with one of the
/// extensions (".toml") is nearest by name and what else there is.
std::string nearby_files(const std::filesystem::path& missing, const std::vector<std::string>& extensions);

}  // namespace perimpm
