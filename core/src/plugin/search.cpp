#include "plugin/search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <sstream>

#include "perimpm/error.hpp"
#include "plugin/instruction_set.hpp"

namespace perimpm {
namespace {

namespace fs = std::filesystem;

void add_folder(std::vector<fs::path>& folders, const fs::path& folder) {
    const fs::path real = fs::canonical(folder);
    if (std::find(folders.begin(), folders.end(), real) == folders.end()) folders.push_back(real);
}

/// Folders of PERIMPM_PLUGIN_PATH as they stand there.
std::vector<std::string> path_entries() {
    const char* path = std::getenv("PERIMPM_PLUGIN_PATH");
    std::vector<std::string> folders;
    std::istringstream entries{path ? path : ""};
    for (std::string entry; std::getline(entries, entry, ':');) {
        if (entry.empty()) continue;
        if (!fs::is_directory(entry))
            throw InputError{
                "PERIMPM_PLUGIN_PATH",
                fmt::format("the folder '{}' does not exist\n  the variable is '{}'; mend or unset it", entry, path)};
        folders.push_back(entry);
    }
    return folders;
}

/// The shipped plugins first, then PERIMPM_PLUGIN_PATH in order; each folder once.
std::vector<fs::path> plugin_folders() {
    std::vector<fs::path> folders;
    const fs::path shipped = fs::path{library_folder()} / "plugins";
    if (fs::is_directory(shipped)) add_folder(folders, shipped);
    for (const std::string& entry : path_entries()) add_folder(folders, entry);
    return folders;
}

[[noreturn]] void refuse_duplicate(Family family, const std::string& name, const std::string& a, const std::string& b) {
    throw InputError{
        fmt::format("two files claim to be the {} plugin '{}':\n  {}\n  {}\n  rename or remove one of them",
                    family_name(family), name, a, b)};
}

/// Scripts whose names begin with '_' are what laws import.
bool is_plugin_file(Family family, const fs::path& file) {
    if (file.extension() == ".so") return true;
    return is_script(file) && family == Family::constitutive && file.filename().native().front() != '_';
}

/// Baseline file by name.
std::map<std::string, std::string> files_by_name(Family family) {
    std::map<std::string, std::string> files;
    for (const fs::path& folder : plugin_folders()) {
        const fs::path place = folder / family_name(family);
        if (!fs::is_directory(place)) continue;
        for (const fs::directory_entry& entry : fs::directory_iterator{place}) {
            if (!entry.is_regular_file() || !is_plugin_file(family, entry.path())) continue;
            const auto [found, is_new] = files.emplace(entry.path().stem(), entry.path());
            if (!is_new) refuse_duplicate(family, found->first, found->second, entry.path());
        }
    }
    return files;
}

}  // namespace

void check_plugin_path() { path_entries(); }

bool is_script(const std::string& file) { return fs::path{file}.extension() == ".py"; }

std::string best_variant(const std::string& baseline) {
    const fs::path file{baseline};
    for (const std::string& folder : instruction_set_folders()) {
        const fs::path variant = file.parent_path() / folder / file.filename();
        if (fs::is_regular_file(variant)) return variant;
    }
    return baseline;
}

std::optional<std::string> find_plugin(Family family, const std::string& name) {
    std::optional<std::string> result;
    const auto files = files_by_name(family);
    if (const auto found = files.find(name); found != files.end()) result = found->second;
    if (name.empty() || name.find('/') != std::string::npos) return result;
    for (const fs::path& folder : plugin_folders())
        for (const char* extension : {".so", ".py"}) {
            const fs::path flat = folder / (name + extension);
            if (!fs::is_regular_file(flat) || !is_plugin_file(family, flat)) continue;
            if (result) refuse_duplicate(family, name, *result, flat);
            result = flat;
        }
    return result;
}

std::vector<PluginFile> installed(Family family) {
    std::vector<PluginFile> plugins;
    for (const auto& [name, file] : files_by_name(family)) plugins.push_back({family, name, best_variant(file)});
    return plugins;
}

}  // namespace perimpm
