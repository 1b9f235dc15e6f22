#pragma once

#include <string>

#include "perimpm/error.hpp"

/// Text of the InputError that the action throws.
template <class Action>
std::string message_of(Action&& action) {
    try {
        action();
    } catch (const perimpm::InputError& e) {
        return e.what();
    }
    return "(no InputError)";
}

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }
