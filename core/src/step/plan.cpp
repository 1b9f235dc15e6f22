#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "step/stages.hpp"

namespace perimpm {

namespace {

template <class Real>
class Planner {
public:
    explicit Planner(World<Real>& w) : w_{w} {
        for (Material<Real>& m : w.materials) {
            (m.has_bonds() ? bond_laws_ : local_laws_).push_back(m.law_name);
            if (m.has_bonds()) (m.needs.stress ? stresses_ : forces_) = true;
            if (m.criterion) criteria_.push_back(m.criterion_name);
        }
    }

    Plan make() {
        plan_.dt = w_.dt, plan_.particles = w_.count;
        plan_.steps = std::ceil(w_.scene.simulation.end_time / w_.dt);
        plan_.libraries = own_libraries();
        if (w_.transfer_needs.grid)
            add_grid_passes();
        else
            add_particle_passes();
        if (!criteria_.empty()) pass("fracture", fracture_interval(), {"x", "bonds"}, {"broken bonds"}, criteria_);
        add_crack_passes();
        if (!w_.conditions.list.empty()) pass("conditions", kEachStep, {"x", "v"}, condition_writes());
        add_arrays();
        add_materials();
        add_bounds();
        add_skipped();
        return std::move(plan_);
    }

private:
    using Names = std::vector<std::string>;
    static constexpr const char* kEachStep = "each step";

