#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "perimpm/export.hpp"

namespace perimpm {

/// Anything wrong with what the user gave: a scene, a file, a plugin, an argument. Exit code 2.
class PERIMPM_API InputError : public std::runtime_error {
public:
    /// place: "file:line:column", a dotted path or a file name; may be empty.
    InputError(const std::string& place, const std::string& message);
    explicit InputError(const std::string& message) : InputError("", message) {}
    ~InputError() override;
};

/// A model's constructor refuses a parameter; the caller adds the place where the scene gives it.
class PERIMPM_API InvalidParameter : public std::runtime_error {
public:
    InvalidParameter(std::string key, const std::string& message);
    ~InvalidParameter() override;
    const std::string& key() const noexcept { return key_; }

private:
    std::string key_;
};

/// The simulation itself failed: a NaN, a particle that left the domain. Exit code 3.
class PERIMPM_API SimulationError : public std::runtime_error {
public:
    explicit SimulationError(const std::string& message);
    ~SimulationError() override;
};

/// The entry of `accepted` nearest to `word`, or "" when none is near enough to be meant: Damerau-Levenshtein distance
/// at most a third of the word's length (but at least 1 is allowed).
PERIMPM_API std::string nearest(const std::string& word, const std::vector<std::string>& accepted);

/// "did you mean 'x'?   accepted: a, b, c" for error messages; the question only when something is near.
/// shown: what to print for `accepted`, e.g. with units; empty: the words themselves.
PERIMPM_API std::string suggestion(const std::string& word, const std::vector<std::string>& accepted,
                                   const std::vector<std::string>& shown = {});

}  // namespace perimpm
