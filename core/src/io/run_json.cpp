#include <tbb/info.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "io/versions.hpp"
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

/// Of the bodies whose points are drawn at random.
Json seeds_json(const Scene& scene) {
    Json seeds = Json::object();
    for (const BodySpec& body : scene.bodies)
        if (body.poisson || body.jitter > 0) seeds[body.name] = body.seed;
    return seeds;
}

Json versions_json(const Simulation& simulation, const RunOptions& options) {
    std::vector<std::string> modules;
    const auto& libraries = simulation.plan().libraries;
    if (std::ranges::count(simulation.scene().output.formats, "hdf5") > 0) modules.emplace_back("hdf5");
    if (std::ranges::count(libraries, "module/mesh") > 0) modules.emplace_back("mesh");
    Json list = Json::object();
    for (const auto& [name, version] : versions(modules)) list[name] = version;
    for (const auto& [name, version] : options.versions) list[name] = version;
    return list;
}

}  // namespace

Json run_head(const Simulation& simulation, const RunOptions& options) {
    const Scene& scene = simulation.scene();
    return {{"frame_rate", scene.simulation.frame_rate},
            {"particles", simulation.particle_count()},
            {"precision", scene.simulation.precision == Precision::double_ ? "double" : "float"},
            {"threads", options.threads > 0 ? options.threads : tbb::info::default_concurrency()},
            {"seeds", seeds_json(scene)},
            {"fields", scene.output.fields},
            {"available_fields", simulation.frame_fields()},
            {"materials", materials_json(simulation.plan())},
            {"libraries", simulation.plan().libraries},
            {"versions", versions_json(simulation, options)},
            {"scene", Json::parse(resolved_scene(scene).to_json())}};
}

std::string run_json(const Json& head, const Simulation& simulation, std::uint32_t last_frame,
                     const std::string& status, const std::string& error) {
    Json json = {{"perimpm", head["versions"]["perimpm"]},
                 {"status", status},
                 {"frames", last_frame},
                 {"time", simulation.time()},
                 {"steps", simulation.steps()}};
    if (!error.empty()) json["error"] = error;
    json.update(head);
    json["passes"] = passes_json(simulation);
    return json.dump(2) + "\n";
}

}  // namespace perimpm
