#include "perimpm/model/params.hpp"

#include <cstring>
#include <stdexcept>
#include <string>

namespace perimpm {

const ParamValue& Params::at(const char* key) const {
    for (std::uint32_t i = 0; i < count_; ++i) {
        if (std::strcmp(specs_[i].key, key) == 0) return values_[i];
    }
    throw std::logic_error{std::string{"the model reads the parameter '"} + key +
                           "', which its table does not declare"};
}

bool Params::is(const char* key, const char* value) const {
    const char* text = at(key).text;
    return text && std::strcmp(text, value) == 0;
}

}  // namespace perimpm