    void pass(std::string name, std::string when, Names reads, Names writes, Names models = {}) {
        std::sort(models.begin(), models.end());
        models.erase(std::unique(models.begin(), models.end()), models.end());
        plan_.passes.push_back({std::move(name), std::move(when), std::move(reads), std::move(writes),
                                fmt::format("{}", fmt::join(models, ", "))});
    }
    /// The plugins and modules this scene opens, those of materials without bodies included (their parameters are checked);
    /// the process may hold others, of other scenes.
    Names own_libraries() const {
        Names names{"transfer/" + w_.scene.transfer.type};
        for (const MaterialSpec& m : w_.scene.materials) {
            names.push_back("constitutive/" + m.law.type);
            for (const ParamSpec& param : m.law.params->specs())
                if (const ModelSpec* inner = m.law.params->model(param.key))
                    names.push_back("constitutive/" + inner->type);
            if (m.criterion.params) names.push_back("fracture/" + m.criterion.type);
        }
        if (has_mesh()) names.push_back("module/mesh");
        if (writes_hdf5()) names.push_back("module/hdf5");
        std::sort(names.begin(), names.end());
        names.erase(std::unique(names.begin(), names.end()), names.end());
        return names;
    }
    bool has_mesh() const {
        const auto any = [](const auto& parts) {
            return std::any_of(parts.begin(), parts.end(), [](const auto& part) {
                const Value* shape = part.source.find("shape");
                return shape && std::get<std::string>(shape->find("type")->data) == "mesh";
            });
        };
        const Scene& s = w_.scene;
        return any(s.bodies) || any(s.colliders) || any(s.cracks) || any(s.conditions);
    }
    bool writes_hdf5() const {
        const Names& formats = w_.scene.output.formats;
        return std::find(formats.begin(), formats.end(), "hdf5") != formats.end();
    }
    Names laws() const {
        Names all = local_laws_;
        all.insert(all.end(), bond_laws_.begin(), bond_laws_.end());
        return all;
    }
    Names condition_writes() const {
        Names names{"v"};
        if (w_.conditions.holds()) names.push_back("x");
        if (w_.conditions.holds() && w_.transfer_needs.grid) names.push_back("grid");
        return names;
    }
    /// What the laws' wave speeds depend on.
    Names measured() const {
        Names names;
        if (!local_laws_.empty()) names.push_back("F");
        if (!bond_laws_.empty()) names.insert(names.end(), {"x", "bonds"});
        return names;
    }
    /// The shortest interval of the scene's criteria.
    std::string fracture_interval() const {
        std::uint32_t interval = std::numeric_limits<std::uint32_t>::max();
        for (const Material<Real>& m : w_.materials)
            if (m.criterion) interval = std::min(interval, m.criterion->interval());
        return interval == 1 ? kEachStep : fmt::format("every {} steps", interval);
    }
    void add_bond_pass() {
        if (!bond_laws_.empty()) pass("bond forces", kEachStep, {"x", "bonds"}, bond_results(), bond_laws_);
    }
    Names bond_results() const {
        Names names;
        if (forces_) names.push_back("force");
        if (stresses_) names.push_back("stress");
        return names;
    }
    void add_grid_passes() {
        const bool local = !local_laws_.empty(), affine = w_.transfer_needs.affine;
        const std::string when =
            w_.defers_gather ? "before a step that may sort, or when the state is looked at" : kEachStep;
        const Names transfer{w_.scene.transfer.type};
        pass("time step", fmt::format("every {} steps", kMeasureInterval), measured(), {"dt"}, laws());
        pass("sort",
             fmt::format("when particles moved {:g} cells{}", sort_margin(w_.transfer_needs.order),
                         parts_fragments(w_) ? ", or something parted" : ""),
             {"x"}, {"order"});
        add_bond_pass();
        Names reads{"x", "v", "mass"}, models = local_laws_;
        if (affine) reads.push_back("C");
        if (local) reads.insert(reads.end(), {"F", "volume"});
        for (const std::string& name : bond_results()) reads.push_back(name);
        models.push_back(w_.scene.transfer.type);
        pass("clear grid", kEachStep, {}, {"grid"});
        pass(local ? "stress and scatter" : "scatter", when, reads, {"grid"}, models);
        pass("grid update", kEachStep, {"grid"}, {"grid"});
        Names writes{"x", "v"};
        if (affine) writes.push_back("C");
        if (local) writes.push_back("F");
        pass("gather", when, {"grid", "x"}, writes, transfer);
        if (!w_.colliders.empty()) pass("particle collisions", when, {"x", "v"}, {"x", "v"});
        if (w_.defers_gather) add_joint_pass(models);
    }
    /// Gather, collisions and scatter in one; time steps are measured there, too.
    void add_joint_pass(const Names& models) {
        Names reads{"grid", "x", "F", "mass", "volume"}, writes{"x", "F", "grid"};
        if (w_.transfer_needs.own_velocity) reads.push_back("v"), writes.push_back("v");
        pass("gather, stress and scatter", "in all other steps", reads, writes, models);
    }
    /// Of materials whose cracks leave the grid.
    Names crack_laws() const {
        Names names;
        for (const Material<Real>& m : w_.materials)
            if (m.frees_crack_surfaces) names.push_back(m.law_name);
        return names;
    }
    void add_crack_passes() {
        if (parts_fragments(w_))
            pass("contact of velocity fields", "each step where fragments are near something", {"grid"}, {"grid"});
        if (crack_laws().empty()) return;
        const std::string when = w_.has_crack_surfaces ? kEachStep : "each step once bonds have broken";
        pass("contact of crack surfaces", when, {"x", "bonds"}, {"v"});
        pass("crack surfaces", when, {"v", "force", "mass"}, {"v", "x"}, crack_laws());
    }
    void add_particle_passes() {
        pass("kick and drift", kEachStep, {"v", "force", "mass"}, {"v", "x"}, {w_.scene.transfer.type});
        if (!w_.colliders.empty()) pass("particle collisions", kEachStep, {"x", "v"}, {"v"});
        add_bond_pass();
    }

