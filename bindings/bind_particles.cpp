#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cstring>

#include "bind.hpp"
#include "simulation.hpp"

namespace perimpm::python {
namespace {

py::dtype dtype_of(NumberType type) {
    switch (type) {
        case NumberType::float32:
            return py::dtype::of<float>();
        case NumberType::float64:
            return py::dtype::of<double>();
        case NumberType::uint32:
            break;
    }
    return py::dtype::of<std::uint32_t>();
}

/// Components lie apart in memory or side by side: (n, 3) has the strides (item * entry, item * stride).
py::array view(py::object owner, const std::string& name, const std::string& material) {
    auto& shared = owner.cast<SharedSimulation&>();
    const auto lock = shared.lock();
    const FieldView field = shared.get().field(name, material);
    const py::dtype type = dtype_of(field.type);
    const py::ssize_t item = type.itemsize(), apart = item * static_cast<py::ssize_t>(field.stride);
    std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(field.size)};
    std::vector<py::ssize_t> strides{item * static_cast<py::ssize_t>(field.entry)};
    if (field.components == 9) {
        shape.insert(shape.end(), {3, 3});
        strides.insert(strides.end(), {3 * apart, apart});
    } else if (field.components > 1) {
        shape.push_back(static_cast<py::ssize_t>(field.components));
        strides.push_back(apart);
    }
    py::array array(type, shape, strides, field.data, owner);
    if (!field.writable) py::setattr(array.attr("flags"), "writeable", py::bool_(false));
    return array;
}

/// A hash of the field's bits: any change of one number changes it, and no two states that a run meets share it in
/// practice. Costs one read of the field.
std::uint64_t fingerprint(SharedSimulation& shared, const std::string& name, const std::string& material) {
    const auto lock = shared.lock();
    const FieldView field = shared.get().field(name, material);
    std::uint64_t hash = 0;
    const auto mix = [&hash](std::uint64_t word) {
        hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 32;
    };
    const std::size_t item = bytes_of(field.type);
    for (std::size_t c = 0; c < field.components; ++c) {
        const auto* from = static_cast<const std::byte*>(field.data) + c * field.stride * item;
        for (std::size_t i = 0; field.entry != 1 && i < field.size; ++i) {
            std::uint64_t word = 0;
            std::memcpy(&word, from + i * field.entry * item, item);
            mix(word);
        }
        const std::size_t bytes = field.entry == 1 ? field.size * item : 0;  // side by side: words at once
        for (std::size_t at = 0; at < bytes; at += sizeof(std::uint64_t)) {
            std::uint64_t word = 0;
            std::memcpy(&word, from + at, std::min(sizeof word, bytes - at));
            mix(word);
        }
    }
    return hash;
}

}  // namespace

void bind_particles(py::module_& m) {
    m.def("view", &view, py::arg("simulation"), py::arg("name"), py::arg("material") = "",
          "A particle field without a copy; the array keeps the simulation alive.");
    m.def("fingerprint", &fingerprint, py::arg("simulation"), py::arg("name"), py::arg("material") = "",
          "A number that changes when any value of the field does.");
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
