#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <chrono>
#include <exception>
#include <optional>

#include "bind.hpp"
#include "perimpm/error.hpp"
#include "perimpm/io/run.hpp"
#include "perimpm/step/stiffness.hpp"
#include "simulation.hpp"

namespace perimpm::python {

std::unique_lock<std::recursive_mutex> SharedSimulation::lock() {
    std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock) throw std::runtime_error("this simulation is in use by another thread");
    return lock;
}

namespace {

using Clock = std::chrono::steady_clock;
using Report = std::optional<py::function>;

/// Between steps: lets Python handle Ctrl-C and shows the progress, every 50 ms and at every new frame. Any exception
/// raised there stops the run after the step and is raised again once the files are whole.
class Watch {
public:
    explicit Watch(Report report = {}) : report_{std::move(report)} {}

    bool go_on(const Progress* progress) {
        const auto now = Clock::now();
        const std::uint32_t frame = progress ? progress->frame : 0;
        if (now - last_ < std::chrono::milliseconds(50) && frame == frame_) return true;
        last_ = now;
        frame_ = frame;
        const py::gil_scoped_acquire gil;
        try {
            if (PyErr_CheckSignals() != 0) throw py::error_already_set();
            if (progress && report_) (*report_)(*progress);
        } catch (...) {
            pending_ = std::current_exception();
        }
        return !pending_;
    }

