#include <algorithm>
#include <fstream>

#include "plugin/instruction_set.hpp"
#include "plugin/search.hpp"
#include "support/catch.hpp"
#include "support/environment.hpp"
#include "support/message.hpp"

using namespace perimpm;
namespace fs = std::filesystem;

namespace {

fs::path touch(const fs::path& file) {
    fs::create_directories(file.parent_path());
    std::ofstream{file} << "not a library: searching never opens it";
    return file;
}

}  // namespace

TEST_CASE("search: a family's folder, or the path folder itself", "[plugin]") {
    const TemporaryFolder folder;
    const fs::path law = touch(folder.path / "constitutive/listed_law.so"), flat = touch(folder.path / "flat_law.so");
    touch(folder.path / "constitutive/notes.txt");
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", folder.path};
    CHECK(find_plugin(Family::constitutive, "listed_law") == law.string());
    CHECK(find_plugin(Family::constitutive, "flat_law") == flat.string());
    CHECK_FALSE(find_plugin(Family::transfer, "listed_law"));
    CHECK_FALSE(find_plugin(Family::constitutive, "notes"));
    CHECK_FALSE(find_plugin(Family::constitutive, ""));
    CHECK_FALSE(find_plugin(Family::constitutive, "constitutive/listed_law"));
}

TEST_CASE("search: shipped plugins are found without a path", "[plugin]") {
    const auto laws = installed(Family::constitutive);
    CHECK(std::any_of(laws.begin(), laws.end(), [](const PluginFile& f) { return f.name == "fixed_corotated"; }));
}

TEST_CASE("search: the best variant for this machine, else the baseline", "[plugin]") {
    const TemporaryFolder folder;
    const fs::path baseline = touch(folder.path / "law.so");
    CHECK(best_variant(baseline) == baseline.string());
    for (const std::string& set : instruction_set_folders()) {
        const fs::path variant = touch(folder.path / set / "law.so");
        CHECK(best_variant(baseline) == (folder.path / instruction_set_folders().front() / "law.so").string());
        if (set == instruction_set_folders().front()) CHECK(best_variant(baseline) == variant.string());
    }
    const fs::path other = touch(folder.path / "other.so");
    touch(folder.path / "x86-64-v9/other.so");
    CHECK(best_variant(other) == other.string());
}
