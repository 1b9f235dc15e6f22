#include "perimpm/step/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "perimpm/error.hpp"
#include "step/transfer.hpp"

namespace perimpm {

class Simulation::Engine {
public:
    virtual ~Engine() = default;
    virtual double step(double longest, Next next) = 0;
    virtual void settle() = 0;
    virtual void add_condition(const ConditionSpec& spec, ConditionFunction function) = 0;
    virtual Relaxation relax(double residual, std::uint64_t most_steps, const std::function<void()>& after_step) = 0;
    virtual const Scene& scene() const = 0;
    virtual Ledger ledger() = 0;
    virtual std::vector<Fragment> fragments() = 0;
    virtual bool can_break() const = 0;
    virtual std::vector<FieldView> fields(const std::string& material) = 0;
    virtual std::vector<std::string> frame_fields() = 0;
    virtual Frame frame(std::uint32_t number, const std::vector<std::string>& names) = 0;
    virtual void positions_changed() = 0;
    virtual void velocities_changed() = 0;
    virtual double time() const = 0;
    virtual std::uint64_t steps() const = 0;
    virtual std::uint64_t generation() const = 0;
    virtual const std::vector<PassTime>& pass_times() const = 0;
    Plan plan;
};

template <class Real>
class Simulation::EngineOf final : public Simulation::Engine {
public:
    EngineOf(Scene scene, int threads) : w_{std::move(scene), threads} {
        build_world(w_);
        renew_plan();
        make_frame(w_, 1, w_.scene.output.fields);  // refuses output fields that this scene does not have
    }

    void renew_plan() {
        plan = make_plan(w_);
        plan.warnings = starting_overlaps(w_);
        for (std::uint32_t m = 0; m < w_.scene.materials.size(); ++m)
            if (std::ranges::count(w_.scene.bodies, m, &BodySpec::material) == 0)
                plan.warnings.push_back(fmt::format("no body is of material '{}'", w_.scene.materials[m].name));
        if (w_.transfer_needs.grid)
            for (std::string& text : inexact_faces(w_.scene.grid, w_.images)) plan.warnings.push_back(std::move(text));
        if (w_.transfer_needs.order == 1 && !w_.scene.simulation.dt)
            plan.warnings.emplace_back(
                "transfer.order = 1 has no stable step at free surfaces, so dt = \"auto\" holds for filled "
                "cells only: use order 2 or 3, or give a dt far below the automatic one");
    }

    void add_condition(const ConditionSpec& spec, ConditionFunction function) override {
        if (w_.steps > 0)
            throw InputError("conditions choose their particles at the start: add them before the first step");
        perimpm::add_condition(w_, spec, std::move(function));
        renew_plan();
    }
    Relaxation relax(double residual, std::uint64_t most_steps, const std::function<void()>& after_step) override {
        settle();
        return perimpm::relax(w_, residual, most_steps, [&] {
            const double time = w_.time;
            step(1e300, Next::look);
            w_.time = time;
            if (after_step) after_step();
        });
    }

    double step(double longest, Next next) override {
        return explain([&] { return advance(longest, next); });
    }
    void settle() override {
        explain([&] { finish_step(); });
    }

    const Scene& scene() const override { return w_.scene; }
    Ledger ledger() override { return settle(), take_ledger(w_); }
    std::vector<Fragment> fragments() override { return settle(), list_fragments(w_); }
    bool can_break() const override { return any_can_break(w_); }
    std::vector<FieldView> fields(const std::string& material) override { return settle(), list_fields(w_, material); }
    std::vector<std::string> frame_fields() override { return list_frame_fields(w_); }
    Frame frame(std::uint32_t number, const std::vector<std::string>& names) override {
        return settle(), make_frame(w_, number, names);
    }
    void positions_changed() override { settle(), positions_written_ = true; }
    void velocities_changed() override { settle(), velocities_written_ = true; }
    double time() const override { return w_.time; }
    std::uint64_t steps() const override { return w_.steps; }
    std::uint64_t generation() const override { return w_.generation; }
    const std::vector<PassTime>& pass_times() const override { return w_.timer.passes(); }

private:
    /// Failures of a run whose step was above the stable one say so.
    template <class Action>
    auto explain(const Action& action) {
        try {
            return action();
        } catch (const SimulationError& e) {
            const UnstableStep& u = w_.unstable;
            if (u.step == 0) throw;
            throw SimulationError(
                fmt::format("{}\n  dt is above the stable step: {:g} s, where {:g} s was stable, in step {}; "
                            "simulation.allow_unstable_dt let it pass",
                            e.what(), u.dt, u.bound, u.step));
        }
    }

