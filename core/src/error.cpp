#include "perimpm/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace perimpm {
namespace {

/// Damerau-Levenshtein distance with adjacent transpositions ("optimal string alignment").
std::size_t edit_distance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> before(b.size() + 1), above(b.size() + 1), row(b.size() + 1);
    std::iota(above.begin(), above.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replace = above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            row[j] = std::min({replace, above[j] + 1, row[j - 1] + 1});
            const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
        }
        std::swap(before, above);
        std::swap(above, row);
    }
    return above[b.size()];
}

}  // namespace

InputError::InputError(const std::string& place, const std::string& message)
    : std::runtime_error{place.empty() ? message : place + ": error: " + message} {}
InputError::~InputError() = default;

InvalidParameter::InvalidParameter(std::string key, const std::string& message)
    : std::runtime_error{message}, key_{std::move(key)} {}
InvalidParameter::~InvalidParameter() = default;

SimulationError::SimulationError(const std::string& message) : std::runtime_error{message} {}
SimulationError::~SimulationError() = default;

std::string nearest(const std::string& word, const std::vector<std::string>& accepted) {
    std::string best;
    std::size_t allowed = std::max<std::size_t>(1, word.size() / 3);
    for (const std::string& candidate : accepted) {
        const std::size_t distance = edit_distance(word, candidate);
        if (distance > allowed || (distance == allowed && !best.empty())) continue;
        allowed = distance;
        best = candidate;
    }
    return best;
}

std::string suggestion(const std::string& word, const std::vector<std::string>& accepted,
                       const std::vector<std::string>& shown) {
    const std::string near = nearest(word, accepted);
    const std::string question = near.empty() ? "" : fmt::format("did you mean '{}'?   ", near);
    if (accepted.empty()) return "accepted: nothing";
    return fmt::format("{}accepted: {}", question, fmt::join(shown.empty() ? accepted : shown, ", "));
}

}  // namespace perimpm
