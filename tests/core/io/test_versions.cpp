// PERIMPM_SOURCE: folder of this repository, whose CMakeLists.txt states the version.
#include <Eigen/Core>

#include "io/versions.hpp"
#include "support/catch.hpp"
#include "support/environment.hpp"
#include "support/files.hpp"
#include "support/message.hpp"

using namespace perimpm;

namespace {

using Versions = std::vector<std::pair<std::string, std::string>>;

std::string version_of(const Versions& list, const std::string& name) {
    for (const auto& [key, value] : list)
        if (key == name) return value;
    return "";
}

bool starts_with_digit(const std::string& text) { return !text.empty() && text[0] >= '0' && text[0] <= '9'; }

}  // namespace

TEST_CASE("versions: what every run depends on, perimpm first", "[io]") {
    const Versions list = versions({});
    std::string names;
    for (const auto& [name, version] : list) names += name + ", ";
    CHECK(names == "perimpm, compiler, build, instruction set, Eigen, oneTBB, ");
    CHECK(contains(text_of(PERIMPM_SOURCE "/CMakeLists.txt"), "VERSION " + list[0].second + " "));
    const auto number = [](int n) { return std::to_string(n); };
    CHECK(version_of(list, "Eigen") ==
          number(EIGEN_WORLD_VERSION) + "." + number(EIGEN_MAJOR_VERSION) + "." + number(EIGEN_MINOR_VERSION));
    CHECK(starts_with_digit(version_of(list, "oneTBB")));
    CHECK_FALSE(version_of(list, "compiler").empty());
    CHECK_FALSE(version_of(list, "build").empty());
}

#if defined(__x86_64__)
TEST_CASE("versions: the instruction set is the one that plugins are taken from", "[io]") {
    const EnvironmentVariable isa{"PERIMPM_ISA", "x86-64-v2"};
    CHECK(version_of(versions({}), "instruction set") == "x86-64-v2");
}
#endif

TEST_CASE("versions: a module adds the libraries that it links", "[io]") {
    const Versions plain = versions({});
    const Versions both = versions({"hdf5", "mesh"});
    REQUIRE(both.size() > plain.size());
    CHECK(Versions(both.begin(), both.begin() + static_cast<std::ptrdiff_t>(plain.size())) == plain);
    for (const char* name : {"HDF5", "assimp", "OpenVDB"}) {
        CAPTURE(name);
        CHECK(starts_with_digit(version_of(both, name)));
        CHECK(version_of(plain, name).empty());
    }
    CHECK(version_of(versions({"hdf5"}), "OpenVDB").empty());
}

TEST_CASE("versions: a module that was not built is named", "[io]") {
    CHECK(contains(message_of([] { versions({"hdf6"}); }), "hdf6"));
}
