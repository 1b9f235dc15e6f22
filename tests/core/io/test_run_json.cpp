#include <nlohmann/json.hpp>

#include "io/record.hpp"
#include "support/box_scene.hpp"
#include "support/catch.hpp"
#include "support/scene.hpp"

using namespace perimpm;

TEST_CASE("run.json: the resolved scene, sizes, libraries and the time of every pass", "[io]") {
    Simulation simulation(scene_from(kBox, {kBonds, "title=\"cube\""}), 1);
    for (int n = 0; n < 3; ++n) simulation.step();
    const auto head = run_head(simulation, {.folder = "", .threads = 1, .after_step = {}});
    const auto json = nlohmann::json::parse(run_json(head, simulation, 7, "running", ""));
    CHECK(json["status"] == "running");
    CHECK(json["frames"] == 7);
    CHECK(json["steps"] == 3);
    CHECK(json["time"] == simulation.time());
    CHECK(json["particles"] == 512);
    CHECK(json["precision"] == "double");
    CHECK(json["threads"] == 1);
    CHECK(json["scene"]["title"] == "cube");
    CHECK(json["scene"]["material"]["rubber"]["constitutive"]["type"] == "pd_bond");
    CHECK(json["materials"][0]["constitutive"] == "pd_bond");
    CHECK(json["materials"][0]["bonds"] == simulation.plan().materials[0].bonds);
    CHECK(json["fields"] == simulation.scene().output.fields);
    CHECK(json["available_fields"] == simulation.frame_fields());
    CHECK(json["libraries"] == simulation.plan().libraries);
    CHECK_FALSE(json.contains("error"));
    const auto passes = simulation.pass_times();
    REQUIRE(json["passes"].size() == passes.size());
    for (std::size_t k = 0; k < passes.size(); ++k) {
        CHECK(json["passes"][k]["name"] == passes[k].name);
        CHECK_THAT(json["passes"][k]["ns_per_particle_step"].get<double>(),
                   WithinRel(1e9 * passes[k].seconds / (512 * 3), 1e-12));
    }
}

TEST_CASE("run.json: numbers that do not exist are null, errors are told", "[io]") {
    const Simulation simulation(scene_from(kBox), 1);
    const auto json = nlohmann::json::parse(run_json(run_head(simulation, {}), simulation, 1, "failed", "broke"));
    CHECK(json["error"] == "broke");
    CHECK(json["passes"].empty());
    CHECK(json["threads"].get<int>() >= 1);  // 0 asked for every core
}
