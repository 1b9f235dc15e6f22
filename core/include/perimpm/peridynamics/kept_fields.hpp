#pragma once

#include <algorithm>
#include <list>
#include <mutex>
#include <string_view>
#include <vector>

#include "perimpm/model/field.hpp"

namespace perimpm::peridynamics {

/// The same declarations with static lifetime; one copy for all laws of a process that declare the same.
inline FieldSpecs kept(const std::vector<FieldSpec>& fields) {
    static std::mutex mutex;
    static std::list<std::vector<FieldSpec>> lists;
    const std::scoped_lock lock(mutex);
    const auto same = [&](const std::vector<FieldSpec>& other) {
        return std::equal(fields.begin(), fields.end(), other.begin(), other.end(), [](const auto& a, const auto& b) {
            return std::string_view(a.name) == b.name && std::string_view(a.unit) == b.unit;
        });
    };
    auto found = std::find_if(lists.begin(), lists.end(), same);
    if (found == lists.end()) found = lists.insert(lists.end(), fields);
    FieldSpecs specs;
    specs.data = found->data();
    specs.size = static_cast<std::uint32_t>(found->size());
    return specs;
}

}  // namespace perimpm::peridynamics
