#include "perimpm/plugin/registry.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <mutex>
#include <utility>

#include "perimpm/error.hpp"
#include "plugin/library.hpp"
#include "plugin/search.hpp"

namespace perimpm {
namespace {

/// The one global object. Libraries in it are never closed: objects whose code they hold may outlive any owner.
struct Registry {
    std::mutex mutex;
    std::map<std::pair<Family, std::string>, Plugin> plugins;  ///< a map, so that references stay valid
    std::map<std::string, void*> modules;                      ///< handles by name
    ScriptOpener open_script = nullptr;
};

Registry& registry() {
    static Registry* const instance = new Registry;  // never destroyed: plugins may be used by other static objects
    return *instance;
}

std::string find_or_explain(Family family, const std::string& name) {
    if (const auto file = find_plugin(family, name)) return best_variant(*file);
    std::vector<std::string> names;
    for (const PluginFile& plugin : installed(family)) names.push_back(plugin.name);
    const char* path = std::getenv("PERIMPM_PLUGIN_PATH");
    throw InputError{fmt::format(
        "no {} plugin '{}' is installed\n  {}\n  plugins of your own: in PERIMPM_PLUGIN_PATH, {}", family_name(family),
        name, suggestion(name, names), path ? fmt::format("now '{}'", path) : "which is not set")};
}

Plugin load_script(const std::string& name, const std::string& file) {
    if (!registry().open_script)
        throw InputError{file,
                         "this law is a Python class, and there is no Python in this program\n  use the command "
                         "perimpm, or import perimpm"};
    std::shared_ptr<const ScriptedLaw> law = registry().open_script(file);
    const PluginDescriptor* descriptor = &law->descriptor;
    return {name, file, descriptor, std::move(law)};
}

Plugin load(Family family, const std::string& name) {
    const std::string file = find_or_explain(family, name);
    if (is_script(file)) return load_script(name, file);
    Library library = open_library(file);
    const auto* stamp = static_cast<const AbiStamp*>(find_symbol(library, "perimpm_abi_stamp"));
    if (!stamp) {
        throw InputError{file,
                         "not a perimpm plugin: it has no ABI stamp ('perimpm_abi_stamp')\n  build it with "
                         "perimpm_add_plugin() and publish the model with PERIMPM_PLUGIN"};
    }
    check_stamp(*stamp, file);
    const auto* descriptor = static_cast<const PluginDescriptor*>(find_symbol(library, "perimpm_plugin_descriptor"));
    if (!descriptor)
        throw InputError{file, "the plugin has no 'perimpm_plugin_descriptor'; publish it with PERIMPM_PLUGIN"};
    if (descriptor->family != family) {
        throw InputError{file, fmt::format("this is a {} plugin, but a {} plugin is needed here",
                                           family_name(descriptor->family), family_name(family))};
    }
    library.release();
    return {name, file, descriptor, nullptr};
}

void* load_module(const std::string& name) {
    const std::string file = fmt::format("{}/perimpm_{}.so", library_folder(), name);
    if (!std::filesystem::is_regular_file(file)) {
        throw InputError{file, fmt::format("this perimpm was built without its module '{}'", name)};
    }
    return open_library(file).release();
}

}  // namespace

const char* family_name(Family family) {
    switch (family) {
        case Family::transfer:
            return "transfer";
        case Family::constitutive:
            return "constitutive";
        case Family::fracture:
            return "fracture";
    }
    return "unknown";
}

const Plugin& open_plugin(Family family, const std::string& name) {
    Registry& r = registry();
    const std::pair key{family, name};
    {
        const std::lock_guard lock{r.mutex};
        if (const auto found = r.plugins.find(key); found != r.plugins.end()) return found->second;
    }
    Plugin opened = load(family, name);  // without the lock: a script may open plugins itself
    const std::lock_guard lock{r.mutex};
    return r.plugins.try_emplace(key, std::move(opened)).first->second;  // `opened` outlives the lock
}

void set_script_opener(ScriptOpener opener) { registry().open_script = opener; }

std::vector<std::string> opened_plugins() {
    Registry& r = registry();
    const std::lock_guard lock{r.mutex};
    std::vector<std::string> names;
    for (const auto& [key, plugin] : r.plugins)
        names.push_back(fmt::format("{}/{}", family_name(key.first), key.second));
    for (const auto& [name, handle] : r.modules) names.push_back("module/" + name);
    std::sort(names.begin(), names.end());
    return names;
}

std::string library_folder() {
    Dl_info info;
    if (dladdr(reinterpret_cast<const void*>(&library_folder), &info) == 0) {
        throw InputError{"the system cannot tell where the perimpm library was loaded from"};
    }
    return std::filesystem::canonical(info.dli_fname).parent_path();
}

void* open_module(const std::string& name, const char* symbol) {
    Registry& r = registry();
    const std::lock_guard lock{r.mutex};
    auto found = r.modules.find(name);
    if (found == r.modules.end()) found = r.modules.emplace(name, load_module(name)).first;
    void* address = dlsym(found->second, symbol);
    if (!address) throw InputError{fmt::format("the module '{}' of perimpm lacks the symbol '{}'", name, symbol)};
    return address;
}

}  // namespace perimpm
