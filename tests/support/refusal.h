// For tests of what is refused.
#pragma once

#include <difusa/core/error.h>

#include <gtest/gtest.h>

#include <string>

namespace difusa::test {

/// The message of the InputError that `act` throws; otherwise the test has failed. `what`: the input, for that.
template <class Act> std::string refusal_of(const Act& act, const std::string& what) {
    try {
        act();
    } catch (const InputError& error) {
        return error.what();
    }
    ADD_FAILURE() << "accepted: " << what;
    return "";
}

} // namespace difusa::test
