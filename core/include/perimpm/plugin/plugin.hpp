#pragma once

#include <cstdint>
#include <iterator>

#include "perimpm/error.hpp"
#include "perimpm/model/constitutive_law.hpp"
#include "perimpm/model/fracture_criterion.hpp"
#include "perimpm/model/params.hpp"
#include "perimpm/model/transfer_kernel.hpp"

namespace perimpm {

enum class Family : std::uint32_t { transfer, constitutive, fracture };

/// A plugin's table of contents. Objects are created and destroyed by the library that holds their code.
struct PluginDescriptor {
    Family family;
    const char* summary;
    const ParamSpec* params;
    std::uint32_t param_count;
    void* (*create_float)(const Params&);
    void* (*create_double)(const Params&);
    void (*destroy_float)(void*);
    void (*destroy_double)(void*);
};

/// A struct that crosses the border between core and a plugin; those that lie inside one of the list are not listed.
struct CrossingStruct {
    const char* name;
    std::uint32_t size;
};

inline constexpr CrossingStruct kCrossingStructs[] = {
    {"Block<float>", sizeof(Block<float>)},
    {"Block<double>", sizeof(Block<double>)},
    {"Slice", sizeof(Slice)},
    {"LatticeRow", sizeof(LatticeRow)},
    {"RowNeighbour<float>", sizeof(RowNeighbour<float>)},
    {"TransferBlock<float>", sizeof(TransferBlock<float>)},
    {"TransferBlock<double>", sizeof(TransferBlock<double>)},
    {"LawNeeds", sizeof(LawNeeds)},
    {"TransferNeeds", sizeof(TransferNeeds)},
    {"FieldSpec", sizeof(FieldSpec)},
    {"ParamSpec", sizeof(ParamSpec)},
    {"ParamValue", sizeof(ParamValue)},
    {"ModelChoice", sizeof(ModelChoice)},
    {"Params", sizeof(Params)},
    {"ModelContext", sizeof(ModelContext)},
    {"BondCandidate", sizeof(BondCandidate)},
    {"CandidateList", sizeof(CandidateList)},
    {"PluginDescriptor", sizeof(PluginDescriptor)},
};

/// Everything that must agree before a C++ object may cross the border between core and a plugin.
/// Plain data, read before any code of the plugin is called by core.
struct AbiStamp {
    char magic[8];
    std::uint32_t interface_version;
    std::uint32_t compiler;                             ///< major version, in thousands for clang
    std::uint32_t standard_library;                     ///< its ABI version
    std::uint32_t layout[std::size(kCrossingStructs)];  ///< their sizes

    friend constexpr bool operator==(const AbiStamp&, const AbiStamp&) = default;
};

/// Grows with every change of what crosses the border that no struct's size shows: virtual functions, meanings.
inline constexpr std::uint32_t kInterfaceVersion = 12;

constexpr AbiStamp abi_stamp() {
#if defined(__clang__)
    constexpr std::uint32_t compiler = 1000 * __clang_major__;
#else
    constexpr std::uint32_t compiler = __GNUC__;
#endif
#if defined(_GLIBCXX_RELEASE)
    constexpr std::uint32_t library = 10 * _GLIBCXX_RELEASE + _GLIBCXX_USE_CXX11_ABI;
#else
    constexpr std::uint32_t library = 0;
#endif
    AbiStamp stamp{{'p', 'e', 'r', 'i', 'm', 'p', 'm', '\0'}, kInterfaceVersion, compiler, library, {}};
    for (std::size_t i = 0; i < std::size(kCrossingStructs); ++i) stamp.layout[i] = kCrossingStructs[i].size;
    return stamp;
}

namespace detail {
template <template <class> class Interface>
struct FamilyOf;
template <>
struct FamilyOf<TransferKernel> {
    static constexpr Family value = Family::transfer;
};
template <>
struct FamilyOf<ConstitutiveLaw> {
    static constexpr Family value = Family::constitutive;
};
template <>
struct FamilyOf<FractureCriterion> {
    static constexpr Family value = Family::fracture;
};

template <template <class> class Interface, template <class> class Model, class Real>
void* create(const Params& params) {
    return static_cast<Interface<Real>*>(new Model<Real>(params));
}
template <template <class> class Interface, class Real>
void destroy(void* model) {
    delete static_cast<Interface<Real>*>(model);
}
}  // namespace detail

}  // namespace perimpm

#define PERIMPM_PLUGIN_DESCRIPTOR(interface, model, table, count, text)           \
    extern "C" {                                                                  \
    PERIMPM_API extern const perimpm::AbiStamp perimpm_abi_stamp;                 \
    PERIMPM_API extern const perimpm::PluginDescriptor perimpm_plugin_descriptor; \
    const perimpm::AbiStamp perimpm_abi_stamp = perimpm::abi_stamp();             \
    const perimpm::PluginDescriptor perimpm_plugin_descriptor = {                 \
        perimpm::detail::FamilyOf<perimpm::interface>::value,                     \
        text,                                                                     \
        table,                                                                    \
        count,                                                                    \
        &perimpm::detail::create<perimpm::interface, model, float>,               \
        &perimpm::detail::create<perimpm::interface, model, double>,              \
        &perimpm::detail::destroy<perimpm::interface, float>,                     \
        &perimpm::detail::destroy<perimpm::interface, double>};                   \
    }

/// Publishes `model`, a class template over the precision, under the name of its file.
/// interface: ConstitutiveLaw, TransferKernel or FractureCriterion; table: array of ParamSpec; text: one line.
#define PERIMPM_PLUGIN(interface, model, table, text) \
    PERIMPM_PLUGIN_DESCRIPTOR(interface, model, table, sizeof(table) / sizeof(table[0]), text)

/// The same for a model without parameters.
#define PERIMPM_PLUGIN_WITHOUT_PARAMS(interface, model, text) \
    PERIMPM_PLUGIN_DESCRIPTOR(interface, model, nullptr, 0, text)
