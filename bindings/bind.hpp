#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "perimpm/scene/tree.hpp"

namespace perimpm::python {

namespace py = pybind11;

void bind_geometry(py::module_& m);
void bind_registry(py::module_& m);
void bind_laws(py::module_& m);
void bind_scene(py::module_& m);
void bind_particles(py::module_& m);
void bind_simulation(py::module_& m);

/// Calls `body`, which calls back into Python and changes nothing else. A Ctrl-C that arrives inside it must not cut a
/// step in two: it is called once more, and the signal kept for the end of the step.
template <class Body>
auto uninterrupted(Body body) {
    try {
        return body();
    } catch (py::error_already_set& error) {
        if (!error.matches(PyExc_KeyboardInterrupt)) throw;
    }
    struct Again {
        ~Again() { PyErr_SetInterrupt(); }
    } again;
    return body();
}

/// A dict, list, number, bool, text or NumPy value as a scene tree. `path`: dotted place of the value.
Value to_value(py::handle object, const std::string& path);

}  // namespace perimpm::python
