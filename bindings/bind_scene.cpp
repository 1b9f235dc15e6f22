#include <pybind11/stl.h>

#include <filesystem>

#include "bind.hpp"
#include "perimpm/error.hpp"
#include "perimpm/io/run.hpp"
#include "perimpm/scene/scene.hpp"

namespace perimpm::python {
namespace {

std::string join(const std::string& path, const std::string& key) { return path.empty() ? key : path + "." + key; }

Value::Table to_table(py::handle mapping, const std::string& path) {
    Value::Table table;
    for (py::handle item : mapping.attr("items")()) {
        const auto pair = py::reinterpret_borrow<py::tuple>(item);
        if (!py::isinstance<py::str>(pair[0]))
            throw InputError(path, "keys of a scene table are texts, not " + std::string(py::repr(pair[0])));
        const auto key = pair[0].cast<std::string>();
        table.emplace_back(key, to_value(pair[1], join(path, key)));
    }
    return table;
}

Value::List to_list(py::handle sequence, const std::string& path) {
    Value::List list;
    for (py::handle item : sequence) list.push_back(to_value(item, join(path, std::to_string(list.size()))));
    return list;
}

bool is_instance(py::handle object, const char* module, const char* type) {
    return py::isinstance(object, py::module_::import(module).attr(type));
}

std::int64_t to_integer(py::handle object, const std::string& path) {
    const auto number = py::reinterpret_steal<py::object>(PyNumber_Index(object.ptr()));
    const long long value = PyLong_AsLongLong(number.ptr());
    if (value == -1 && PyErr_Occurred()) {
        PyErr_Clear();
        throw InputError(path, "the integer " + std::string(py::str(object)) + " does not fit into 64 bits");
    }
    return value;
}

Scene make_scene(py::handle scene, const std::vector<std::string>& overrides, const std::string& folder) {
    const bool is_dict = is_instance(scene, "collections.abc", "Mapping");
    Value tree;
    std::string base = folder;
    if (is_dict) {
        tree = to_value(scene, "");
    } else {
        const auto path = py::module_::import("os").attr("fspath")(scene).cast<std::string>();
        tree = parse_scene_file(path);
        if (base.empty()) base = std::filesystem::path(path).parent_path().string();
    }
    for (const std::string& assignment : overrides) apply_override(tree, assignment);
    return read_scene(std::move(tree), base.empty() ? "." : base);
}

}  // namespace

Value to_value(py::handle object, const std::string& path) {
    Value value;
    value.place.path = path;
    if (py::isinstance<py::bool_>(object) || is_instance(object, "numpy", "bool_"))
        value.data = object.cast<bool>();
    else if (py::isinstance<py::float_>(object) || is_instance(object, "numpy", "floating"))
        value.data = PyFloat_AsDouble(object.ptr());
    else if (py::isinstance<py::str>(object))
        value.data = object.cast<std::string>();
    else if (is_instance(object, "os", "PathLike"))
        value.data = py::module_::import("os").attr("fspath")(object).cast<std::string>();
    else if (is_instance(object, "collections.abc", "Mapping"))
        value.data = to_table(object, path);
    else if (is_instance(object, "numpy", "ndarray"))
        return to_value(object.attr("tolist")(), path);
    else if (PyIndex_Check(object.ptr()))
        value.data = to_integer(object, path);
    else if (is_instance(object, "collections.abc", "Sequence"))
        value.data = to_list(object, path);
    else
        throw InputError(path, "a scene value is a number, bool, text, list or dict, not " +
                                   std::string(py::str(py::type::of(object).attr("__name__"))));
    return value;
}

void bind_scene(py::module_& m) {
    py::class_<Scene>(m, "Scene", "A checked scene; the plugins it names are open.")
        .def(py::init(&make_scene), py::arg("scene"), py::arg("overrides") = std::vector<std::string>(),
             py::arg("folder") = "",
             "From a TOML file or a dict, changed by overrides such as \"simulation.dt=1e-4\". `folder` is where "
             "relative "
             "file names start: by default the folder of the scene file, or the current one for a dict.")
        .def_readonly("title", &Scene::title)
        .def_property_readonly(
            "end_time", [](const Scene& s) { return s.simulation.end_time; }, "[s]")
        .def_property_readonly(
            "frame_rate", [](const Scene& s) { return s.simulation.frame_rate; }, "[1/s]")
        .def_property_readonly("last_frame", &last_frame, "Number of the last frame of a run to the end.")
        .def(
            "to_toml", [](const Scene& s) { return s.source.to_toml(); }, "The tree that was read, as TOML.")
        .def(
            "to_json", [](const Scene& s) { return s.source.to_json(); }, "The tree that was read, as JSON.");
    m.def("scene_reference", &scene_reference, "Every table of a scene with the keys it accepts.");
}

}  // namespace perimpm::python
