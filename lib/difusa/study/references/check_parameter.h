// What a reference refuses to compute.
#pragma once

#include <difusa/core/error.h>

#include <string>

namespace difusa {

/// Throws UsageError("REFERENCE: WHAT, not VALUE") unless it holds.
inline void check_parameter(const char* reference, bool holds, const char* what, double value) {
    if (!holds) {
        throw UsageError(std::string(reference) + ": " + what + ", not " + std::to_string(value));
    }
}

} // namespace difusa
