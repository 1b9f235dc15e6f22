#include "handle.hpp"

namespace perimpm::hdf5 {

std::string last_error() {
    std::string text = "unknown reason";
    const auto keep = [](unsigned n, const H5E_error2_t* error, void* out) -> herr_t {
        if (n == 0) *static_cast<std::string*>(out) = error->desc;
        return 0;
    };
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep, &text);
    return text;
}

}  // namespace perimpm::hdf5
