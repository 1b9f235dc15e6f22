#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <deque>
#include <optional>

#include "bind.hpp"
#include "perimpm/error.hpp"
#include "perimpm/plugin/registry.hpp"

/*! Laws written in Python (perimpm/laws.py): a class there, an object of PythonLaw for each material here. */
namespace perimpm::python {
namespace {

py::module_ laws() { return py::module_::import("perimpm.laws"); }

/// Calls body(); errors that perimpm.laws raises about a law's file or parameters become those of core, which knows the
/// place in the scene.
template <class Body>
auto checked(Body body) {
    try {
        return body();
    } catch (py::error_already_set& error) {
        const std::string text = py::str(error.value());
        if (error.matches(laws().attr("InvalidParameter")))
            throw InvalidParameter(error.value().attr("key").cast<std::string>(), text);
        if (error.matches(laws().attr("InputError"))) throw InputError(text);
        throw;
    }
}

/// A law as its file declares it. Names are held here, since declarations point to them.
struct PythonScript : ScriptedLaw {
    py::object law;  ///< the class; scripts stay open for good
    std::string summary;
    std::deque<std::string> texts;
    std::vector<ParamSpec> params;

    ~PythonScript() {
        const py::gil_scoped_acquire gil;
        law = {};
    }
    const char* keep(const py::object& text) { return texts.emplace_back(text.cast<std::string>()).c_str(); }
};

ParamSpec declaration(PythonScript& script, const py::handle& parameter) {
    const auto number = [&](const char* name) { return parameter.attr(name).cast<std::optional<double>>(); };
    ParamSpec spec{.key = script.keep(parameter.attr("key")),
                   .unit = script.keep(parameter.attr("unit")),
                   .default_value = number("default").value_or(kRequired),
                   .doc = script.keep(parameter.attr("doc"))};
    if (const auto low = number("above")) spec.range.low = *low;
    if (const auto low = number("at_least")) spec.range.low = *low, spec.range.low_open = false;
    if (const auto high = number("below")) spec.range.high = *high;
    if (const auto high = number("at_most")) spec.range.high = *high, spec.range.high_open = false;
    return spec;
}

/// Numbers of core as an array that Python cannot write to.
template <class Real>
py::array view(const Real* data, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides) {
    for (py::ssize_t& stride : strides) stride *= static_cast<py::ssize_t>(sizeof(Real));
    py::array array(py::dtype::of<Real>(), std::move(shape), std::move(strides), data, py::none());
    array.attr("setflags")(py::arg("write") = false);
    return array;
}

template <class Real>
class PythonLaw final : public ConstitutiveLaw<Real> {
public:
    /// With the interpreter lock held.
    explicit PythonLaw(py::object law)
        : law_{std::move(law)},
          moduli_{law_.attr("youngs_modulus").template cast<double>(),
                  law_.attr("poisson_ratio").template cast<double>()} {}
    ~PythonLaw() override {
        const py::gil_scoped_acquire gil;
        law_ = {};
    }
    LawNeeds needs() const noexcept override {
        return {.deformation_gradient = true, .may_refuse = true, .moduli = moduli_};
    }

    void evaluate(Block<Real>& b, Real) const override {
        const py::gil_scoped_acquire gil;
        const auto tau = uninterrupted(
            [&] { return laws().attr("evaluate")(law_, F(b)).template cast<py::array_t<Real, py::array::c_style>>(); });
        for (std::size_t c = 0; c < 6; ++c) std::copy_n(tau.data() + c * b.size, b.size, b.tau[c]);
    }
    double max_wave_speed(const Block<Real>& b) const override {
        const py::gil_scoped_acquire gil;
        return uninterrupted([&] { return laws().attr("wave_speed")(law_, F(b)).template cast<double>(); });
    }
    double energy(const Block<Real>& b) const override {
        const py::gil_scoped_acquire gil;
        return uninterrupted(
            [&] { return laws().attr("energy")(law_, F(b), view(b.volume, {b.size}, {1})).template cast<double>(); });
    }

private:
    static py::array F(const Block<Real>& b) {
        const auto stride = static_cast<py::ssize_t>(b.F.stride);
        return view(b.F.data, {b.size, 3, 3}, {1, 3 * stride, stride});
    }

    py::object law_;
    EffectiveModuli moduli_;
};

template <class Real>
std::unique_ptr<ConstitutiveLaw<Real>> make_law(const PythonScript& script, const Params& params) {
    const py::gil_scoped_acquire gil;
    py::dict values;
    for (const ParamSpec& spec : script.params) values[spec.key] = params[spec.key];
    return checked([&] {
        return std::make_unique<PythonLaw<Real>>(laws().attr("make_law")(script.law, values, params.context().density));
    });
}

std::shared_ptr<const ScriptedLaw> open_script(const std::string& file) {
    const py::gil_scoped_acquire gil;
    auto script = std::make_shared<PythonScript>();
    const py::tuple opened = checked([&] { return py::tuple(laws().attr("open_law")(file)); });
    script->law = opened[0];
    script->summary = opened[1].cast<std::string>();
    for (const py::handle parameter : opened[2]) script->params.push_back(declaration(*script, parameter));
    script->descriptor = {Family::constitutive,
                          script->summary.c_str(),
                          script->params.data(),
                          static_cast<std::uint32_t>(script->params.size()),
                          nullptr,
                          nullptr,
                          nullptr,
                          nullptr};
    const PythonScript& held = *script;  // lives as long as these functions, which it holds
    script->create_float = [&held](const Params& params) { return make_law<float>(held, params); };
    script->create_double = [&held](const Params& params) { return make_law<double>(held, params); };
    return script;
}

}  // namespace

void bind_laws(py::module_&) { set_script_opener(&open_script); }

}  // namespace perimpm::python
