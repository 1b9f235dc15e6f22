#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

/// Contents of a file, "" when it is missing.
inline std::string text_of(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    return {std::istreambuf_iterator<char>{in}, {}};
}

/// Names of the files in a folder.
inline std::set<std::string> files_in(const std::filesystem::path& folder) {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator{folder}) names.insert(entry.path().filename());
    return names;
}
