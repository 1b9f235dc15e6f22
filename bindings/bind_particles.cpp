#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "bind.hpp"
#include "simulation.hpp"

namespace perimpm::python {
namespace {

py::dtype dtype_of(FieldView::Type type) {
    switch (type) {
        case FieldView::Type::float32:
            return py::dtype::of<float>();
        case FieldView::Type::float64:
            return py::dtype::of<double>();
        case FieldView::Type::uint32:
            break;
    }
    return py::dtype::of<std::uint32_t>();
}

/// Components lie apart in memory, so (n, 3) has the strides (item, item * stride).
py::array view(py::object owner, const std::string& name, const std::string& material) {
    auto& shared = owner.cast<SharedSimulation&>();
    const auto lock = shared.lock();
    const FieldView field = shared.get().field(name, material);
    const py::dtype type = dtype_of(field.type);
    const py::ssize_t item = type.itemsize(), apart = item * static_cast<py::ssize_t>(field.stride);
    std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(field.size)}, strides{item};
    if (field.components == 9) {
        shape.insert(shape.end(), {3, 3});
        strides.insert(strides.end(), {3 * apart, apart});
    } else if (field.components > 1) {
        shape.push_back(static_cast<py::ssize_t>(field.components));
        strides.push_back(apart);
    }
    return {type, shape, strides, field.data, owner};
}

}  // namespace

void bind_particles(py::module_& m) {
    m.def("view", &view, py::arg("simulation"), py::arg("name"), py::arg("material") = "",
          "A particle field without a copy; the array keeps the simulation alive.");
    m.def(
        "fields",
        [](SharedSimulation& shared, const std::string& material) {
            const auto lock = shared.lock();
            return shared.get().fields(material);
        },
        py::arg("simulation"), py::arg("material") = "", "Names of the fields that exist.");
    m.def(
        "field_unit",
        [](SharedSimulation& shared, const std::string& name, const std::string& material) {
            const auto lock = shared.lock();
            return shared.get().field(name, material).unit;
        },
        py::arg("simulation"), py::arg("name"), py::arg("material") = "", "SI unit of a field.");
}

}  // namespace perimpm::python