    /// With the interpreter lock held.
    void raise_pending() const {
        if (pending_) std::rethrow_exception(pending_);
    }

private:
    Report report_;
    std::exception_ptr pending_;
    Clock::time_point last_ = Clock::now();
    std::uint32_t frame_ = 0;
};

/// "3.11.2" of "3.11.2 (main, ...) [GCC ...]".
std::string python_version() {
    const std::string text = Py_GetVersion();
    return text.substr(0, text.find(' '));
}

void run_simulation(SharedSimulation& shared, const std::string& folder, std::uint32_t frames, Report report) {
    const auto lock = shared.lock();
    Watch watch(std::move(report));
    {
        const py::gil_scoped_release release;
        run(shared.get(),
            {folder, frames, shared.threads(), {{"Python", python_version()}}, [&watch](const Progress& p) {
                 return watch.go_on(&p);
             }});
    }
    watch.raise_pending();
}

double step_simulation(SharedSimulation& shared, std::uint64_t count) {
    const auto lock = shared.lock();
    Watch watch;
    double dt = 0;
    {
        const py::gil_scoped_release release;
        for (std::uint64_t i = 0; i < count; ++i) {
            dt = shared.get().step(1e300, Simulation::Next::step);
            if (!watch.go_on(nullptr)) break;
        }
        shared.get().settle();
    }
    watch.raise_pending();
    return dt;
}

/// values[n][3] = function(X[n][3], t), which returns an array of the shape of X or one row for all.
void evaluate(const py::object& function, double t, std::size_t n, const double* X, double* values) {
    const auto rows = static_cast<py::ssize_t>(n);
    const py::object result = function(py::array_t<double>({rows, py::ssize_t{3}}, X), t);
    const auto numpy = py::module_::import("numpy");
    py::array_t<double, py::array::c_style | py::array::forcecast> array;
    try {
        array = numpy.attr("broadcast_to")(numpy.attr("asarray")(result, py::arg("dtype") = "float64"),
                                           py::make_tuple(rows, 3));
    } catch (py::error_already_set& error) {
        if (!error.matches(PyExc_ValueError) && !error.matches(PyExc_TypeError)) throw;
        throw InputError("the function of a condition returned " + std::string(py::repr(result)).substr(0, 200) +
                         ": expected numbers of shape (" + std::to_string(n) + ", 3) or (3,)");
    }
    std::copy_n(array.data(), 3 * n, values);
}

ConditionFunction to_function(py::object callable) {
    // The last reference may go while the interpreter lock is not held.
    const std::shared_ptr<py::object> shared(new py::object(std::move(callable)), [](py::object* object) {
        const py::gil_scoped_acquire gil;
        delete object;
    });
    return [shared](double t, std::size_t n, const double* X, double* values) {
        const py::gil_scoped_acquire gil;
        uninterrupted([&] { evaluate(*shared, t, n, X, values); });
    };
}

const std::pair<const char*, Drive> kDrives[] = {
    {"velocity", Drive::velocity}, {"acceleration", Drive::acceleration}, {"body_force", Drive::body_force}};

/// `table` as in [[condition]]; values from `function` when that is not None: of the quantity `drive`.
void add_condition(SharedSimulation& shared, py::handle table, const std::string& drive, py::object function) {
    const auto lock = shared.lock();
    Simulation& simulation = shared.get();
    const Value value = to_value(table, "condition");
    std::optional<Drive> given;
    for (const auto& [key, kind] : kDrives)
        if (!function.is_none() && drive == key) given = kind;
    const ConditionSpec spec =
        read_condition(value, simulation.scene().conditions.size() + shared.added++, simulation.scene(), given);
    simulation.add_condition(spec, given ? to_function(std::move(function)) : ConditionFunction());
}

Relaxation relax_simulation(SharedSimulation& shared, double residual, std::uint64_t most_steps) {
    struct Stopped {};
    const auto lock = shared.lock();
    Watch watch;
    Relaxation found{};
    try {
        const py::gil_scoped_release release;
        found = shared.get().relax(residual, most_steps, [&watch] {
            if (!watch.go_on(nullptr)) throw Stopped{};
        });
    } catch (const Stopped&) {
        watch.raise_pending();
    }
    return found;
}

/// A read of the simulation that refuses while another thread uses it.
template <class Function>
auto guarded(Function read) {
    return [read](SharedSimulation& shared) {
        const auto lock = shared.lock();
        return read(shared.get());
    };
}

void bind_plan(py::module_& m) {
    const py::class_<Plan> plan(m, "Plan", "What a scene compiles to: passes, memory, time step, what was left out.");
    py::class_<Plan::Pass>(plan, "Pass")
        .def_readonly("name", &Plan::Pass::name)
        .def_readonly("when", &Plan::Pass::when)
        .def_readonly("reads", &Plan::Pass::reads)
        .def_readonly("writes", &Plan::Pass::writes)
        .def_readonly("models", &Plan::Pass::models);
    py::class_<Plan::Array>(plan, "Array")
        .def_readonly("name", &Plan::Array::name)
        .def_readonly("bytes", &Plan::Array::bytes);
    py::class_<Plan::Material>(plan, "Material")
        .def_readonly("name", &Plan::Material::name)
        .def_readonly("law", &Plan::Material::law)
        .def_readonly("criterion", &Plan::Material::criterion)
        .def_readonly("particles", &Plan::Material::particles)
        .def_readonly("bonds", &Plan::Material::bonds)
        .def_readonly("youngs_modulus", &Plan::Material::youngs_modulus, "As the law has it [Pa].")
        .def_readonly("poisson_ratio", &Plan::Material::poisson_ratio)
        .def_readonly("wave_speed", &Plan::Material::wave_speed, "[m/s]");
    py::class_<Plan::TimeStepBound>(plan, "TimeStepBound")
        .def_readonly("source", &Plan::TimeStepBound::source)
        .def_readonly("dt", &Plan::TimeStepBound::dt, "[s]");
    py::class_<Plan::Skipped>(plan, "Skipped")
        .def_readonly("what", &Plan::Skipped::what)
        .def_readonly("why", &Plan::Skipped::why);
    py::class_<Plan>(plan)
        .def_readonly("passes", &Plan::passes)
        .def_readonly("arrays", &Plan::arrays)
        .def_readonly("materials", &Plan::materials)
        .def_readonly("bounds", &Plan::bounds)
        .def_readonly("dt", &Plan::dt, "The step the run starts with [s].")
        .def_readonly("steps", &Plan::steps, "As long as it, until the scene's end.")
        .def_readonly("particles", &Plan::particles)
        .def_readonly("libraries", &Plan::libraries)
        .def_readonly("skipped", &Plan::skipped)
        .def_readonly("warnings", &Plan::warnings, "What is allowed but seldom meant.");
}

std::vector<MeasuredStiffness> measure(SharedSimulation& shared) {
    const auto lock = shared.lock();
    const py::gil_scoped_release release;
    return measure_stiffness(shared.get().scene(), shared.threads());
}

void bind_stiffness(py::module_& m) {
    py::class_<FamilyStiffness>(m, "FamilyStiffness", "Small-strain stiffness of families.")
        .def_readonly("youngs_modulus", &FamilyStiffness::youngs_modulus, "Of the average over directions [Pa].")
        .def_readonly("poisson_ratio", &FamilyStiffness::poisson_ratio, "The same.")
        .def_readonly("softest", &FamilyStiffness::softest, "Least Young's modulus by direction [Pa].")
        .def_readonly("stiffest", &FamilyStiffness::stiffest, "Largest Young's modulus by direction [Pa].");
    py::class_<MeasuredStiffness>(m, "MeasuredStiffness", "What a law was asked for, and what its families have.")
        .def_readonly("material", &MeasuredStiffness::material)
        .def_readonly("dimension", &MeasuredStiffness::dimension, "3: solids, 2: sheets, 1: strands.")
        .def_readonly("youngs_modulus", &MeasuredStiffness::youngs_modulus, "Asked [Pa].")
        .def_readonly("poisson_ratio", &MeasuredStiffness::poisson_ratio, "Asked.")
        .def_readonly("bulk_particles", &MeasuredStiffness::bulk_particles)
        .def_readonly("bulk", &MeasuredStiffness::bulk)
        .def_readonly("wave_speed", &MeasuredStiffness::wave_speed, "Longitudinal, in the bulk [m/s].")
        .def_readonly("surface_particles", &MeasuredStiffness::surface_particles)
        .def_readonly("worst", &MeasuredStiffness::worst)
        .def_property_readonly("worst_position",
                               [](const MeasuredStiffness& s) {
                                   return py::make_tuple(s.worst_position[0], s.worst_position[1], s.worst_position[2]);
                               })
        .def_readonly("unstable_particles", &MeasuredStiffness::unstable_particles)
        .def("__repr__", [](const MeasuredStiffness& s) {
            return py::str("<MeasuredStiffness of {}: asked {:.4g} Pa and {:.4g}, bulk {:.4g} Pa and {:.4g}>")
                .format(s.material, s.youngs_modulus, s.poisson_ratio, s.bulk.youngs_modulus, s.bulk.poisson_ratio);
        });
}

void bind_records(py::module_& m) {
    py::class_<Ledger>(m, "Ledger", "Sums over all particles, SI units.")
        .def_readonly("time", &Ledger::time)
        .def_readonly("kinetic", &Ledger::kinetic)
        .def_readonly("elastic", &Ledger::elastic)
        .def_readonly("potential", &Ledger::potential)
        .def_readonly("momentum", &Ledger::momentum)
        .def_readonly("angular_momentum", &Ledger::angular_momentum)
        .def("__repr__", [](const Ledger& l) {
            return py::str("<Ledger at {:.4g} s: kinetic {:.4g} J, elastic {:.4g} J, potential {:.4g} J>")
                .format(l.time, l.kinetic, l.elastic, l.potential);
        });
    py::class_<Fragment>(m, "Fragment", "A piece of matter: particles that live bonds join.")
        .def_readonly("id", &Fragment::id, "The least id of its particles.")
        .def_readonly("particles", &Fragment::particles)
        .def_readonly("mass", &Fragment::mass, "[kg]")
        .def_readonly("center", &Fragment::center, "Of the mass [m].")
        .def_readonly("velocity", &Fragment::velocity, "[m/s]")
        .def("__repr__", [](const Fragment& f) {
            return py::str("<Fragment {}: {} particles, {:.4g} kg, at ({:.4g}, {:.4g}, {:.4g}) m>")
                .format(f.id, f.particles, f.mass, f.center[0], f.center[1], f.center[2]);
        });
    py::class_<Relaxation>(m, "Relaxation", "How a search for equilibrium ended.")
        .def_readonly("steps", &Relaxation::steps)
        .def_readonly("residual", &Relaxation::residual)
        .def("__repr__", [](const Relaxation& r) {
            return py::str("<Relaxation: {} steps, residual {:.3g}>").format(r.steps, r.residual);
        });
    py::class_<PassTime>(m, "PassTime", "Wall time of one pass since the start.")
        .def_readonly("name", &PassTime::name)
        .def_readonly("calls", &PassTime::calls)
        .def_readonly("seconds", &PassTime::seconds)
        .def("__repr__", [](const PassTime& t) {
            return py::str("<PassTime {}: {} calls, {:.3g} s>").format(t.name, t.calls, t.seconds);
        });
    py::class_<Progress>(m, "Progress", "Where a run is.")
        .def_readonly("frame", &Progress::frame, "Last frame written.")
        .def_readonly("frames", &Progress::frames, "Frames to write.")
        .def_readonly("steps", &Progress::steps)
        .def_readonly("particles", &Progress::particles)
        .def_readonly("time", &Progress::time, "Simulated time [s].")
        .def_readonly("end_time", &Progress::end_time, "[s]")
        .def_readonly("elapsed", &Progress::elapsed, "Wall time of this run [s].");
}

}  // namespace

