#include "plugin/instruction_set.hpp"
#include "support/catch.hpp"
#include "support/environment.hpp"
#include "support/message.hpp"

using namespace perimpm;

TEST_CASE("instruction set: the baseline comes last, everywhere", "[plugin]") {
    REQUIRE_FALSE(instruction_set_folders().empty());
    CHECK(instruction_set_folders().back().empty());
}

TEST_CASE("instruction set: an unknown one is refused", "[plugin]") {
    const EnvironmentVariable isa{"PERIMPM_ISA", "avx2"};
    CHECK(contains(message_of([] { instruction_set_folders(); }), "PERIMPM_ISA: unknown instruction set 'avx2'"));
}

#if defined(__x86_64__)
TEST_CASE("instruction set: names are those of the psABI levels, the baseline's as well", "[plugin]") {
    CHECK(baseline_name() == "x86-64-v2");
    const EnvironmentVariable isa{"PERIMPM_ISA", "x86-64"};
    CHECK(contains(message_of([] { instruction_set_folders(); }), "unknown instruction set 'x86-64'"));
}

TEST_CASE("instruction set: PERIMPM_ISA caps the list", "[plugin]") {
    const EnvironmentVariable unset{"PERIMPM_ISA", std::nullopt};
    const std::vector<std::string> best = instruction_set_folders();
    for (std::size_t first = 0; first < best.size(); ++first) {
        const EnvironmentVariable isa{"PERIMPM_ISA", best[first].empty() ? baseline_name() : best[first]};
        CHECK(instruction_set_folders() ==
              std::vector<std::string>(best.begin() + static_cast<long>(first), best.end()));
    }
    if (best.front() == "x86-64-v4") return;
    const EnvironmentVariable isa{"PERIMPM_ISA", "x86-64-v4"};
    CHECK(contains(message_of([] { instruction_set_folders(); }), "this machine does not support 'x86-64-v4'"));
}
#endif
