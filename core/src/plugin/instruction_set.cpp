#include "plugin/instruction_set.hpp"

#include <algorithm>
#include <cstdlib>

#include "perimpm/error.hpp"

namespace perimpm {
namespace {

#if defined(__x86_64__)
const std::vector<std::string> kKnown = {"x86-64-v2", "x86-64-v3", "x86-64-v4"};

/// Index into kKnown.
std::ptrdiff_t highest_supported() {
    if (__builtin_cpu_supports("x86-64-v4")) return 2;
    if (__builtin_cpu_supports("x86-64-v3")) return 1;
    if (__builtin_cpu_supports("x86-64-v2")) return 0;
    throw InputError{"this machine's processor lacks instructions of " + kKnown.front() +
                     ", the least that perimpm and its plugins are built for"};
}
#else
const std::vector<std::string> kKnown;
std::ptrdiff_t highest_supported() { return -1; }
#endif

std::ptrdiff_t forced_level(const std::string& name) {
    const auto found = std::find(kKnown.begin(), kKnown.end(), name);
    if (found == kKnown.end()) {
        throw InputError{"PERIMPM_ISA: unknown instruction set '" + name + "'\n  " + suggestion(name, kKnown)};
    }
    const std::ptrdiff_t level = found - kKnown.begin();
    if (level > highest_supported()) {
        throw InputError{"PERIMPM_ISA: this machine does not support '" + name + "'; the highest it supports is '" +
                         kKnown[static_cast<std::size_t>(highest_supported())] + "'"};
    }
    return level;
}

}  // namespace

std::string baseline_name() { return kKnown.empty() ? "portable" : kKnown.front(); }

std::vector<std::string> instruction_set_folders() {
    const char* forced = std::getenv("PERIMPM_ISA");
    std::vector<std::string> folders;
    for (std::ptrdiff_t level = forced ? forced_level(forced) : highest_supported(); level > 0; --level) {
        folders.push_back(kKnown[static_cast<std::size_t>(level)]);
    }
    folders.emplace_back();
    return folders;
}

}  // namespace perimpm
