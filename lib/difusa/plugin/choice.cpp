#include <difusa/plugin/choice.h>

#include <difusa/core/error.h>

#include <algorithm>

namespace difusa {

std::string Choice::text() const {
    const std::string all = parameters.text();
    return name + (all.empty() ? "" : ":" + all);
}

Choice parse_choice(std::string_view option, std::string_view text, const std::vector<ChoiceSpec>& known) {
    const std::size_t colon = text.find(':');
    std::string name(text.substr(0, colon));
    std::replace(name.begin(), name.end(), '_', '-');
    const auto found =
        std::find_if(known.begin(), known.end(), [&](const ChoiceSpec& spec) { return spec.name == name; });
    if (found == known.end()) {
        std::vector<std::string> names;
        std::string all;
        for (const ChoiceSpec& spec : known) {
            names.push_back(spec.name);
            all += (all.empty() ? "" : ", ") + spec.name;
        }
        const std::string near = nearest_name(name, names);
        throw UsageError("--" + std::string(option) + " " + name + ": must be one of " + all +
                         (near.empty() ? "" : "; did you mean " + near + "?"));
    }
    return {name, Parameters(colon == std::string_view::npos ? "" : text.substr(colon + 1), found->parameters,
                             std::string(option) + " " + name)};
}

} // namespace difusa
