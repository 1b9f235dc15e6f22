#include <fmt/format.h>

#include <algorithm>

#include "support/box_scene.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/scene.hpp"

using namespace perimpm;

TEST_CASE("simulation: steps add up to its time", "[step]") {
    Simulation simulation(scene_from(kBox), 1);
    CHECK(simulation.time() == 0);
    const double first = simulation.step(), second = simulation.step(1e-6);
    CHECK(first > 1e-4);
    CHECK(second == 1e-6);
    CHECK(simulation.time() == first + second);
    CHECK(simulation.steps() == 2);
    CHECK(simulation.particle_count() == 512);
}

TEST_CASE("simulation: either precision is what the fields hold", "[step]") {
    CHECK(Simulation(scene_from(kBox), 1).field("x").type == NumberType::float64);
    CHECK(Simulation(scene_from(kBox, {R"(simulation.precision="float")"}), 1).field("x").type == NumberType::float32);
}

TEST_CASE("simulation: a free cube falls by gravity alone, with and without a grid", "[step]") {
    for (const Overrides& kind : {Overrides{}, Overrides{kBonds}, Overrides{kBonds, kNoGrid}}) {
        Overrides overrides = kind;
        overrides.push_back("simulation.gravity=[0, -10, 0]");
        Simulation simulation(scene_from(kBox, overrides), 2);
        for (int n = 0; n < 20; ++n) simulation.step();
        CHECK_THAT(simulation.ledger().momentum[1], WithinRel(-10 * 64 * simulation.time(), 1e-9));
    }
}

TEST_CASE("simulation: unknown fields get the closest name", "[step]") {
    const Simulation simulation(scene_from(kBox), 1);
    CHECK(contains(message_of([&] { simulation.field("vol"); }), "no field 'vol'"));
    CHECK(contains(message_of([&] { simulation.field("volum"); }), "did you mean 'volume'?"));
    CHECK(contains(message_of([&] { simulation.field("x", "rubbr"); }), "did you mean 'rubber'?"));
}

TEST_CASE("simulation: positions written from outside are sorted before the next step", "[step]") {
    Simulation simulation(scene_from(kBox), 1);
    const std::uint64_t generation = simulation.generation();
    simulation.step();
    CHECK(simulation.generation() == generation);
    simulation.written("x");
    simulation.step();
    CHECK(simulation.generation() == generation + 1);
}

TEST_CASE("simulation: an output field that does not exist is refused at the start", "[step]") {
    CHECK(contains(message_of([] { Simulation(scene_from(kBox, {R"(output={ fields = ["x", "stress"] })"}), 1); }),
                   "no field 'stress' in this scene"));
    const std::string text = std::string(kBox) + "\n[output]\nfields = [\n  \"x\",\n  \"stress\"]\n";
    const auto line = std::count(text.begin(), text.end(), '\n');
    CHECK(contains(message_of([&] { Simulation(read_scene(parse_scene_text(text, "box.toml"), "."), 1); }),
                   fmt::format("box.toml:{}:3: error: output.fields", line)));
}