    /// One step of the method; the numbers are those of the paper's list (section 3).
    double advance(double longest, Next next) {
        if (!gather_can_wait(w_)) finish_step();
        if (std::exchange(positions_written_, false)) accept_positions(w_);
        if (std::exchange(velocities_written_, false)) accept_velocities(w_);
        w_.dt = choose_time_step(w_, longest);
        if (w_.transfer_needs.grid)
            grid_step(next);
        else
            integrate_particles(w_);
        w_.time += w_.dt;
        ++w_.steps;
        return w_.dt;
    }

    void finish_step() {
        if (!std::exchange(w_.motion.owed, false)) return;
        w_.timer("gather", [&] { gather(w_); });  // 5
        if (!w_.defers_gather) w_.max_speed = w_.gathered_speed;
        if (w_.has_crack_surfaces) w_.timer("crack surfaces", [&] { move_crack_surfaces(w_); });
        if (!w_.colliders.empty()) w_.timer("particle collisions", [&] { collide_particles(w_); });  // 6
        if (w_.conditions.holds()) w_.timer("conditions", [&] { move_held_particles(w_); });
    }

    void grid_step(Next next) {
        if (std::exchange(w_.motion.owed, false)) {
            gather_and_scatter(w_);  // 5, 6 of the last step; 1, 2
        } else {
            prepare_scatter();
            scatter(w_);  // 1, 2
        }
        if (w_.defers_gather) w_.max_speed = w_.gathered_speed;
        w_.timer("grid update", [&] {  // 3, 4
            const bool held = w_.conditions.holds();
            if (w_.images.any()) fold_images(w_);
            update_grid(w_);
            if (held) hold_nodes(w_);
            if (w_.images.any()) unfold_images(w_);
        });
        if (next == Next::look || !w_.defers_gather) finish_step();  // 5, 6
    }

    void prepare_scatter() {
        if (w_.drift > sort_margin(w_.transfer_needs.order) * w_.spacing())
            w_.timer("sort", [&] { sort_particles(w_); });
        compute_bond_forces(w_);  // 7 of the last step
        if (w_.has_crack_surfaces) w_.timer("contact of crack surfaces", [&] { apply_contact(w_); });
        const bool conditions = !w_.conditions.list.empty(), held = w_.conditions.holds();
        if (conditions)
            w_.timer("conditions", [&] {
                apply_loads(w_, w_.time, w_.dt);
                prescribe_velocities(w_, w_.time + w_.dt / 2);
                if (held) scatter_held(w_);
            });
    }

    World<Real> w_;
    bool positions_written_ = false, velocities_written_ = false;
};

Simulation::Simulation(Scene scene, int threads) {
    if (scene.simulation.precision == Precision::double_)
        engine_ = std::make_unique<EngineOf<double>>(std::move(scene), threads);
    else
        engine_ = std::make_unique<EngineOf<float>>(std::move(scene), threads);
}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;

double Simulation::step(double longest, Next next) { return engine_->step(longest, next); }
void Simulation::settle() { engine_->settle(); }
void Simulation::add_condition(const ConditionSpec& spec, ConditionFunction function) {
    engine_->add_condition(spec, std::move(function));
}
Relaxation Simulation::relax(double residual, std::uint64_t most_steps, const std::function<void()>& after_step) {
    return engine_->relax(residual, most_steps, after_step);
}
double Simulation::time() const { return engine_->time(); }
std::uint64_t Simulation::steps() const { return engine_->steps(); }
std::uint64_t Simulation::particle_count() const { return engine_->plan.particles; }
const Scene& Simulation::scene() const { return engine_->scene(); }
const Plan& Simulation::plan() const { return engine_->plan; }
Ledger Simulation::ledger() const { return engine_->ledger(); }
std::vector<Fragment> Simulation::fragments() const { return engine_->fragments(); }
bool Simulation::can_break() const { return engine_->can_break(); }
std::vector<PassTime> Simulation::pass_times() const { return engine_->pass_times(); }
std::uint64_t Simulation::generation() const { return engine_->generation(); }
void Simulation::positions_changed() { engine_->positions_changed(); }
void Simulation::velocities_changed() { engine_->velocities_changed(); }
std::vector<std::string> Simulation::frame_fields() const { return engine_->frame_fields(); }
Frame Simulation::frame(std::uint32_t number) const { return frame(number, scene().output.fields); }
Frame Simulation::frame(std::uint32_t number, const std::vector<std::string>& names) const {
    return engine_->frame(number, names);
}

std::vector<std::string> Simulation::fields(const std::string& material) const {
    std::vector<std::string> names;
    for (const FieldView& v : engine_->fields(material)) names.push_back(v.name);
    return names;
}

FieldView Simulation::field(const std::string& name, const std::string& material) const {
    for (const FieldView& v : engine_->fields(material))
        if (v.name == name) return v;
    throw InputError("no field '" + name + "'" + (material.empty() ? "" : " in material '" + material + "'") + "\n  " +
                     suggestion(name, fields(material)));
}

}  // namespace perimpm
