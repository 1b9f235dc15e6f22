#include <cmath>
#include <cstring>

#include "perimpm/error.hpp"
#include "step/transfer.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/world.hpp"

using namespace perimpm;

namespace {

using Next = Simulation::Next;

const Overrides kThrown = {"simulation.gravity=[0, -10, 0]", "body.0.initial_velocity=[3, -1, 0.5]",
                           "body.0.initial_angular_velocity=[1, 5, 2]"};
const std::string kMls = R"(transfer={ type = "apic", stress_divergence = "mls" })";
const std::string kTwoLaws =
    R"(material.glass={ density = 2000, constitutive = { type = "neo_hookean", youngs_modulus = 1e5 } })";
const std::string kTwoBodies =
    R"(body=[{ material = "rubber", shape = { type = "sphere", center = [0, 0.3, 0], radius = 0.2 } },)"
    R"({ material = "glass", shape = { type = "sphere", center = [0.5, 0.3, 0], radius = 0.2 },)"
    R"(initial_velocity = [-2, 0, 0] }])";

const std::string kMetal =
    R"(material.rubber.constitutive={ type = "von_mises", youngs_modulus = 1e5, yield_stress = 1e3 })";
const std::string kBallAndBox =
    R"(collider=[{ shape = { type = "sphere", center = [0.2, -0.25, 0.2], radius = 0.2 }, velocity = [0, 1, 0] },)"
    R"({ shape = { type = "box", min = [0, -1, 0], max = [1, -0.1, 1] }, friction = 0.5 }])";

Overrides thrown(const Overrides& more) {
    Overrides all = kThrown;
    all.insert(all.end(), more.begin(), more.end());
    return all;
}

bool timed(const Simulation& simulation, const std::string& name) {
    for (const PassTime& pass : simulation.pass_times())
        if (pass.name == name) return true;
    return false;
}

/// Bytes of every field, in the order of their places.
std::vector<std::vector<char>> bytes(const Simulation& simulation) {
    std::vector<std::vector<char>> all;
    for (const std::string& name : simulation.fields()) {
        const FieldView v = simulation.field(name);
        const std::size_t width = v.type == NumberType::float64 ? 8 : 4;
        std::vector<char>& to = all.emplace_back();
        for (std::size_t c = 0; c < v.components; ++c)
            for (std::size_t i = 0; i < v.size; ++i) {
                const char* from = static_cast<const char*>(v.data) + width * (c * v.stride + i * v.entry);
                to.insert(to.end(), from, from + width);
            }
    }
    return all;
}

}  // namespace

TEST_CASE("gather and scatter: in one pass the bits are those of two", "[step]") {
    const Overrides scenes[] = {{},
                                {"simulation.precision=\"float\""},
                                {"body.0.particle_spacing=0.02"},  // more in a block than go together
                                {kFloor},
                                {kRisingFloor, "transfer.type=\"pic\""},
                                {kFloor, "transfer.type=\"flip\"", "transfer.order=3"},
                                {kMls, "transfer.order=3"},
                                {kTwoLaws, kTwoBodies, kFloor},
                                {kMetal, kBallAndBox},
                                {R"(grid.domain={ min = [-1, -1, -1], max = [1, 1, 1], faces = "periodic" })"},
                                {R"(grid.domain={ min = [-1, 0, -1], max = [1, 1, 1], faces = "symmetry" })"},
                                {R"(grid.domain={ min = [-1, 0, -1], max = [1, 1, 1], faces = "slip" })"}};
    for (std::size_t k = 0; k < std::size(scenes); ++k) {
        CAPTURE(k);
        Simulation watched(scene_from(kBox, thrown(scenes[k])), 2), unwatched(scene_from(kBox, thrown(scenes[k])), 2);
        for (int step = 0; step < 75; ++step) {
            CHECK(watched.step() == unwatched.step(1e300, Next::step));
            if (step % 17 == 16) unwatched.settle();
        }
        CHECK(watched.generation() > 2);
        CHECK(watched.generation() == unwatched.generation());
        CHECK(bytes(watched) == bytes(unwatched));
        CHECK(timed(unwatched, "gather, stress and scatter"));
        CHECK_FALSE(timed(watched, "gather, stress and scatter"));
    }
}

