// PERIMPM_TEST_PLUGINS: folder with the plugins of tests/core/plugin/fixtures, by family.
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <thread>

#include "perimpm/plugin/registry.hpp"
#include "support/catch.hpp"
#include "support/environment.hpp"
#include "support/message.hpp"

using namespace perimpm;
namespace fs = std::filesystem;

namespace {

const fs::path kFixtures = PERIMPM_TEST_PLUGINS;

std::string read_bytes(const fs::path& file) {
    std::ifstream in{file, std::ios::binary};
    return {std::istreambuf_iterator<char>{in}, {}};
}

void write_bytes(const fs::path& file, const std::string& bytes) {
    fs::create_directories(file.parent_path());
    std::ofstream{file, std::ios::binary} << bytes;
}

void copy_fixture(const std::string& fixture, const fs::path& to) {
    fs::create_directories(to.parent_path());
    fs::copy_file(kFixtures / fixture, to);
}

/// sample_law with another ABI stamp.
void copy_with_stamp(const AbiStamp& stamp, const fs::path& to) {
    const AbiStamp ours = abi_stamp();
    std::string bytes = read_bytes(kFixtures / "constitutive/sample_law.so");
    const std::size_t at = bytes.find(std::string{reinterpret_cast<const char*>(&ours), sizeof ours});
    REQUIRE(at != std::string::npos);
    bytes.replace(at, sizeof stamp, reinterpret_cast<const char*>(&stamp), sizeof stamp);
    write_bytes(to, bytes);
}

std::string opening(const std::string& name, Family family = Family::constitutive) {
    return message_of([&] { open_plugin(family, name); });
}

bool is_listed(Family family, const std::string& name) {
    const auto plugins = installed(family);
    return std::any_of(plugins.begin(), plugins.end(), [&](const PluginFile& p) { return p.name == name; });
}

}  // namespace

TEST_CASE("registry: plugins are listed by file name, without opening them", "[plugin]") {
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", kFixtures};
    const auto before = opened_plugins();
    const auto laws = installed(Family::constitutive);
    CHECK(is_listed(Family::constitutive, "sample_law"));
    CHECK(is_listed(Family::constitutive, "no_stamp"));
    CHECK_FALSE(is_listed(Family::transfer, "sample_law"));
    CHECK(is_listed(Family::transfer, "sample_kernel"));
    CHECK(is_listed(Family::fracture, "sample_criterion"));
    CHECK(std::is_sorted(laws.begin(), laws.end(), [](const auto& a, const auto& b) { return a.name < b.name; }));
    CHECK(opened_plugins() == before);
}

TEST_CASE("registry: a model of either precision is created through its plugin", "[plugin]") {
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", kFixtures};
    const Plugin& plugin = open_plugin(Family::constitutive, "sample_law");
    CHECK(plugin.name == "sample_law");
    CHECK(fs::equivalent(plugin.path, kFixtures / "constitutive/sample_law.so"));
    CHECK(&open_plugin(Family::constitutive, "sample_law") == &plugin);
    CHECK(std::string{plugin.descriptor->summary} == "answers with its parameters");

    std::array<ParamValue, 6> values{};
    values[0].number = 3.0e5;
    values[1].number = 0.3;
    values[4].text = "linear";
    const Params params{plugin.descriptor->params, values.data(), plugin.descriptor->param_count, {}};
    const auto single = create<ConstitutiveLaw, float>("sample_law", params);
    const auto twice = create<ConstitutiveLaw, double>("sample_law", params);
    CHECK(single->needs().moduli.youngs_modulus == 3.0e5);
    CHECK(twice->needs().moduli.poisson_ratio == 0.3);
    CHECK(twice->max_wave_speed({}) == 1.0);
    CHECK(twice->stable_step({}).any_stretch == std::numeric_limits<double>::infinity());
    const auto opened = opened_plugins();
    CHECK(std::count(opened.begin(), opened.end(), "constitutive/sample_law") == 1);
    CHECK(std::is_sorted(opened.begin(), opened.end()));
}

TEST_CASE("registry: a criterion that does not decide cuts every candidate", "[plugin]") {
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", kFixtures};
    const Plugin& plugin = open_plugin(Family::fracture, "sample_criterion");
    const ParamValue values[] = {{.number = 7.0, .text = nullptr, .given = true},
                                 {.number = 1.0, .text = nullptr, .given = true}};
    const auto criterion =
        create<FractureCriterion, float>("sample_criterion", {plugin.descriptor->params, values, 2, {}});
    Block<float> block;
    block.size = 2;
    block.first = 10;
    std::array<BondCandidate, 2> room{};
    CandidateList found{room.data(), 0};
    criterion->screen(block, found);
    std::vector<BondCandidate> cuts;
    criterion->decide(block, {room.data(), found.size}, cuts);
    REQUIRE(cuts.size() == 2);
    CHECK(cuts[1].particle == 11);
    CHECK(cuts[1].bond == 7);
    CHECK(criterion->interval() == 1);
}

