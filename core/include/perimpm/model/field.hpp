#pragma once

#include <cstddef>
#include <cstdint>

namespace perimpm {

/// View of one field, components apart (SoA): component c of entry i is data[c * stride + i]. Null when not allocated.
template <class T>
struct Field {
    T* data = nullptr;
    std::size_t stride = 0;

    T* operator[](std::size_t component) const { return data + component * stride; }
    explicit operator bool() const { return data != nullptr; }
    Field from(std::size_t first) const { return {data ? data + first : nullptr, stride}; }
    operator Field<const T>() const { return {data, stride}; }
};

/// Declaration of a history field, per particle or per bond. Core allocates, reorders, saves and shows it.
struct FieldSpec {
    const char* name;
    std::uint32_t components = 1;
    const char* unit = "1";
    double initial = 0.0;
    const char* doc = "";
    /// Bond laws: entries side by side, so that a neighbour's quads cost one load each: numbers from one entry to the
    /// next, a multiple of 4. What lies beyond `components` is the law's own.
    std::uint32_t packed = 0;
};

/// A list of declarations with static lifetime.
struct FieldSpecs {
    const FieldSpec* data = nullptr;
    std::uint32_t size = 0;

    constexpr FieldSpecs() = default;
    template <std::size_t N>
    constexpr FieldSpecs(const FieldSpec (&specs)[N]) : data{specs}, size{static_cast<std::uint32_t>(N)} {}
};

}  // namespace perimpm
