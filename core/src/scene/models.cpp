#include "scene/models.hpp"

#include <fmt/format.h>

#include <string_view>
#include <utility>

#include "perimpm/error.hpp"
#include "plugin/search.hpp"
#include "scene/keys.hpp"

namespace perimpm {
namespace {

/// The reader keeps a pointer to its table, so both live and move together.
struct OwnedReader {
    Value table;
    Reader reader;

    OwnedReader(const Value& source, std::span<const ParamSpec> specs, const std::string& what)
        : table{source}, reader{table, specs, what, kType} {}

    static constexpr const char* kType[] = {"type"};
};

const Plugin& open_at(const Value& table, Family family, const std::string& name, const std::string& what) {
    check_plugin_path();  // not the scene's fault, so no place in it is named
    try {
        return open_plugin(family, name);
    } catch (const InputError& e) {
        throw InputError{table.find("type")->place.text(), fmt::format("{}: {}", what, e.what())};
    }
}

/// Asks a kernel made for the purpose; its constructor also judges what ranges alone cannot.
bool kernel_needs_grid(const ModelSpec& model, double grid_spacing) {
    const Reader& r = *model.params;
    const Params params{r.specs().data(),
                        r.values().data(),
                        static_cast<std::uint32_t>(r.specs().size()),
                        {.grid_spacing = grid_spacing}};
    try {
        return create<TransferKernel, double>(model.type, params)->needs().grid;
    } catch (const InvalidParameter& e) {
        r.fail(e.key().c_str(), e.what());
    }
}

}  // namespace

ModelSpec read_model(const Value& table, Family family, const std::string& what) {
    const std::string type = read_type(table, what, {});
    const PluginDescriptor& descriptor = *open_at(table, family, type, what).descriptor;
    const auto owned = std::make_shared<const OwnedReader>(table, std::span{descriptor.params, descriptor.param_count},
                                                           fmt::format("{} ('{}')", what, type));
    return {type, {owned, &owned->reader}, table};
}

ModelSpec read_transfer(const Value& table, double grid_spacing, bool& needs_grid) {
    ModelSpec model = read_model(table, Family::transfer, "transfer");
    needs_grid = kernel_needs_grid(model, grid_spacing);
    return model;
}

}  // namespace perimpm
