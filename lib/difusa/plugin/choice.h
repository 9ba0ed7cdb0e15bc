// A choice between a few built-in methods, written like a plugin: "name" or "name:parameter=value,...".
#pragma once

#include <difusa/plugin/parameters.h>

#include <string>
#include <string_view>
#include <vector>

namespace difusa {

struct Choice {
    std::string name;
    Parameters parameters;

    /// "name:all=parameters" with defaults filled in.
    std::string text() const;
};

/// One of the available methods.
struct ChoiceSpec {
    std::string name;
    std::vector<ParameterSpec> parameters;
};

/// Throws UsageError: "--`option` `text`: must be one of" all names, with the nearest one, or a wrong parameter.
Choice parse_choice(std::string_view option, std::string_view text, const std::vector<ChoiceSpec>& known);

} // namespace difusa
