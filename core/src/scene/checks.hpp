#pragma once

#include <string>
#include <vector>

#include "perimpm/model/params.hpp"
#include "perimpm/scene/tree.hpp"

namespace perimpm {

/// " [Pa]", or "" for dimensionless keys and keys without a number.
std::string unit_note(const ParamSpec& spec);

/// Whether a key that is absent has a value all the same.
bool has_default(const ParamSpec& spec);

/// "a|b|c" as a list.
std::vector<std::string> split_choices(const char* choices);

/// Whether a text is a number in quotes.
bool reads_as_number(const std::string& text);

/// Throws InputError: the key must be of the declared kind, and what it is instead.
[[noreturn]] void refuse_kind(const Value& value, const ParamSpec& spec, const std::string& what);

/// A finite integer or number.
double require_number(const Value& value, const ParamSpec& spec, const std::string& what);

/// Throws InputError with the allowed range and its unit.
void check_range(double number, const Place& place, const ParamSpec& spec, const std::string& what);

}  // namespace perimpm
