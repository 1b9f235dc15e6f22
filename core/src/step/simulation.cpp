#include "perimpm/step/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <variant>

#include "perimpm/error.hpp"
#include "step/transfer.hpp"

namespace perimpm {

namespace {

/// A world, and what moves it on.
template <class Real>
class Stepper {
public:
    World<Real> world;
    Plan plan;

    Stepper(Scene scene, int threads) : world{std::move(scene), threads} {
        build_world(world);
        renew_plan();
        make_frame(world, 1, world.scene.output.fields);  // refuses output fields that this scene does not have
    }

    void renew_plan() {
        plan = make_plan(world);
        plan.warnings = starting_overlaps(world);
        for (std::uint32_t m = 0; m < world.scene.materials.size(); ++m)
            if (std::ranges::count(world.scene.bodies, m, &BodySpec::material) == 0)
                plan.warnings.push_back(fmt::format("no body is of material '{}'", world.scene.materials[m].name));
        if (world.transfer_needs.grid)
            for (std::string& text : inexact_faces(world.scene.grid, world.images))
                plan.warnings.push_back(std::move(text));
        if (world.transfer_needs.order == 1)
            plan.warnings.emplace_back(
                "transfer.order = 1 has no stable step at free surfaces: a smaller dt only delays the end of a run, "
                "and dt = \"auto\" holds for filled cells\n  use order 2 or 3");
    }

    void add_condition(const ConditionSpec& spec, ConditionFunction function) {
        if (world.steps > 0)
            throw InputError("conditions choose their particles at the start: add them before the first step");
        perimpm::add_condition(world, spec, std::move(function));
        renew_plan();
    }
    Relaxation relax(double residual, std::uint64_t most_steps, const std::function<void()>& after_step) {
        settle();
        return perimpm::relax(world, residual, most_steps, [&] {
            const double time = world.time;
            step(1e300, true);
            world.time = time;
            if (after_step) after_step();
        });
    }

    /// `look`: somebody sees the particles before the next step.
    double step(double whole, bool look) {
        return explain([&] { return advance(whole, look); });
    }
    void settle() {
        explain([&] { finish_step(); });
    }

    void note_written(const std::string& field) {
        written_.x |= field == "x", written_.v |= field == "v", written_.F |= field == "F";
        written_.weights |= field == "mass" || field == "volume";
    }

private:
    struct Written {
        bool x = false, v = false, weights = false, F = false;
    };
    /// Failures of a run whose step was above the stable one say so.
    template <class Action>
    auto explain(const Action& action) {
        try {
            return action();
        } catch (const SimulationError& e) {
            const UnstableStep& u = world.unstable;
            if (u.step == 0) throw;
            throw SimulationError(
                fmt::format("{}\n  dt is above the stable step: {:g} s, where {:g} s was stable, in step {}; "
                            "simulation.allow_unstable_dt let it pass",
                            e.what(), u.dt, u.bound, u.step));
        }
    }

    /// One step of the method; the numbers are those of the paper's list (section 3).
    double advance(double whole, bool look) {
        if (!gather_can_wait(world)) finish_step();
        accept_written();
        world.dt = choose_time_step(world, whole);
        if (world.transfer_needs.grid)
            grid_step(look);
        else
            integrate_particles(world);
        world.time += world.dt;
        ++world.steps;
        return world.dt;
    }

    void accept_written() {
        const Written now = std::exchange(written_, {});
        if (now.x) accept_positions(world);
        if (now.v) accept_velocities(world);
        if (now.weights) accept_weights(world);
        if (now.F) accept_deformations(world);
    }

    void finish_step() {
        if (!std::exchange(world.motion.owed, false)) return;
        world.timer("gather", [&] { gather(world); });  // 5
        if (!world.defers_gather) world.max_speed = world.gathered_speed;
        if (world.has_crack_surfaces) world.timer("crack surfaces", [&] { move_crack_surfaces(world); });
        if (!world.colliders.empty()) world.timer("particle collisions", [&] { collide_particles(world); });  // 6
        if (world.conditions.holds()) world.timer("conditions", [&] { move_held_particles(world); });
    }

    void grid_step(bool look) {
        if (std::exchange(world.motion.owed, false)) {
            gather_and_scatter(world);  // 5, 6 of the last step; 1, 2
        } else {
            prepare_scatter();
            scatter(world);  // 1, 2
        }
        if (world.defers_gather) world.max_speed = world.gathered_speed;
        const auto fold = [&] {
            if (world.images.any()) fold_images(world);
        };
        const bool fields_meet = !world.grid.shared().empty();
        if (fields_meet) world.timer("contact of velocity fields", [&] { fold(), resolve_field_contact(world); });
        world.timer("grid update", [&] {  // 3, 4
            const bool held = world.conditions.holds();
            if (!fields_meet) fold();
            update_grid(world);
            if (held) hold_nodes(world);
            if (world.images.any()) unfold_images(world);
        });
        if (look || !world.defers_gather) finish_step();  // 5, 6
    }

    void prepare_scatter() {
        const bool parted = world.fields.is_stale && has_own_fields(world) && find_owners(world);
        if (parted || world.drift > sort_margin(world.transfer_needs.order) * world.spacing())
            world.timer("sort", [&] { sort_particles(world); });
        compute_bond_forces(world);  // 7 of the last step
        if (world.has_crack_surfaces) world.timer("contact of crack surfaces", [&] { apply_contact(world); });
        const bool conditions = !world.conditions.list.empty(), held = world.conditions.holds();
        if (conditions)
            world.timer("conditions", [&] {
                apply_loads(world, world.time, world.dt);
                prescribe_velocities(world, world.time + world.dt / 2);
                if (held) scatter_held(world);
            });
    }

    Written written_;
};

}  // namespace

/// Either precision.
class Simulation::Engine {
public:
    Engine(Scene scene, int threads) {
        if (scene.simulation.precision == Precision::double_)
            stepper_ = std::make_unique<Stepper<double>>(std::move(scene), threads);
        else
            stepper_ = std::make_unique<Stepper<float>>(std::move(scene), threads);
    }
    /// ask(stepper)
    template <class Ask>
    decltype(auto) operator()(const Ask& ask) {
        return std::visit([&](auto& stepper) -> decltype(auto) { return ask(*stepper); }, stepper_);
    }
    /// ask(world), of particles that have moved as far as they should.
    template <class Ask>
    auto settled(const Ask& ask) {
        return (*this)([&](auto& stepper) { return stepper.settle(), ask(stepper.world); });
    }

private:
    std::variant<std::unique_ptr<Stepper<float>>, std::unique_ptr<Stepper<double>>> stepper_;
};

Simulation::Simulation(Scene scene, int threads) : engine_{std::make_unique<Engine>(std::move(scene), threads)} {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;

double Simulation::step(double whole, Next next) {
    return (*engine_)([&](auto& s) { return s.step(whole, next == Next::look); });
}
void Simulation::settle() {
    (*engine_)([](auto& s) { s.settle(); });
}
void Simulation::add_condition(const ConditionSpec& spec, ConditionFunction function) {
    (*engine_)([&](auto& s) { s.add_condition(spec, std::move(function)); });
}
Relaxation Simulation::relax(double residual, std::uint64_t most_steps, const std::function<void()>& after_step) {
    return (*engine_)([&](auto& s) { return s.relax(residual, most_steps, after_step); });
}
double Simulation::time() const {
    return (*engine_)([](auto& s) { return s.world.time; });
}
std::uint64_t Simulation::steps() const {
    return (*engine_)([](auto& s) { return s.world.steps; });
}
std::uint64_t Simulation::particle_count() const { return plan().particles; }
const Scene& Simulation::scene() const {
    return (*engine_)([](auto& s) -> const Scene& { return s.world.scene; });
}
const Plan& Simulation::plan() const {
    return (*engine_)([](auto& s) -> const Plan& { return s.plan; });
}
Ledger Simulation::ledger() const {
    return engine_->settled([](auto& w) { return take_ledger(w); });
}
std::vector<Fragment> Simulation::fragments() const {
    return engine_->settled([](auto& w) { return list_fragments(w); });
}
bool Simulation::can_break() const {
    return (*engine_)([](auto& s) { return any_can_break(s.world); });
}
std::vector<PassTime> Simulation::pass_times() const {
    return (*engine_)([](auto& s) { return s.world.timer.passes(); });
}
std::uint64_t Simulation::generation() const {
    return (*engine_)([](auto& s) { return s.world.generation; });
}
void Simulation::written(const std::string& field) {
    (*engine_)([&](auto& s) { s.settle(), s.note_written(field); });
}
std::vector<std::string> Simulation::frame_fields() const {
    return (*engine_)([](auto& s) { return list_frame_fields(s.world); });
}
Frame Simulation::frame(std::uint32_t number) const { return frame(number, scene().output.fields); }
Frame Simulation::frame(std::uint32_t number, const std::vector<std::string>& names) const {
    return engine_->settled([&](auto& w) { return make_frame(w, number, names); });
}

std::vector<std::string> Simulation::fields(const std::string& material) const {
    std::vector<std::string> names;
    for (const FieldView& v : engine_->settled([&](auto& w) { return list_fields(w, material); }))
        names.push_back(v.name);
    return names;
}

FieldView Simulation::field(const std::string& name, const std::string& material) const {
    for (const FieldView& v : engine_->settled([&](auto& w) { return list_fields(w, material); }))
        if (v.name == name) return v;
    throw InputError("no field '" + name + "'" + (material.empty() ? "" : " in material '" + material + "'") + "\n  " +
                     suggestion(name, fields(material)));
}

}  // namespace perimpm