TEST_CASE("registry: what a constructor throws keeps its type across the border", "[plugin]") {
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", kFixtures};
    const Plugin& plugin = open_plugin(Family::constitutive, "throwing");
    const ParamValue value{};
    const Params params{plugin.descriptor->params, &value, 1, {}};
    std::string key;
    try {
        create<ConstitutiveLaw, float>("throwing", params);
    } catch (const InvalidParameter& e) {
        key = e.key();
    }
    CHECK(key == "youngs_modulus");
}

TEST_CASE("params: an undeclared key is a programming error, a text compares by value", "[plugin]") {
    const ParamSpec specs[] = {
        {.key = "a"}, {.key = "b", .kind = ParamKind::text}, {.key = "c", .kind = ParamKind::vector}};
    const ParamValue values[] = {
        {.number = 2.0, .given = true}, {.text = "yes"}, {.given = true, .vector = {1.0, 2.0, 3.0}}};
    const Params params{specs, values, 3, {.density = 5.0}};
    CHECK(params.vector("c")[2] == 3.0);
    CHECK(std::isnan(params.vector("a")[0]));
    CHECK(params["a"] == 2.0);
    CHECK(params.given("a"));
    CHECK_FALSE(params.given("b"));
    CHECK(params.is("b", "yes"));
    CHECK_FALSE(params.is("b", "no"));
    CHECK_FALSE(params.is("a", "yes"));
    CHECK(params.context().density == 5.0);
    CHECK_THROWS_AS(params["d"], std::logic_error);
}

TEST_CASE("registry: an unknown name gets the closest one", "[plugin]") {
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", kFixtures};
    const std::string message = opening("sample_lwa");
    CHECK(contains(message, "no constitutive plugin 'sample_lwa' is installed"));
    CHECK(contains(message, "did you mean 'sample_law'?"));
    CHECK(contains(opening("../constitutive/sample_law"), "is installed"));
    CHECK(contains(opening(""), "is installed"));
}

TEST_CASE("registry: a library without a stamp or with another one is refused before its descriptor is read",
          "[plugin]") {
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", kFixtures};
    CHECK(contains(opening("no_stamp"), "no_stamp.so: error: not a perimpm plugin: it has no ABI stamp"));
    const std::string message = opening("wrong_abi");
    CHECK(contains(message, "wrong_abi.so: error: built for another perimpm: interface version is " +
                                std::to_string(kInterfaceVersion + 1) + ", but this perimpm has " +
                                std::to_string(kInterfaceVersion)));
    CHECK(contains(message, "rebuild the plugin against this perimpm"));
    const auto opened = opened_plugins();
    CHECK(std::count(opened.begin(), opened.end(), "constitutive/wrong_abi") == 0);
}

TEST_CASE("registry: the message names the entry of the stamp that differs", "[plugin]") {
    struct Difference {
        const char* file;
        const char* message;
        void (*change)(AbiStamp&);
    };
    const Difference differences[] = {
        {"other_magic", "(magic)", [](AbiStamp& s) { s.magic[0] = 'q'; }},
        {"other_compiler", "compiler (major version) is", [](AbiStamp& s) { ++s.compiler; }},
        {"other_library", "standard library (ABI) is", [](AbiStamp& s) { ++s.standard_library; }},
        {"other_block", "layout (size) of Block<float> is", [](AbiStamp& s) { s.layout[0] += 8; }},
    };
    const TemporaryFolder folder;
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", folder.path};
    for (const Difference& difference : differences) {
        AbiStamp stamp = abi_stamp();
        difference.change(stamp);
        copy_with_stamp(stamp, folder.path / "constitutive" / (std::string{difference.file} + ".so"));
        CHECK(contains(opening(difference.file), difference.message));
    }
}

TEST_CASE("registry: the system's reason is passed on when a library does not load", "[plugin]") {
    const TemporaryFolder folder;
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", folder.path};
    write_bytes(folder.path / "constitutive/garbage.so", std::string(200, 'x'));
    CHECK(contains(opening("garbage"), "garbage.so: error: the library does not load: "));
    CHECK(contains(opening("garbage"), "invalid ELF header"));
}

