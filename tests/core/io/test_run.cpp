#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "perimpm/error.hpp"
#include "perimpm/io/run.hpp"
#include "support/box_scene.hpp"
#include "support/catch.hpp"
#include "support/environment.hpp"
#include "support/files.hpp"
#include "support/message.hpp"
#include "support/scene.hpp"

using namespace perimpm;

namespace {

/// 0.1 s at 50 frames per second: frames 1 to 6.
const Overrides kShort = {"simulation.end_time=0.1", "simulation.frame_rate=50", R"(output={ formats = ["hdf5"] })"};

Simulation start() { return Simulation(scene_from(kBox, kShort), 1); }

}  // namespace

TEST_CASE("run: one frame every interval, each reached exactly", "[io]") {
    const TemporaryFolder folder;
    Simulation simulation = start();
    std::uint32_t seen = 0;
    const bool finished = run(simulation, {.folder = folder.path, .after_step = [&](const Progress& p) {
                                               if (p.frame > seen)
                                                   CHECK_THAT(p.time, WithinAbs((p.frame - 1) / 50.0, 1e-10));
                                               seen = p.frame;
                                               CHECK(p.frames == 6);
                                               CHECK(p.end_time == Approx(0.1));
                                               return true;
                                           }});
    CHECK(finished);
    CHECK(seen == 6);
    CHECK(files_in(folder.path).count("frame.0006.h5") == 1);
    CHECK(files_in(folder.path).count("frame.0007.h5") == 0);
    CHECK_THAT(simulation.time(), WithinRel(0.1, 1e-9));
}

TEST_CASE("run: steps to the next frame are equal", "[io]") {
    Simulation simulation = start();
    double before = 0, shortest = 1, longest = 0;
    run(simulation, {.folder = "", .frames = 2, .after_step = [&](const Progress& p) {
                         if (p.time > before) {
                             shortest = std::min(shortest, p.time - before);
                             longest = std::max(longest, p.time - before);
                         }
                         before = p.time;
                         return true;
                     }});
    CHECK_THAT(shortest, WithinRel(longest, 1e-6));
    CHECK_THAT(simulation.time(), WithinRel(0.02, 1e-9));
}

TEST_CASE("run: steps follow the bound, down and up", "[io]") {
    const auto [start, pull] = GENERATE(std::pair{"0", "-400"}, std::pair{"-40", "400"});  // c = 11 m/s
    Overrides moving = kShort;
    moving.insert(moving.end(), {fmt::format("simulation.gravity=[0, {}, 0]", pull), "simulation.frame_rate=10",
                                 fmt::format("body.0.initial_velocity=[0, {}, 0]", start)});
    Simulation stepped(scene_from(kBox, moving), 1), framed(scene_from(kBox, moving), 1);
    while (stepped.time() < 0.1) stepped.step();
    run(framed, {.folder = "", .frames = 2, .after_step = {}});
    CHECK_THAT(framed.time(), WithinRel(0.1, 1e-9));
    CHECK(stepped.steps() > 20);
    CHECK(framed.steps() >= stepped.steps());
    CHECK(framed.steps() <= stepped.steps() + 2);
}

TEST_CASE("run: it can be stopped after any step and goes on from there", "[io]") {
    const TemporaryFolder folder;
    Simulation simulation = start();
    CHECK_FALSE(run(simulation, {.folder = folder.path, .after_step = [](const Progress& p) { return p.frame < 3; }}));
    CHECK(contains(text_of(folder.path / "run.json"), R"("status": "stopped")"));
    CHECK(files_in(folder.path).count("frame.0003.h5") == 1);
    CHECK(files_in(folder.path).count("frame.0004.h5") == 0);
    CHECK(run(simulation, {.folder = folder.path, .after_step = {}}));
    CHECK(contains(text_of(folder.path / "run.json"), R"("status": "done")"));
    CHECK(files_in(folder.path).count("frame.0001.h5") == 1);
    CHECK(files_in(folder.path).count("frame.0006.h5") == 1);
}

TEST_CASE("run: a failure leaves the state beside the frames and is passed on", "[io]") {
    const TemporaryFolder folder;
    Simulation simulation = start();
    entry(simulation.field("v"), 0) = std::nan("");
    const std::string message =
        message_of<SimulationError>([&] { run(simulation, {.folder = folder.path, .after_step = {}}); });
    CHECK(contains(message, "no longer finite"));
    CHECK(files_in(folder.path).count("failed.h5") == 1);
    CHECK(contains(text_of(folder.path / "run.json"), R"("status": "failed")"));
}

TEST_CASE("run: a step that does not advance the time is a failure", "[io]") {
    Simulation simulation = start();
    run(simulation, {.folder = "", .frames = 2, .after_step = {}});
    entry(simulation.field("v"), 0) = 1e30;  // apic's step is then below 1e-31 s, and 0.02 + 1e-31 = 0.02
    simulation.written("v");
    const std::string message =
        message_of<SimulationError>([&] { run(simulation, {.folder = "", .frames = 3, .after_step = {}}); });
    CHECK(contains(message, "the time stands still at 0.02 s"));
}
