// PERIMPM_TEST_PLUGINS: folder with the plugins of tests/core/plugin/fixtures, by family.
#include "plugin/library.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"

using namespace perimpm;

namespace {

const std::string kLaw = std::string(PERIMPM_TEST_PLUGINS) + "/constitutive/sample_law.so";

std::string refusal(void (*change)(AbiStamp&)) {
    AbiStamp stamp = abi_stamp();
    change(stamp);
    return message_of([&] { check_stamp(stamp, "some.so"); });
}

}  // namespace

TEST_CASE("library: symbols are found or absent", "[plugin]") {
    const Library library = open_library(kLaw);
    const auto* stamp = static_cast<const AbiStamp*>(find_symbol(library, "perimpm_abi_stamp"));
    REQUIRE(stamp);
    CHECK(*stamp == abi_stamp());
    CHECK(find_symbol(library, "perimpm_teapot") == nullptr);
}

TEST_CASE("library: a file that does not load is named with the system's reason", "[plugin]") {
    CHECK(contains(message_of([] { open_library("/no/such/file.so"); }),
                   "/no/such/file.so: error: the library does not load: "));
}

TEST_CASE("library: the entry of the stamp that differs is named", "[plugin]") {
    CHECK(refusal([](AbiStamp&) {}) == "(no error)");
    CHECK(contains(refusal([](AbiStamp& s) { s.magic[0] = 'q'; }), "some.so: error: not a perimpm plugin"));
    CHECK(contains(refusal([](AbiStamp& s) { ++s.interface_version; }),
                   "interface version is " + std::to_string(kInterfaceVersion + 1)));
    CHECK(contains(refusal([](AbiStamp& s) { ++s.compiler; }), "compiler (major version) is"));
    CHECK(contains(refusal([](AbiStamp& s) { ++s.standard_library; }), "standard library (ABI) is"));
    const std::string oldest = refusal([](AbiStamp& s) { ++s.layout[0], ++s.compiler, ++s.interface_version; });
    CHECK(contains(oldest, "interface version"));
}

TEST_CASE("library: every struct that crosses has its own entry in the stamp", "[plugin]") {
    for (std::size_t i = 0; i < std::size(kCrossingStructs); ++i) {
        AbiStamp stamp = abi_stamp();
        CHECK(stamp.layout[i] == kCrossingStructs[i].size);
        stamp.layout[i] += 8;
        const std::string message = message_of([&] { check_stamp(stamp, "some.so"); });
        CHECK(contains(message, "layout (size) of " + std::string(kCrossingStructs[i].name) + " is "));
    }
    const auto has = [](const std::string& name) {
        for (const CrossingStruct& s : kCrossingStructs)
            if (s.name == name) return true;
        return false;
    };
    for (const char* name : {"Block<float>", "TransferBlock<double>", "LawNeeds", "TransferNeeds", "ModelContext",
                             "Params", "ParamSpec", "FieldSpec", "BondCandidate", "CandidateList", "PluginDescriptor"})
        CHECK(has(name));
}