TEST_CASE("registry: a family comes from the descriptor, not from the folder alone", "[plugin]") {
    const TemporaryFolder folder;
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", folder.path};
    copy_fixture("constitutive/sample_law.so", folder.path / "transfer/misplaced.so");
    CHECK(contains(opening("misplaced", Family::transfer),
                   "this is a constitutive plugin, but a transfer plugin is needed"));
}

TEST_CASE("registry: a file directly in a path folder is opened, but not listed", "[plugin]") {
    const TemporaryFolder folder;
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", folder.path};
    copy_fixture("constitutive/sample_law.so", folder.path / "flat_law.so");
    CHECK_FALSE(is_listed(Family::constitutive, "flat_law"));
    CHECK(contains(opening("flat_law", Family::fracture), "this is a constitutive plugin"));
    CHECK(open_plugin(Family::constitutive, "flat_law").path == folder.path / "flat_law.so");
}

TEST_CASE("registry: a name found twice is an error with both files", "[plugin]") {
    const TemporaryFolder first, second;
    copy_fixture("constitutive/sample_law.so", first.path / "constitutive/twin.so");
    SECTION("in two path folders") { copy_fixture("constitutive/sample_law.so", second.path / "constitutive/twin.so"); }
    SECTION("once without a family folder") { copy_fixture("constitutive/sample_law.so", second.path / "twin.so"); }
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", first.path.string() + ":" + second.path.string()};
    const std::string message = opening("twin");
    CHECK(contains(message, "two files claim to be the constitutive plugin 'twin'"));
    CHECK(contains(message, first.path / "constitutive/twin.so"));
    CHECK(contains(message, second.path));
}

TEST_CASE("registry: a folder named twice counts once, a missing one is an error", "[plugin]") {
    const std::string fixtures = kFixtures;
    {
        const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", fixtures + "::" + fixtures + "/"};
        CHECK(is_listed(Family::constitutive, "sample_law"));
    }
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", fixtures + ":/no/such/folder"};
    CHECK(contains(opening("sample_law2"), "PERIMPM_PLUGIN_PATH: error: the folder '/no/such/folder' does not exist"));
}

TEST_CASE("registry: PERIMPM_ISA chooses among the variants of a plugin", "[plugin]") {
    const TemporaryFolder folder;
    const EnvironmentVariable unset{"PERIMPM_ISA", std::nullopt};
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", folder.path};
    copy_fixture("constitutive/sample_law.so", folder.path / "constitutive/tuned.so");
    copy_fixture("constitutive/sample_law.so", folder.path / "constitutive/x86-64-v3/tuned.so");
    {
        const EnvironmentVariable isa{"PERIMPM_ISA", "x86-64-v5"};
        CHECK(contains(message_of([] { installed(Family::constitutive); }), "unknown instruction set 'x86-64-v5'"));
    }
#if defined(__x86_64__)
    const auto tuned = [] {
        for (const PluginFile& plugin : installed(Family::constitutive)) {
            if (plugin.name == "tuned") return plugin.path;
        }
        return std::string{"(not listed)"};
    };
    {
        const EnvironmentVariable isa{"PERIMPM_ISA", "x86-64-v2"};
        CHECK(tuned() == folder.path / "constitutive/tuned.so");
    }
    const bool has_v3 = __builtin_cpu_supports("x86-64-v3");
    CHECK(tuned() == folder.path / (has_v3 ? "constitutive/x86-64-v3/tuned.so" : "constitutive/tuned.so"));
    const EnvironmentVariable isa{"PERIMPM_ISA", "x86-64-v3"};
    if (has_v3) {
        CHECK(tuned() == folder.path / "constitutive/x86-64-v3/tuned.so");
    } else {
        CHECK(contains(message_of(tuned), "this machine does not support 'x86-64-v3'"));
    }
#endif
}

TEST_CASE("registry: threads that open the same plugin get the same one", "[plugin]") {
    const TemporaryFolder folder;
    const EnvironmentVariable path{"PERIMPM_PLUGIN_PATH", folder.path};
    copy_fixture("constitutive/sample_law.so", folder.path / "constitutive/shared_law.so");
    std::array<const Plugin*, 8> found{};
    std::vector<std::thread> threads;
    for (const Plugin*& slot : found) {
        threads.emplace_back([&slot] { slot = &open_plugin(Family::constitutive, "shared_law"); });
    }
    for (std::thread& thread : threads) thread.join();
    CHECK(std::count(found.begin(), found.end(), found[0]) == 8);
}

TEST_CASE("registry: a module that was not built is named with its file", "[plugin]") {
    const std::string message = message_of([] { open_module("teapot", "make_teapot"); });
    CHECK(message ==
          library_folder() + "/perimpm_teapot.so: error: this perimpm was built without its module 'teapot'");
}
