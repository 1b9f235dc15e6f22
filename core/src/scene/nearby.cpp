#include "scene/nearby.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "perimpm/error.hpp"

namespace perimpm {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostShown = 10;

std::vector<std::string> files_of(const fs::path& folder, const std::vector<std::string>& extensions) {
    std::vector<std::string> names;
    std::error_code unreadable;
    for (const fs::directory_entry& entry : fs::directory_iterator{folder, unreadable})
        if (std::ranges::count(extensions, entry.path().extension().string()) > 0)
            names.push_back(entry.path().filename().string());
    std::ranges::sort(names);
    return names;
}

/// Extensions do not count: they are what a name is most often given without.
std::string nearest_file(const fs::path& missing, const std::vector<std::string>& names) {
    std::vector<std::string> stems;
    for (const std::string& name : names) stems.push_back(fs::path{name}.stem().string());
    const std::string stem = nearest(missing.stem().string(), stems);
    if (stem.empty()) return "";
    return names[static_cast<std::size_t>(std::ranges::find(stems, stem) - stems.begin())];
}

}  // namespace

std::string nearby_files(const fs::path& missing, const std::vector<std::string>& extensions) {
    const fs::path folder = fs::absolute(missing).lexically_normal().parent_path();
    if (!fs::is_directory(folder)) return fmt::format("\n  there is no folder '{}'", folder.string());
    const std::vector<std::string> names = files_of(folder, extensions);
    if (names.empty()) return fmt::format("\n  no {} file is in {}", fmt::join(extensions, ", "), folder.string());
    const std::string near = nearest_file(missing, names);
    const std::size_t shown = std::min(names.size(), kMostShown);
    return fmt::format("\n  {}in {}: {}{}", near.empty() ? "" : fmt::format("did you mean '{}'?   ", near),
                       folder.string(),
                       fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(shown), ", "),
                       shown < names.size() ? fmt::format(" and {} more", names.size() - shown) : "");
}

}  // namespace perimpm
