#pragma once

#include <optional>
#include <string>

#include "perimpm/plugin/registry.hpp"

namespace perimpm {

/// Whether the file is Python's.
bool is_script(const std::string& file);

/// The baseline file that should hold the plugin: listed under the family, or <name>.so or <name>.py directly in a
/// folder, whose family shows only when it is opened. Throws InputError when more than one file is in question.
std::optional<std::string> find_plugin(Family family, const std::string& name);

/// Throws InputError for a folder of PERIMPM_PLUGIN_PATH that does not exist.
void check_plugin_path();

/// The file beside `baseline` that suits this machine best, or `baseline` itself.
std::string best_variant(const std::string& baseline);

}  // namespace perimpm
