// PERIMPM_SOURCE: folder of this repository. Unit tests mirror the sources: core/src/step/sort.cpp is tested by
// tests/core/step/test_sort.cpp, core/include/perimpm/math/svd3.hpp by tests/core/math/test_svd3.cpp,
// plugins/constitutive/pd_bond.cpp by tests/plugins/test_pd_bond.cpp.
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
    {"step/material.hpp", "step/test_build.cpp"},
    {"step/stages.hpp", "step/test_simulation.cpp"},
    {"model/field.hpp", "step/test_fields.cpp"},  // interfaces and plain data: every model and field there is
    {"model/block.hpp", "../contract/test_every_constitutive_law.cpp"},
    {"model/constitutive_law.hpp", "../contract/test_every_constitutive_law.cpp"},
    {"model/fracture_criterion.hpp", "../contract/test_every_criterion.cpp"},
    {"model/transfer_kernel.hpp", "../contract/test_every_transfer.cpp"},
    {"plugin/plugin.hpp", "plugin/test_registry.cpp"},
    {"geometry/shape.hpp", "geometry/test_analytic.cpp"},
    {"io/frame_writer.hpp", "io/test_hdf5.cpp"},
    {"math/mat3.hpp", "math/test_svd3.cpp"},
    {"model/isotropic.hpp", "../plugins/test_neo_hookean.cpp"},  // parts that models share, by their models
    {"peridynamics/family.hpp", "../plugins/test_pd_bond.cpp"},
    {"peridynamics/family_slice.hpp", "../contract/test_every_constitutive_law.cpp"},
    {"peridynamics/influence.hpp", "../plugins/test_pd_lps.cpp"},
    {"peridynamics/weights.hpp", "../plugins/test_pd_bond.cpp"},
    {"peridynamics/averaged_bonds.hpp", "../plugins/test_pd_elastic.cpp"},
    {"peridynamics/averaged_family.hpp", "../plugins/test_pd_elastic.cpp"},
    {"peridynamics/averaged_slice.hpp", "../contract/test_every_constitutive_law.cpp"},
    {"peridynamics/averaged_sweep.hpp", "../plugins/test_pd_elastic.cpp"},
    {"peridynamics/averaged_forces.hpp", "../plugins/test_pd_elastic.cpp"},
    {"peridynamics/averaged_bond_params.hpp", "../plugins/test_pd_elastic.cpp"},
    {"peridynamics/bond_flow.hpp", "../plugins/test_deviatoric_plastic.cpp"},
    {"transfer/stencils.hpp", "../plugins/test_transfer.cpp"},
    {"transfer/column.hpp", "../plugins/test_transfer.cpp"},
    {"transfer/bspline_transfer.hpp", "../plugins/test_transfer.cpp"},
    {"transfer/bspline_scatter.hpp", "../plugins/test_transfer.cpp"},
    {"transfer/bspline_gather.hpp", "../plugins/test_transfer.cpp"},
};
const fs::path kSources[] = {kRoot / "core/src", kRoot / "core/include/perimpm"};

std::ptrdiff_t lines(const fs::path& file) {
    const std::string text = text_of(file);
    return std::count(text.begin(), text.end(), '\n');
}

/// A header's code is tested where its source file is.
bool needs_test(const fs::path& folder, const fs::path& name) {
    const fs::path file = folder / name;
    const bool header =
        file.extension() == ".hpp" && !fs::exists(kSources[0] / fs::path(name).replace_extension(".cpp"));
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
    for (const fs::path& folder : kSources)
        for (const auto& entry : fs::recursive_directory_iterator(folder)) {
            const fs::path file = fs::relative(entry.path(), folder);
            if (!entry.is_regular_file() || !needs_test(folder, file)) continue;
            const auto covered = kCovered.find(file.string());
            const fs::path test = covered == kCovered.end() ? test_of(file) : fs::path(covered->second);
            CAPTURE(file);
            CHECK(fs::exists(kRoot / "tests/core" / test));
        }
}

TEST_CASE("mirror: every larger plugin has its test", "[contract]") {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / "plugins")) {
        if (!entry.is_regular_file() || !needs_test(kRoot, fs::relative(entry.path(), kRoot))) continue;
        CAPTURE(entry.path());
        CHECK(fs::exists(kRoot / "tests/plugins" / test_of(entry.path().filename())));
    }
}

TEST_CASE("mirror: the exceptions are still needed", "[contract]") {
    for (const auto& [file, test] : kCovered) {
        CAPTURE(file);
        const fs::path& folder = kSources[fs::exists(kSources[0] / file) ? 0 : 1];
        REQUIRE(fs::exists(folder / file));
        CHECK(needs_test(folder, file));
        CHECK_FALSE(fs::exists(kRoot / "tests/core" / test_of(file)));
    }
}
