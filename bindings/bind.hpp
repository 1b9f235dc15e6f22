#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "perimpm/scene/tree.hpp"

namespace perimpm::python {

namespace py = pybind11;

void bind_geometry(py::module_& m);
void bind_registry(py::module_& m);
void bind_scene(py::module_& m);
void bind_particles(py::module_& m);
void bind_simulation(py::module_& m);

/// A dict, list, number, bool, text or NumPy value as a scene tree. `path`: dotted place of the value.
Value to_value(py::handle object, const std::string& path);

}  // namespace perimpm::python
