#include <difusa/bake/names.h>

#include <difusa/plugin/parameters.h>

#include <algorithm>

namespace difusa {

std::string unknown_name(const std::string& what, const std::string& name, const std::vector<std::string>& all) {
    std::vector<std::string> known; // each once
    for (const std::string& each : all) {
        if (std::find(known.begin(), known.end(), each) == known.end()) {
            known.push_back(each);
        }
    }
    const std::string near = nearest_name(name, known);
    std::string text = "there is no " + what + " `" + name + "`" + (near.empty() ? "" : ", did you mean " + near + "?");
    constexpr std::size_t most = 20;
    for (std::size_t i = 0; i < std::min(known.size(), most); ++i) {
        text += (i == 0 ? (near.empty() ? ". There are: " : " There are: ") : ", ") + known[i];
    }
    return text + (known.size() > most ? ", ..." : "");
}

std::vector<std::string> names_of_materials_in_use(const Scene& scene) {
    const std::vector<char> used = scene.used_materials();
    std::vector<std::string> names;
    for (std::size_t m = 0; m < used.size(); ++m) {
        if (used[m] != 0) {
            names.push_back(scene.materials[m].name);
        }
    }
    return names;
}

} // namespace difusa
