// The plugins beside the library, for tests that go through all of a kind: a new plugin is tested without a word more.
#pragma once

#include <difusa/plugin/registry.h>

#include <memory>
#include <string>
#include <vector>

namespace difusa::test {

inline const Registry& registry() {
    static const Registry all = Registry::load();
    return all;
}

/// The plugin "name" or "name:parameter=value,...".
template <class T> std::shared_ptr<T> plugin(const std::string& choice) {
    return registry().create<T>(choice);
}

template <class T> std::vector<std::string> plugin_names() {
    return registry().names(kind_of<T>());
}

} // namespace difusa::test