TEST_CASE("gather and scatter: whoever looks sees particles that have moved", "[step]") {
    Simulation a(scene_from(kBox, kThrown), 1), b(scene_from(kBox, kThrown), 1);
    for (int step = 0; step < 5; ++step) a.step(), b.step(1e300, Next::step);
    CHECK(a.ledger().kinetic == b.ledger().kinetic);
    a.step(), b.step(1e300, Next::step);
    const Frame frames[2] = {a.frame(1, {"x", "v", "F"}), b.frame(1, {"x", "v", "F"})};
    for (std::size_t k = 0; k < 3; ++k) CHECK(frames[0].fields[k].data == frames[1].fields[k].data);
    b.step(1e300, Next::step);
    b.written("v");  // of the state after the step
    a.step(), a.written("v");
    CHECK(a.step() == b.step());
    CHECK(bytes(a) == bytes(b));
}

TEST_CASE("gather and scatter: bond laws and conditions take their passes one by one", "[step]") {
    const std::string condition = "condition=[{ acceleration = [0, 1, 0] }]";
    for (const Overrides& overrides : {Overrides{kBonds}, Overrides{condition}}) {
        Simulation simulation(scene_from(kBox, overrides), 1);
        for (int step = 0; step < 5; ++step) simulation.step(1e300, Next::step);
        CHECK(timed(simulation, "gather"));
        CHECK_FALSE(timed(simulation, "gather, stress and scatter"));
    }
}

TEST_CASE("gather and scatter: no further than stencils stay in their tiles", "[step]") {
    const auto w = box_world();
    w->steps = 1, w->drift = 0.05;  // of 0.098 m
    for (const auto& [fastest, may] : {std::pair{47.0, true}, {48.1, false}, {double(INFINITY), false}}) {
        w->motion = {.step = 1, .dt = 1e-3, .fastest = fastest, .owed = true};
        CHECK(gather_can_wait(*w) == may);
    }
    const auto above = box_world({kRisingFloor});  // contact may change a velocity by as much again, and by 5 m/s
    above->steps = 1, above->drift = 0.05;
    for (const auto& [fastest, may] : {std::pair{21.0, true}, {22.0, false}}) {
        above->motion = {.step = 1, .dt = 1e-3, .fastest = fastest, .owed = true};
        CHECK(gather_can_wait(*above) == may);
    }
}

TEST_CASE("gather and scatter: a node that is not finite is noticed by the step that made it", "[step]") {
    Simulation simulation(scene_from(kBox, kThrown), 1);
    for (int step = 0; step < 4; ++step) simulation.step(1e300, Next::step);
    static_cast<double*>(simulation.field("F").data)[7] = std::nan("");
    const std::string message = message_of<SimulationError>([&] {
        for (int step = 0; step < 2; ++step) simulation.step(1e300, Next::step);
    });
    CHECK(contains(message, "no longer finite in step 5"));
}

TEST_CASE("gather and scatter: a law that refuses leaves the particles where two passes would", "[step]") {
    const std::string law = R"(material.rubber.constitutive={ type = "neo_hookean", youngs_modulus = 1e5 })";
    std::vector<std::vector<char>> left[2];
    std::string messages[2];
    for (const Next next : {Next::look, Next::step}) {
        const std::size_t k = next == Next::step;
        Simulation simulation(scene_from(kBox, thrown({law})), 2);
        for (int step = 0; step < 3; ++step) simulation.step();
        static_cast<double*>(simulation.field("F").data)[100] = -3;  // of F's first row: det F < 0 for some steps
        messages[k] = message_of<SimulationError>([&] {
            simulation.step(1e300, next);
            simulation.step(1e300, next);
        });
        left[k] = bytes(simulation);
    }
    CHECK(contains(messages[0], "neo_hookean"));
    CHECK(messages[0] == messages[1]);
    CHECK(left[0] == left[1]);
}

TEST_CASE("gather and scatter: the search for equilibrium starts from rest", "[step]") {
    Simulation settled(scene_from(kBox, kThrown), 1), waiting(scene_from(kBox, kThrown), 1);
    for (int step = 0; step < 3; ++step) settled.step(), waiting.step(1e300, Next::step);
    for (Simulation* simulation : {&settled, &waiting}) {
        int steps = 0;
        struct Enough {};
        CHECK_THROWS_AS(simulation->relax(1e-9, 100,
                                          [&] {
                                              if (++steps == 5) throw Enough{};
                                          }),
                        Enough);
    }
    CHECK(bytes(settled) == bytes(waiting));
}
