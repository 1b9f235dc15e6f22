#include <tbb/info.h>

#include <nlohmann/json.hpp>

#include "record.hpp"

namespace perimpm {
namespace {

using Json = nlohmann::ordered_json;

Json materials_json(const Plan& plan) {
    Json list = Json::array();
    for (const Plan::Material& m : plan.materials)
        list.push_back({{"name", m.name},
                        {"constitutive", m.law},
                        {"fracture", m.criterion},
                        {"particles", m.particles},
                        {"bonds", m.bonds},
                        {"youngs_modulus_pa", m.youngs_modulus},
                        {"poisson_ratio", m.poisson_ratio}});
    return list;
}

/// ns per particle-step, and per directed bond and step where there are bonds.
Json passes_json(const Simulation& simulation) {
    std::uint64_t bonds = 0;
    for (const Plan::Material& m : simulation.plan().materials) bonds += m.bonds;
    const double steps = static_cast<double>(simulation.steps());
    const auto nanoseconds = [steps](double seconds, std::uint64_t items) {
        return items > 0 && steps > 0 ? Json(1e9 * seconds / (static_cast<double>(items) * steps)) : Json();
    };
    Json list = Json::array();
    for (const PassTime& pass : simulation.pass_times())
        list.push_back({{"name", pass.name},
                        {"calls", pass.calls},
                        {"seconds", pass.seconds},
                        {"ns_per_particle_step", nanoseconds(pass.seconds, simulation.particle_count())},
                        {"ns_per_bond_step", nanoseconds(pass.seconds, bonds)}});
    return list;
}

}  // namespace

std::string run_json(const Simulation& simulation, const RunOptions& options, std::uint32_t last_frame,
                     const std::string& status, const std::string& error) {
    const Scene& scene = simulation.scene();
    Json json = {{"perimpm", PERIMPM_VERSION},
                 {"status", status},
                 {"frames", last_frame},
                 {"frame_rate", scene.simulation.frame_rate},
                 {"time", simulation.time()},
                 {"steps", simulation.steps()},
                 {"particles", simulation.particle_count()},
                 {"precision", scene.simulation.precision == Precision::double_ ? "double" : "float"},
                 {"threads", options.threads > 0 ? options.threads : tbb::info::default_concurrency()},
                 {"materials", materials_json(simulation.plan())},
                 {"passes", passes_json(simulation)},
                 {"libraries", simulation.plan().libraries},
                 {"scene", Json::parse(scene.source.to_json())}};
    if (!error.empty()) json["error"] = error;
    return json.dump(2) + "\n";
}

}  // namespace perimpm
