// What a message about a missing file adds, seen through the reader of scene files.
#include <fmt/format.h>

#include <fstream>

#include "perimpm/scene/tree.hpp"
#include "support/catch.hpp"
#include "support/environment.hpp"
#include "support/message.hpp"

using namespace perimpm;

namespace {

/// What the message says beyond the first line.
std::string hint(const std::filesystem::path& missing) {
    const std::string message = message_of([&] { parse_scene_file(missing); });
    const std::string first = missing.string() + ": error: there is no such scene\n  ";
    REQUIRE(message.starts_with(first));
    return message.substr(first.size());
}

}  // namespace

TEST_CASE("nearby: the nearest name and at most ten files", "[scene]") {
    const TemporaryFolder folder;
    const std::string place = folder.path.string();
    CHECK(hint(folder.path / "missing.toml") == "no .toml file is in " + place);
    for (const char* name : {"missin.toml", "beam.toml", "missing.txt"}) std::ofstream{folder.path / name};
    CHECK(hint(folder.path / "missing.toml") ==
          "did you mean 'missin.toml'?   in " + place + ": beam.toml, missin.toml");
    CHECK(hint(folder.path / "truss.toml") == "in " + place + ": beam.toml, missin.toml");
    for (int n = 0; n < 11; ++n) std::ofstream{folder.path / fmt::format("b{:02}.toml", n)};
    CHECK(hint(folder.path / "missing.toml") ==
          "did you mean 'missin.toml'?   in " + place +
              ": b00.toml, b01.toml, b02.toml, b03.toml, b04.toml, b05.toml, b06.toml, b07.toml, b08.toml, b09.toml "
              "and 3 more");
}

TEST_CASE("nearby: a name without its extension, a folder that is missing", "[scene]") {
    const TemporaryFolder folder;
    std::ofstream{folder.path / "beam.toml"};
    CHECK(hint(folder.path / "beam").starts_with("did you mean 'beam.toml'?"));
    CHECK(hint(folder.path / "no" / "beam.toml") == "there is no folder '" + (folder.path / "no").string() + "'");
}
