#include <algorithm>
#include <cmath>
#include <set>

#include "support/box_scene.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/scene.hpp"

using namespace perimpm;

namespace {

std::set<std::string> planned(const Simulation& simulation) {
    std::set<std::string> names;
    for (const Plan::Pass& pass : simulation.plan().passes) names.insert(pass.name);
    return names;
}

std::set<std::string> timed(const Simulation& simulation) {
    std::set<std::string> names;
    for (const PassTime& pass : simulation.pass_times()) names.insert(pass.name);
    return names;
}

bool names_library(const Overrides& overrides, const std::string& name) {
    const Simulation simulation(scene_from(kBox, overrides), 1);
    const auto& libraries = simulation.plan().libraries;
    return std::find(libraries.begin(), libraries.end(), name) != libraries.end();
}

/// A second material beside the first.
const Overrides kMixed = {
    R"(material.glass={ density = 1000, constitutive = { type = "pd_bond", youngs_modulus = 1e5 } })",
    R"(body=[{ material = "rubber", shape = { type = "sphere", center = [0, 0, 0], radius = 0.2 } },)"
    R"({ material = "glass", shape = { type = "sphere", center = [1, 0, 0], radius = 0.2 } }])"};

}  // namespace

TEST_CASE("plan: its passes are those that steps take", "[step]") {
    const Overrides scenes[] = {{},
                                {kBonds},
                                kMixed,
                                {kBonds, kNoGrid},
                                {kBonds, kNeverBreaks, kOnGrid},
                                {kBonds, kCrack},
                                {kFloor},
                                {kBonds, kNeverBreaks, kNoGrid, kFloor}};
    for (std::size_t k = 0; k < std::size(scenes); ++k) {
        CAPTURE(k);
        Simulation simulation(scene_from(kBox, scenes[k]), 1);
        for (int step = 0; step < 11; ++step) simulation.step();
        for (int step = 0; step < 11; ++step) simulation.step(1e300, Simulation::Next::step);
        simulation.written("x");
        simulation.step();
        CHECK(planned(simulation) == timed(simulation));
        CHECK(planned(simulation).size() == simulation.plan().passes.size());
    }
}

TEST_CASE("plan: the bounds are those the step is taken from, colliders included", "[step]") {
    for (const Overrides& overrides : {Overrides{}, Overrides{kRisingFloor}, Overrides{kBonds, kNoGrid}}) {
        const Simulation simulation(scene_from(kBox, overrides), 1);
        REQUIRE(simulation.plan().bounds.size() == 1);
        const double longest = 0.8 * simulation.plan().bounds[0].dt, frame = 1.0 / 24;  // of equal steps
        CHECK_THAT(simulation.plan().dt, WithinRel(frame / std::ceil(frame / longest), 1e-12));
    }
    const Simulation rising(scene_from(kBox, {kRisingFloor}), 1);
    CHECK(contains(rising.plan().bounds[0].source, "|v| = 5 m/s"));
}

TEST_CASE("plan: when a pass runs", "[step]") {
    const auto when = [](const Overrides& overrides, const std::string& name) -> std::string {
        const Simulation simulation(scene_from(kBox, overrides), 1);
        for (const Plan::Pass& pass : simulation.plan().passes)
            if (pass.name == name) return pass.when;
        return "never";
    };
    const std::string every_fourth =
        R"(material.rubber.fracture={ type = "critical_stretch", critical_stretch = 1, interval = 4 })";
    CHECK(when({}, "gather") == "before a step that may sort, or when the state is looked at");
    CHECK(when({}, "gather, stress and scatter") == "in all other steps");
    CHECK(when({kBonds}, "gather") == "each step");
    CHECK(when({}, "time step") == "every 10 steps");
    CHECK(when({}, "fracture") == "never");
    CHECK(when({kBonds, kNeverBreaks}, "fracture") == "each step");
    CHECK(when({kBonds, every_fourth}, "fracture") == "every 4 steps");
}

TEST_CASE("plan: it lists the modules that the scene opens", "[step]") {
    CHECK(names_library({}, "transfer/apic"));
    CHECK(names_library({}, "constitutive/fixed_corotated"));
    CHECK(names_library({kBonds, kNeverBreaks}, "fracture/critical_stretch"));
    CHECK_FALSE(names_library({}, "constitutive/pd_bond"));
    CHECK_FALSE(names_library({}, "module/mesh"));
    CHECK(names_library({R"(output={ formats = ["hdf5"] })"}, "module/hdf5"));
    CHECK_FALSE(names_library({"output={ formats = [] }"}, "module/hdf5"));
}

TEST_CASE("plan: arrays count their bytes", "[step]") {
    const Simulation simulation(scene_from(kBox), 1);
    const auto bytes = [&](const std::string& name) -> std::uint64_t {
        for (const Plan::Array& array : simulation.plan().arrays)
            if (array.name == name) return array.bytes;
        return 0;
    };
    CHECK(simulation.plan().particles == 512);
    CHECK(bytes("x") == 512 * 3 * 8);
    CHECK(bytes("rubber.F") == 512 * 9 * 8);
    CHECK(bytes("id") == 512 * 4);
    CHECK(bytes("rubber.bonds.row") == 0);
}

TEST_CASE("plan: a law inside a law opens its library, and stress stands for force", "[step]") {
    CHECK(names_library({kStresses}, "constitutive/fixed_corotated"));
    CHECK(names_library({kStresses}, "constitutive/pd_correspondence"));
    const Simulation simulation(scene_from(kBox, {kStresses}), 1);
    const auto holds = [&](const std::string& name) {
        const auto& arrays = simulation.plan().arrays;
        return std::any_of(arrays.begin(), arrays.end(), [&](const Plan::Array& a) { return a.name == name; });
    };
    CHECK(holds("rubber.stress"));
    CHECK_FALSE(holds("rubber.force"));
    CHECK(contains(message_of([] {
                       Simulation(scene_from(kBox, {kStresses, kNoGrid}), 1);
                   }),
                   "leaves its stress to a grid, which transfer 'particle' does not have"));
}
