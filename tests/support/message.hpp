#pragma once

#include <string>

#include "perimpm/error.hpp"

/// Text of the error that the action throws; "(no error)" without one.
template <class Error = perimpm::InputError, class Action>
std::string message_of(Action&& action) {
    try {
        action();
    } catch (const Error& e) {
        return e.what();
    }
    return "(no error)";
}

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }
