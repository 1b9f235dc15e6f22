#pragma once

#include <memory>
#include <string>

#include "perimpm/plugin/plugin.hpp"

namespace perimpm {

struct CloseLibrary {
    void operator()(void* handle) const;
};
/// An open shared library; `release` keeps it open for good.
using Library = std::unique_ptr<void, CloseLibrary>;

/// Throws InputError with the system's reason.
Library open_library(const std::string& file);

/// Null when the library does not export the symbol.
const void* find_symbol(const Library& library, const char* symbol);

/// Compares the stamps entry by entry, oldest entries first, and throws InputError that names the first difference
/// and the remedy.
void check_stamp(const AbiStamp& found, const std::string& file);

}  // namespace perimpm
