#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "perimpm/export.hpp"
#include "perimpm/plugin/plugin.hpp"

namespace perimpm {

PERIMPM_API const char* family_name(Family family);

/// One plugin file: which model it holds follows from its folder and name, without opening it.
struct PluginFile {
    Family family;
    std::string name;
    std::string path;  ///< the variant for this machine's instruction set, see `installed`
};

/// A constitutive law that a script holds instead of a library.
struct ScriptedLaw {
    PluginDescriptor descriptor;  ///< its functions are null
    std::function<std::unique_ptr<ConstitutiveLaw<float>>(const Params&)> create_float;
    std::function<std::unique_ptr<ConstitutiveLaw<double>>(const Params&)> create_double;
};

/// An opened plugin; libraries and scripts stay open while the process lives.
struct Plugin {
    std::string name;
    std::string path;
    const PluginDescriptor* descriptor;
    std::shared_ptr<const ScriptedLaw> script;  ///< null for libraries
};

/// Opens a script; throws InputError. Set by whoever can run scripts: Python's module perimpm.
using ScriptOpener = std::shared_ptr<const ScriptedLaw> (*)(const std::string& file);
PERIMPM_API void set_script_opener(ScriptOpener opener);

/// All plugin files of a family, sorted by name, from `library_folder()`/plugins and the folders of PERIMPM_PLUGIN_PATH
/// (separated by ':'). A folder holds <family>/<name>.so; beside it x86-64-v3/<name>.so and x86-64-v4/<name>.so are
/// variants, of which the highest that the machine supports is taken (PERIMPM_ISA forces a lower one). Constitutive
/// laws may also be scripts, <name>.py; what begins with '_' is no law, but may be imported by laws.
/// Opens nothing; a file <name>.so or <name>.py directly in a folder is therefore not listed, but found by `open_plugin`.
/// Throws InputError for a name found in two folders, a missing folder and an unknown or unsupported PERIMPM_ISA.
PERIMPM_API std::vector<PluginFile> installed(Family family);

/// Opens a plugin on first use. Throws InputError naming file and reason: unknown name (with the closest one), a
/// library that does not load, a missing or different ABI stamp, a wrong family.
PERIMPM_API const Plugin& open_plugin(Family family, const std::string& name);

/// What was opened so far, sorted: "transfer/apic" for plugins, "module/mesh" for modules.
PERIMPM_API std::vector<std::string> opened_plugins();

template <template <class> class Interface, class Real>
using ModelPtr = std::unique_ptr<Interface<Real>, std::function<void(Interface<Real>*)>>;

/// Creates a model. Throws whatever the model's constructor throws.
template <template <class> class Interface, class Real>
ModelPtr<Interface, Real> create(const std::string& name, const Params& params) {
    const Plugin& plugin = open_plugin(detail::FamilyOf<Interface>::value, name);
    const PluginDescriptor& d = *plugin.descriptor;
    constexpr bool is_float = std::is_same_v<Real, float>;
    if constexpr (detail::FamilyOf<Interface>::value == Family::constitutive) {
        if (const ScriptedLaw* script = plugin.script.get()) {
            if constexpr (is_float)
                return script->create_float(params);
            else
                return script->create_double(params);
        }
    }
    auto* model = static_cast<Interface<Real>*>((is_float ? d.create_float : d.create_double)(params));
    return {model, [destroy = is_float ? d.destroy_float : d.destroy_double](Interface<Real>* m) { destroy(m); }};
}

/// Creates the model that the parameter `key` names. What its constructor refuses is refused as "key.its key".
template <template <class> class Interface, class Real>
ModelPtr<Interface, Real> create_inner(const Params& p, const char* key) {
    const ModelChoice& inner = *p.model(key);
    try {
        return create<Interface, Real>(inner.type, Params(inner.specs, inner.values, inner.count, p.context()));
    } catch (const InvalidParameter& e) {
        throw InvalidParameter(std::string(key) + "." + e.key(), e.what());
    }
}

/// Where the core library and everything shipped with it lives.
PERIMPM_API std::string library_folder();

/// Opens a part of perimpm that only some scenes need ("mesh", "hdf5": `library_folder()`/perimpm_<name>.so) and
/// returns its factory symbol. Throws InputError when the module was not built or does not load.
PERIMPM_API void* open_module(const std::string& name, const char* symbol);

}  // namespace perimpm
