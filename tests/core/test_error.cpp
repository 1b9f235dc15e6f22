#include "perimpm/error.hpp"
#include "support/catch.hpp"

using namespace perimpm;

TEST_CASE("error: InputError puts the place before the message", "[error]") {
    CHECK(std::string{InputError{"bar.toml:8:52", "unknown key"}.what()} == "bar.toml:8:52: error: unknown key");
    CHECK(std::string{InputError{"", "unknown key"}.what()} == "unknown key");
    CHECK(std::string{InputError{"unknown key"}.what()} == "unknown key");
}

TEST_CASE("error: InvalidParameter keeps the key apart", "[error]") {
    const InvalidParameter e{"horizon", "must be above 1"};
    CHECK(e.key() == "horizon");
    CHECK(std::string{e.what()} == "must be above 1");
}

TEST_CASE("error: nearest allows a third of the length, at least one edit", "[error]") {
    const std::vector<std::string> words = {"pic", "flip", "apic", "horizon", "youngs_modulus"};
    CHECK(nearest("horizn", words) == "horizon");               // one insertion, 6/3 = 2 allowed
    CHECK(nearest("hroiozn", words) == "horizon");              // two swaps of neighbours, 7/3 = 2 allowed
    CHECK(nearest("young_modlus", words) == "youngs_modulus");  // two insertions, 12/3 = 4 allowed
    CHECK(nearest("pci", words) == "pic");                      // a swap counts once; 3/3 = 1 allowed
    CHECK(nearest("q", words) == "");                           // 1 allowed, 3 needed
    CHECK(nearest("hrzn", words) == "");                        // 4/3 = 1 allowed, 3 needed
    CHECK(nearest("apic", words) == "apic");
    CHECK(nearest("", words) == "");
    CHECK(nearest("anything", {}) == "");
}

TEST_CASE("error: nearest takes the first of equally near words", "[error]") {
    CHECK(nearest("bat", {"cat", "hat"}) == "cat");
    CHECK(nearest("bat", {"cat", "bar", "bat"}) == "bat");
}

TEST_CASE("error: suggestion asks only when something is near", "[error]") {
    CHECK(suggestion("apci", {"pic", "apic"}) == "did you mean 'apic'?   accepted: pic, apic");
    CHECK(suggestion("zzz", {"pic", "apic"}) == "accepted: pic, apic");
    CHECK(suggestion("zzz", {}) == "accepted: nothing");
    CHECK(suggestion("radios", {"radius"}, {"radius [m]"}) == "did you mean 'radius'?   accepted: radius [m]");
}
