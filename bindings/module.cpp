#include "bind.hpp"
#include "perimpm/error.hpp"

namespace perimpm::python {
namespace {

/// Errors appear as perimpm.InputError, not as part of the private module.
template <class Error>
void bind_error(py::module_& m, const char* name, PyObject* base, const char* doc) {
    auto& type = py::register_exception<Error>(m, name, base);
    type.attr("__module__") = "perimpm";
    type.doc() = doc;
}

}  // namespace

PYBIND11_MODULE(_core, m) {
    m.doc() = "The compiled part of perimpm; use the package perimpm.";
    m.attr("__version__") = PERIMPM_VERSION;
    bind_error<InputError>(
        m, "InputError", PyExc_ValueError,
        "The scene, a file, a plugin or an argument is wrong; the text names place, cause and remedy.");
    bind_error<SimulationError>(m, "SimulationError", PyExc_RuntimeError,
                                "The simulation itself failed: a NaN, a particle that left the domain.");
    bind_geometry(m);
    bind_registry(m);
    bind_laws(m);
    bind_scene(m);
    bind_particles(m);
    bind_simulation(m);
}

}  // namespace perimpm::python