void bind_simulation(py::module_& m) {
    bind_plan(m);
    bind_records(m);
    bind_stiffness(m);
    py::class_<SharedSimulation>(m, "Simulation", "A scene in motion.")
        .def(py::init<Scene, int>(), py::arg("scene"), py::arg("threads") = 0, py::call_guard<py::gil_scoped_release>())
        .def("run", &run_simulation, py::arg("folder"), py::arg("frames"), py::arg("report") = Report(),
             "Runs to frame `frames` (0: the end); `report` is called with a Progress between steps.")
        .def("step", &step_simulation, py::arg("count") = 1, "Advances; returns the last step taken [s].")
        .def("add_condition", &add_condition, py::arg("table"), py::arg("drive") = "", py::arg("function") = py::none())
        .def("relax", &relax_simulation, py::arg("residual"), py::arg("most_steps"))
        .def(
            "written",
            [](SharedSimulation& shared, const std::string& field) {
                const auto lock = shared.lock();
                shared.get().written(field);
            },
            py::arg("field"))
        .def("measure_stiffness", &measure,
             "Small-strain stiffness of every material as the scene starts; takes about as long as building it.")
        .def_property_readonly("scene", [](SharedSimulation& s) { return s.get().scene(); })
        .def_property_readonly("plan", [](SharedSimulation& s) { return s.get().plan(); })
        .def_property_readonly("time", guarded([](Simulation& s) { return s.time(); }), "[s]")
        .def_property_readonly("steps", guarded([](Simulation& s) { return s.steps(); }))
        .def_property_readonly("particle_count", guarded([](Simulation& s) { return s.particle_count(); }))
        .def_property_readonly("generation", guarded([](Simulation& s) { return s.generation(); }))
        .def_property_readonly("ledger", guarded([](Simulation& s) {
                                   const py::gil_scoped_release release;  // threads may call a law in Python
                                   return s.ledger();
                               }))
        .def_property_readonly("fragments", guarded([](Simulation& s) { return s.fragments(); }))
        .def_property_readonly("pass_times", guarded([](Simulation& s) { return s.pass_times(); }));
}

}  // namespace perimpm::python
