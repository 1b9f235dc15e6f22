#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <vector>

#include "perimpm/model/field.hpp"

namespace perimpm {

/// Zero-initialised numbers on a 64-byte boundary; not resizable in place, cheap to move.
template <class T>
class AlignedArray {
public:
    AlignedArray() = default;
    /// `padding`: zeros past the end that may be read.
    explicit AlignedArray(std::size_t size, std::size_t padding = 0) : size_{size} {
        if (size + padding == 0) return;
        const std::size_t bytes = (size + padding) * sizeof(T);
        data_.reset(static_cast<T*>(::operator new(bytes, kAlignment)));
        std::memset(static_cast<void*>(data_.get()), 0, bytes);
    }
    T* data() { return data_.get(); }
    const T* data() const { return data_.get(); }
    std::size_t size() const { return size_; }
    std::size_t bytes() const { return size_ * sizeof(T); }
    bool empty() const { return size_ == 0; }
    T& operator[](std::size_t i) { return data_.get()[i]; }
    const T& operator[](std::size_t i) const { return data_.get()[i]; }

private:
    static constexpr std::align_val_t kAlignment{64};
    struct Delete {
        void operator()(T* p) const { ::operator delete(static_cast<void*>(p), kAlignment); }
    };
    std::unique_ptr<T, Delete> data_;
    std::size_t size_ = 0;
};

template <class T>
AlignedArray<T> aligned(const std::vector<T>& items) {
    AlignedArray<T> array(items.size());
    std::copy_n(items.data(), items.size(), array.data());
    return array;
}

/// One field's storage: components apart, each on a 64-byte boundary, without holes between entries; or packed, the
/// entries side by side in whole quads.
template <class T>
class FieldArray {
public:
    FieldArray() = default;
    FieldArray(std::size_t entries, std::size_t components)
        : stride_{(entries + kPad - 1) / kPad * kPad}, components_{components}, values_(stride_ * components) {}
    static FieldArray of(const FieldSpec& spec, std::size_t entries) {
        FieldArray f;
        if (spec.packed) {
            f.stride_ = 1, f.entry_ = spec.packed, f.components_ = spec.components;
            f.values_ = AlignedArray<T>(entries * spec.packed);
        } else {
            f = FieldArray(entries, spec.components);
        }
        std::fill_n(f.values_.data(), f.values_.size(), static_cast<T>(spec.initial));
        return f;
    }
    Field<T> view() { return {values_.data(), stride_}; }
    Field<const T> view() const { return {values_.data(), stride_}; }
    /// The view that starts at entry `first`.
    Field<T> from(std::size_t first) { return {values_.data() + first * entry_, stride_}; }
    T* operator[](std::size_t component) { return values_.data() + component * stride_; }
    const T* operator[](std::size_t component) const { return values_.data() + component * stride_; }
    std::size_t components() const { return components_; }
    std::size_t entry() const { return entry_; }
    std::size_t bytes() const { return values_.bytes(); }
    bool empty() const { return values_.empty(); }

private:
    static constexpr std::size_t kPad = 64 / sizeof(T);
    std::size_t stride_ = 0;  ///< between the components of an entry
    std::size_t entry_ = 1;   ///< between entries
    std::size_t components_ = 0;
    AlignedArray<T> values_;
};

}  // namespace perimpm
