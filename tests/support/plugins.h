// The plugins beside the library, for tests that go through all of a kind: a new plugin is tested without a word more.
#pragma once

#include <difusa/discretisation/basis.h>
#include <difusa/plugin/registry.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace difusa::test {

inline const Registry& registry() {
    static const Registry all = Registry::load();
    return all;
}

/// The module made of tests/plugins/`name`.cpp.
inline std::filesystem::path test_module(const std::string& name) {
    const char* directory = std::getenv("DIFUSA_TEST_PLUGINS"); // NOLINT(concurrency-mt-unsafe): nobody sets it
    return std::filesystem::path(directory != nullptr ? directory : DIFUSA_TEST_PLUGINS) / (name + ".so");
}

/// The plugin "name" or "name:parameter=value,...".
template <class T> std::shared_ptr<T> plugin(const std::string& choice) {
    return registry().create<T>(choice);
}

template <class T> std::vector<std::string> plugin_names() {
    return registry().names(kind_of<T>());
}

/// Only those that any sites will do for; the others are tested in unit/patch_bases_test.cpp, on their own.
template <> inline std::vector<std::string> plugin_names<Basis>() {
    std::vector<std::string> names = registry().names(kind_of<Basis>());
    std::erase_if(names, [](const std::string& name) { return !plugin<Basis>(name)->sampler().empty(); });
    return names;
}

} // namespace difusa::test
