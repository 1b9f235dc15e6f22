// PERIMPM_SOURCE: folder of this repository. The guide for plugin authors quotes code that is built and checked.
#include <filesystem>
#include <fstream>
#include <iterator>

#include "support/catch.hpp"
#include "support/message.hpp"

namespace {

namespace fs = std::filesystem;
const fs::path kRoot = PERIMPM_SOURCE;

std::string text_of(const fs::path& file) {
    std::ifstream in{file};
    REQUIRE(in);
    return {std::istreambuf_iterator<char>{in}, {}};
}

/// Contents of the fenced blocks of a language.
std::vector<std::string> blocks_of(const std::string& guide, const std::string& language) {
    std::vector<std::string> blocks;
    const std::string fence = "\n```" + language + "\n";
    for (std::size_t at = guide.find(fence); at != std::string::npos; at = guide.find(fence, at)) {
        at += fence.size();
        blocks.push_back(guide.substr(at, guide.find("```", at) - at));
    }
    return blocks;
}

}  // namespace

TEST_CASE("plugin guide: the quoted code is the compiled file's", "[contract]") {
    const std::string guide = text_of(kRoot / "plugins/README.md");
    const fs::path project = kRoot / "tests/out_of_tree";
    for (const auto& [language, file] : {std::pair{"cpp", "saint_venant_kirchhoff.cpp"},
                                         {"cmake", "CMakeLists.txt"},
                                         {"python", "python/constitutive/saint_venant_kirchhoff.py"}}) {
        const auto blocks = blocks_of(guide, language);
        REQUIRE_FALSE(blocks.empty());
        for (const std::string& block : blocks) {
            CAPTURE(block);
            CHECK(contains(text_of(project / file), block));
        }
    }
}

TEST_CASE("plugin guide: its links lead somewhere", "[contract]") {
    const std::string guide = text_of(kRoot / "plugins/README.md");
    for (std::size_t at = guide.find("]("); at != std::string::npos; at = guide.find("](", at + 1)) {
        const std::string link = guide.substr(at + 2, guide.find(')', at) - at - 2);
        CAPTURE(link);
        if (!link.starts_with("#")) CHECK(fs::exists(kRoot / "plugins" / link));
    }
}
