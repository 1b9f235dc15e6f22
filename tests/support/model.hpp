#pragma once

#include <string>

#include "perimpm/plugin/registry.hpp"
#include "perimpm/scene/reader.hpp"

/// A model made from the text of its table, as a scene makes it: defaults filled in, keys and ranges judged.
/// E.g. make<perimpm::ConstitutiveLaw, double>("fixed_corotated", "youngs_modulus = 1e6").
template <template <class> class Interface, class Real>
perimpm::ModelPtr<Interface, Real> make(const std::string& name, const std::string& table = "",
                                        const perimpm::ModelContext& context = {}) {
    const auto& plugin = *perimpm::open_plugin(perimpm::detail::FamilyOf<Interface>::value, name).descriptor;
    const perimpm::Value values = perimpm::parse_scene_text(table, name);
    const perimpm::Reader reader(values, {plugin.params, plugin.param_count}, name);
    return perimpm::create<Interface, Real>(
        name, perimpm::Params(plugin.params, reader.values().data(), plugin.param_count, context));
}
