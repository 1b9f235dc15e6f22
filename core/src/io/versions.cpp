#include "io/versions.hpp"

#include <fmt/format.h>
#include <tbb/version.h>

#include <Eigen/Core>
#include <sstream>

#include "perimpm/plugin/registry.hpp"
#include "plugin/instruction_set.hpp"

namespace perimpm {
namespace {

using Versions = std::vector<std::pair<std::string, std::string>>;

#if defined(__clang__)
constexpr const char* kCompiler = "Clang " __clang_version__;
#else
constexpr const char* kCompiler = "GCC " __VERSION__;
#endif

/// A module lists its libraries as "name version, name version".
void add_module(Versions& list, const std::string& module) {
    using Text = const char*();
    std::istringstream words(reinterpret_cast<Text*>(open_module(module, "perimpm_module_versions"))());
    for (std::string name, version; words >> name >> version; list.emplace_back(name, version))
        if (version.ends_with(',')) version.pop_back();
}

}  // namespace

Versions versions(const std::vector<std::string>& modules) {
    const std::string instructions = instruction_set_folders().front();
    Versions list = {{"perimpm", PERIMPM_VERSION},
                     {"compiler", kCompiler},
                     {"build", PERIMPM_BUILD_TYPE},
                     {"instruction set", instructions.empty() ? baseline_name() : instructions},
                     {"Eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
                     {"oneTBB", TBB_runtime_version()}};
    for (const std::string& module : modules) add_module(list, module);
    return list;
}

}  // namespace perimpm
