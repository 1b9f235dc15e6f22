#include "plugin/library.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <cstring>
#include <string_view>

#include "perimpm/error.hpp"

namespace perimpm {
namespace {

void require_equal(std::uint32_t found, std::uint32_t expected, std::string_view entry, const std::string& file) {
    if (found == expected) return;
    throw InputError{file, fmt::format("built for another perimpm: {} is {}, but this perimpm has {}\n  rebuild the "
                                       "plugin against this perimpm, with the same compiler",
                                       entry, found, expected)};
}

}  // namespace

void CloseLibrary::operator()(void* handle) const { dlclose(handle); }

Library open_library(const std::string& file) {
    Library library{dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)};
    if (!library) throw InputError{file, fmt::format("the library does not load: {}", dlerror())};
    return library;
}

const void* find_symbol(const Library& library, const char* symbol) { return dlsym(library.get(), symbol); }

void check_stamp(const AbiStamp& found, const std::string& file) {
    constexpr AbiStamp expected = abi_stamp();
    if (std::memcmp(found.magic, expected.magic, sizeof expected.magic) != 0) {
        throw InputError{file,
                         "not a perimpm plugin: its ABI stamp does not start with 'perimpm' (magic)\n  rebuild the "
                         "plugin against this perimpm with perimpm_add_plugin()"};
    }
    require_equal(found.interface_version, expected.interface_version, "interface version", file);
    require_equal(found.compiler, expected.compiler, "compiler (major version)", file);
    require_equal(found.standard_library, expected.standard_library, "standard library (ABI)", file);
    for (std::size_t i = 0; i < std::size(kCrossingStructs); ++i)
        require_equal(found.layout[i], kCrossingStructs[i].size,
                      fmt::format("layout (size) of {}", kCrossingStructs[i].name), file);
}

}  // namespace perimpm
