#include <difusa/rays/visibility_choice.h>

#include <difusa/rays/visibility.h>

#include <algorithm>

namespace difusa {

std::string choose_visibility(const Registry& registry, std::string_view choice, std::vector<std::string>& notes) {
    constexpr std::string_view kind = kind_of<Visibility>();
    if (choice != "auto") {
        try {
            registry.describe(kind, choice);
        } catch (const UsageError& error) {
            throw UsageError(std::string(error.what()) + "; auto takes the first that starts");
        }
        return std::string(choice);
    }
    std::vector<std::string> names = registry.names(kind);
    const auto rank = [](const std::string& name) {
        return std::find(preferred_visibility.begin(), preferred_visibility.end(), name) - preferred_visibility.begin();
    };
    std::stable_sort(names.begin(), names.end(),
                     [&](const std::string& a, const std::string& b) { return rank(a) < rank(b); });
    std::vector<std::string> failures;
    for (const std::string& name : names) {
        try {
            registry.create<Visibility>(name);
            for (const std::string& failure : failures) {
                notes.push_back("visibility " + name + " is used instead of " + failure);
            }
            return name;
        } catch (const Error& error) {
            failures.push_back(name + ": " + error.what());
        }
    }
    std::string message = "--visibility auto: no engine ";
    if (failures.empty()) {
        throw UsageError(message + "was found in any plugin directory");
    }
    message += "starts";
    for (const std::string& failure : failures) {
        message += "; " + failure;
    }
    throw ResourceError(message);
}

} // namespace difusa
