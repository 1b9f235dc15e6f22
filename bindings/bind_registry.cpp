#include <pybind11/stl.h>

#include <cmath>
#include <optional>

#include "bind.hpp"
#include "perimpm/error.hpp"
#include "perimpm/plugin/registry.hpp"
#include "perimpm/scene/scene.hpp"

namespace perimpm::python {
namespace {

constexpr Family kFamilies[] = {Family::transfer, Family::constitutive, Family::fracture};

/// An opened plugin under the family it belongs to.
struct Model {
    Family family;
    const Plugin* plugin;
};

/// known: names to propose when there is no such model.
Family family_of(const std::string& model, const std::vector<std::string>& known) {
    for (Family family : kFamilies)
        for (const PluginFile& file : installed(family))
            if (file.name == model) return family;
    throw InputError("nothing is called '" + model + "'\n  " + suggestion(model, known));
}

Model open_model(const std::string& name, const std::vector<std::string>& known) {
    const Family family = family_of(name, known);
    return {family, &open_plugin(family, name)};
}

std::vector<ParamSpec> params_of(const Model& model) {
    const PluginDescriptor& d = *model.plugin->descriptor;
    return {d.params, d.params + d.param_count};
}

const char* kind_name(ParamKind kind) {
    switch (kind) {
        case ParamKind::number:
            return "number";
        case ParamKind::integer:
            return "integer";
        case ParamKind::boolean:
            return "boolean";
        case ParamKind::text:
            return "text";
        case ParamKind::choice:
            return "choice";
        case ParamKind::vector:
            return "vector";
        case ParamKind::table:
            return "table";
        case ParamKind::list:
            return "list";
        case ParamKind::model:
            return "model";
    }
    return "";
}

using Default = std::variant<std::monostate, bool, std::int64_t, double, std::string>;

Default default_of(const ParamSpec& spec) {
    if (spec.default_text) return std::string(spec.default_text);
    if (std::isnan(spec.default_value)) return {};
    if (spec.kind == ParamKind::boolean) return spec.default_value != 0.0;
    if (spec.kind == ParamKind::integer) return static_cast<std::int64_t>(spec.default_value);
    return spec.default_value;
}

std::vector<std::string> choices_of(const ParamSpec& spec) {
    std::vector<std::string> choices;
    std::string rest = spec.choices ? spec.choices : "";
    while (!rest.empty()) {
        const std::size_t bar = rest.find('|');
        choices.push_back(rest.substr(0, bar));
        rest = bar == std::string::npos ? "" : rest.substr(bar + 1);
    }
    return choices;
}

/// "> 0", ">= 0", "(-1, 0.5)" with round brackets for excluded ends; "" without bounds.
std::string range_text(const Range& range) {
    const bool low = std::isfinite(range.low), high = std::isfinite(range.high);
    const auto number = [](double value) { return py::str("{:g}").format(value).cast<std::string>(); };
    if (low && high)
        return (range.low_open ? "(" : "[") + number(range.low) + ", " + number(range.high) +
               (range.high_open ? ")" : "]");
    if (low) return (range.low_open ? "> " : ">= ") + number(range.low);
    if (high) return (range.high_open ? "< " : "<= ") + number(range.high);
    return "";
}

void bind_param(py::module_& m) {
    py::class_<ParamSpec>(m, "Param", "Declaration of one key of a scene table.")
        .def_readonly("key", &ParamSpec::key)
        .def_property_readonly("kind", [](const ParamSpec& p) { return kind_name(p.kind); })
        .def_readonly("unit", &ParamSpec::unit)
        .def_property_readonly("range", [](const ParamSpec& p) { return range_text(p.range); })
        .def_property_readonly("low", [](const ParamSpec& p) { return p.range.low; })
        .def_property_readonly("high", [](const ParamSpec& p) { return p.range.high; })
        .def_property_readonly("default", &default_of, "None when the key must be given or may be absent.")
        .def_property_readonly(
            "required",
            [](const ParamSpec& p) { return !p.optional && std::holds_alternative<std::monostate>(default_of(p)); })
        .def_property_readonly("choices", &choices_of)
        .def_readonly("per_particle", &ParamSpec::per_particle)
        .def_readonly("doc", &ParamSpec::doc);
    py::class_<SectionDoc>(m, "Section", "A table of a scene and the keys it accepts.")
        .def_readonly("topic", &SectionDoc::topic)
        .def_readonly("name", &SectionDoc::name)
        .def_readonly("doc", &SectionDoc::doc)
        .def_readonly("keys", &SectionDoc::keys);
}

}  // namespace

void bind_registry(py::module_& m) {
    bind_param(m);
    py::class_<Model>(m, "Model", "A model as its plugin describes it.")
        .def_property_readonly("name", [](const Model& model) { return model.plugin->name; })
        .def_property_readonly("family", [](const Model& model) { return family_name(model.family); })
        .def_property_readonly("path", [](const Model& model) { return model.plugin->path; })
        .def_property_readonly("summary", [](const Model& model) { return model.plugin->descriptor->summary; })
        .def_property_readonly("params", &params_of);
    m.def("open_model", &open_model, py::arg("name"), py::arg("known") = std::vector<std::string>(),
          "Opens the plugin of this name; `known`: names to propose when there is none.");
    m.def(
        "installed",
        [] {
            std::vector<std::tuple<std::string, std::string, std::string>> files;
            for (Family family : kFamilies)
                for (const PluginFile& file : installed(family))
                    files.emplace_back(family_name(family), file.name, file.path);
            return files;
        },
        "(family, name, file) of every plugin; opens none.");
    m.def("opened_plugins", &opened_plugins, "Names of the plugins opened so far.");
    m.def("library_folder", &library_folder, "Where the core library and everything shipped with it lives.");
}

}  // namespace perimpm::python
