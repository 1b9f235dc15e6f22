// PERIMPM_SOURCE: folder of this repository. Unit tests mirror the sources: core/src/step/sort.cpp is tested by
// tests/core/step/test_sort.cpp, plugins/constitutive/pd_bond.cpp by tests/plugins/test_pd_bond.cpp.
#include <algorithm>
#include <map>

#include "support/catch.hpp"
#include "support/files.hpp"

namespace {

namespace fs = std::filesystem;
const fs::path kRoot = PERIMPM_SOURCE;
constexpr std::ptrdiff_t kFewLines = 40;  ///< shorter files have no test of their own

/// Files that the test of another file covers, and why.
const std::map<std::string, std::string> kCovered = {
    {"geometry/poisson.cpp", "geometry/test_sampling.cpp"},  // the two kinds of sampling share their criteria
    {"scene/bodies.cpp", "scene/test_scene.cpp"},            // parts of read_scene, seen through its errors
    {"scene/checks.cpp", "scene/test_scene.cpp"},
    {"model/interfaces.cpp", "plugin/test_registry.cpp"},
    {"scene/keys.cpp", "scene/test_scene.cpp"},
    {"scene/models.cpp", "scene/test_scene.cpp"},
    {"scene/text.cpp", "scene/test_tree.cpp"},  // a tree's two directions: to text and from text
    {"scene/toml.cpp", "scene/test_tree.cpp"},
    {"step/transfer.hpp", "step/test_scatter.cpp"},  // copies that only scatter and gather make
    {"step/world.hpp", "step/test_build.cpp"},       // data, and loops that every stage's test runs
};

std::ptrdiff_t lines(const fs::path& file) {
    const std::string text = text_of(file);
    return std::count(text.begin(), text.end(), '\n');
}

/// A header's code is tested where its source file is.
bool needs_test(const fs::path& file) {
    const bool header = file.extension() == ".hpp" && !fs::exists(fs::path(file).replace_extension(".cpp"));
    return (file.extension() == ".cpp" || header) && lines(file) > kFewLines;
}

/// Where the test of a source file is: a module opened at run time is tested as one.
fs::path test_of(const fs::path& file) {
    const std::string folder = file.parent_path().filename();
    if (folder.ends_with("_module"))
        return file.parent_path().parent_path() / ("test_" + folder.substr(0, folder.size() - 7) + ".cpp");
    return file.parent_path() / ("test_" + file.stem().string() + ".cpp");
}

}  // namespace

TEST_CASE("mirror: every file of the core has its test", "[contract]") {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / "core/src")) {
        if (!entry.is_regular_file() || !needs_test(entry.path())) continue;
        const fs::path file = fs::relative(entry.path(), kRoot / "core/src");
        const auto covered = kCovered.find(file.string());
        CAPTURE(file);
        CHECK(
            fs::exists(kRoot / "tests/core" / (covered == kCovered.end() ? test_of(file) : fs::path(covered->second))));
    }
}

TEST_CASE("mirror: every larger plugin has its test", "[contract]") {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / "plugins")) {
        if (!entry.is_regular_file() || !needs_test(entry.path())) continue;
        CAPTURE(entry.path());
        CHECK(fs::exists(kRoot / "tests/plugins" / test_of(entry.path().filename())));
    }
}

TEST_CASE("mirror: the exceptions are still needed", "[contract]") {
    for (const auto& [file, test] : kCovered) {
        CAPTURE(file);
        REQUIRE(fs::exists(kRoot / "core/src" / file));
        CHECK(needs_test(kRoot / "core/src" / file));
        CHECK_FALSE(fs::exists(kRoot / "tests/core" / test_of(file)));
    }
}
