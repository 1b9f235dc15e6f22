#pragma once

#include <hdf5.h>

#include <string>
#include <utility>

#include "perimpm/error.hpp"

namespace perimpm::hdf5 {

/// The innermost message of the HDF5 error stack, e.g. "unable to open file: ... No space left on device".
std::string last_error();

/// Throws InputError for `file` when an HDF5 call reported failure (a negative number); else passes the value on.
template <class T>
T check(T value, const std::string& file, const char* doing) {
    if (value < 0) throw InputError(file, std::string("HDF5 cannot ") + doing + ": " + last_error());
    return value;
}

/// Owns one HDF5 identifier.
class Handle {
public:
    using Close = herr_t (*)(hid_t);
    Handle(hid_t id, Close close, const std::string& file, const char* doing)
        : id_{check(id, file, doing)}, close_{close} {}
    Handle(Handle&& other) noexcept : id_{std::exchange(other.id_, -1)}, close_{other.close_} {}
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    Handle& operator=(Handle&&) = delete;
    ~Handle() {
        if (id_ >= 0) close_(id_);
    }
    operator hid_t() const { return id_; }
    /// Closes now; the last flush of a file can fail, for want of room.
    void close(const std::string& file) { check(close_(std::exchange(id_, -1)), file, "finish the file"); }

private:
    hid_t id_;
    Close close_;
};

}  // namespace perimpm::hdf5