    void array(std::string name, std::size_t bytes) {
        if (bytes > 0) plan_.arrays.push_back({std::move(name), bytes});
    }
    void add_arrays() {
        array("x", w_.x.bytes()), array("v", w_.v.bytes()), array("C", w_.C.bytes());
        array("mass", w_.mass.bytes()), array("volume", w_.volume.bytes()), array("id", w_.id.bytes());
        for (Material<Real>& m : w_.materials) {
            const auto own = [&](const std::string& name, std::size_t bytes) { array(m.name + "." + name, bytes); };
            own("F", m.F.bytes()), own("force", m.force.bytes()), own("stress", m.stress.bytes());
            own("positions by four", m.position.bytes() + m.reference.bytes());
            own("grid order", m.order.bytes());
            own("bonds.row", m.bonds.row.bytes()), own("bonds.neighbour", m.bonds.neighbour.bytes());
            own("bonds.shape", m.constants.shape.bytes());
            own("bonds.slices", m.constants.slices.bytes());
            own("bonds.rows", m.constants.rows.bytes());
            own("bonds.length", m.constants.length.bytes());
            own("bonds.broken", m.bonds.broken.bytes() + m.bonds.damage.bytes() + m.bonds.share.bytes());
            for (StateField<Real>& s : m.particle_state) own(s.spec.name, s.values.bytes());
            for (std::size_t k = 0; k < m.bond_state.size(); ++k)
                own(fmt::format("bonds.{}", m.needs.bond_state.data[k].name), m.bond_state[k].bytes());
            for (std::size_t k = 0; k < m.constants.declared.size(); ++k)
                own(fmt::format("bonds.{}", m.needs.bond_constants.data[k].name), m.constants.declared[k].bytes());
            for (auto& [spec, values] : m.varying) own(spec->key, values.bytes());
        }
        array("grid", w_.grid.bytes());
        array("sort", w_.sort.bytes());
        array("velocity fields", w_.fields.bytes());
        array("conditions", w_.conditions.bytes());
        std::size_t energies = 0;
        for (const Scratch<Real>& s : w_.scratch) energies += s.own_energy.bytes() + s.other_energy.bytes();
        array("energies of bonds", energies);
    }
    void add_materials() {
        for (Material<Real>& m : w_.materials) {
            const EffectiveModuli& moduli = m.needs.moduli;
            const double speed = reduce_chunks(
                w_, m, 0.0, [&](Block<Real>& b) { return m.lightness * m.law->max_wave_speed(b); },
                [](double a, double b) { return std::max(a, b); });
            plan_.materials.push_back({m.name, m.law_name, m.criterion_name, m.size, m.bonds.size(),
                                       moduli.youngs_modulus, moduli.poisson_ratio, speed});
        }
    }
    void add_bounds() {
        const std::string& type = w_.scene.transfer.type;
        if (!w_.transfer_needs.grid) {
            plan_.bounds.push_back(
                {fmt::format("{}: bonds of the laws, as far as they are stretched", type), time_step_bound(w_, 0)});
            return;
        }
        if (!crack_laws().empty())
            plan_.bounds.push_back(
                {"crack surfaces: bonds of the laws, as far as they are stretched", w_.bond_steps.at(w_.extension)});
        for (const Plan::Material& m : plan_.materials)
            plan_.bounds.push_back(
                {fmt::format("{} and {}: {:g} dx / (c + |v|), c = {:.4g} m/s, |v| = {:.4g} m/s", m.law, type,
                             w_.transfer_needs.courant, m.wave_speed, fastest_motion(w_)),
                 grid_bound(w_, m.wave_speed)});
    }
    void skip(std::string what, std::string why) { plan_.skipped.push_back({std::move(what), std::move(why)}); }
    void add_skipped() {
        const Scene& s = w_.scene;
        if (bond_laws_.empty()) skip("bond families and bond forces", "no law of this scene asks for bonds");
        if (local_laws_.empty()) skip("deformation gradient F and stress (no SVD)", "no law of this scene asks for F");
        if (criteria_.empty()) skip("fracture pass", "no material has a fracture criterion");
        if (!any_can_break(w_))
            skip("bond flags and fragments", "the scene has neither a fracture criterion nor cracks");
        if (crack_laws().empty() && any_can_break(w_))
            skip("crack surfaces and their contact", "no material with bonds that can break lets them leave the grid");
        if (!parts_fragments(w_) && any_can_break(w_))
            skip("velocity fields of fragments", "crack_surface = \"grid\", or no grid");
        if (s.colliders.empty()) skip("collider passes", "the scene has no colliders");
        if (w_.conditions.list.empty()) skip("conditions", "the scene has none");
        if (!w_.transfer_needs.grid)
            skip("grid, sort, scatter and gather",
                 fmt::format("transfer '{}' moves particles directly", s.transfer.type));
        else if (!w_.transfer_needs.affine)
            skip("affine velocity C", fmt::format("transfer '{}' does not use it", s.transfer.type));
        if (w_.transfer_needs.grid && !w_.transfer_needs.increment)
            skip("velocities before forces on the grid",
                 fmt::format("transfer '{}' does not use them", s.transfer.type));
        if (!has_mesh()) skip("mesh import and level sets (assimp, OpenVDB)", "no shape of this scene is a mesh");
    }

    World<Real>& w_;
    Names local_laws_, bond_laws_, criteria_;
    bool forces_ = false, stresses_ = false;  ///< whether bond laws write forces, or stresses
    Plan plan_;
};

}  // namespace

template <class Real>
Plan make_plan(World<Real>& w) {
    return Planner<Real>(w).make();
}

template Plan make_plan(World<float>&);
template Plan make_plan(World<double>&);

}  // namespace perimpm
