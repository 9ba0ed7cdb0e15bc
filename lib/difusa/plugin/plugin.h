// The contents of a plugin module, and the macro that makes one.
//
// A plugin is a shared module that implements one choice of one kind. It has
//   - a tag: a line of text in the section `.difusa_plugin` of the file, which the loader reads from the file
//     itself, before any of the module's code runs: kind, name, interface version and build tags;
//   - the entry `difusa_plugin_entry`, which describes the plugin and makes instances.
//
// A complete plugin:
//
//     class Flat final : public difusa::PointBasis { ... };
//     DIFUSA_PLUGIN(basis, "flat", Flat, "Constant over the support.", {})
//
// where `Flat` has a constructor from `const difusa::Parameters&`, and the last argument is a
// `std::vector<difusa::ParameterSpec>`.
#pragma once

#include <difusa/plugin/build_tag.h>
#include <difusa/plugin/parameters.h>

#include <memory>
#include <string>
#include <vector>

namespace difusa {

class Basis;
class Directions;
class Kernel;
class Reader;
class Sampler;
class Solver;
class Visibility;

/// What `--list-plugins` shows and the factory needs.
struct PluginDescription {
    std::string kind; ///< "basis", "directions", "kernel", "reader", "sampler", "solver", "visibility"
    std::string name; ///< as typed by the user
    std::string summary;
    std::vector<ParameterSpec> parameters;
    /// Makes an instance: a `T*` for the kind's interface T, owned by the caller and deleted through `T`'s virtual
    /// destructor.
    void* (*create)(const Parameters&) = nullptr;
};

namespace plugin_kind {
// Kind as written in the macro, and its interface.
using basis = Basis;
using directions = Directions;
using kernel = Kernel;
using reader = Reader;
using sampler = Sampler;
using solver = Solver;
using visibility = Visibility;
} // namespace plugin_kind

/// Every module exports `const PluginDescription* difusa_plugin_entry()` with C linkage.
using PluginEntry = const PluginDescription* (*)();

} // namespace difusa

/// Defines the one plugin of a module. `kind_` is a bare word from `plugin_kind`; `name_` is a string of lower-case
/// letters, digits and '-'.
#define DIFUSA_PLUGIN(kind_, name_, class_, summary_, ...)                                                             \
    namespace {                                                                                                        \
    __attribute__((used, retain, section(".difusa_plugin"))) const char difusa_plugin_tag[] =                          \
        "difusa-plugin;kind=" #kind_ ";name=" name_ ";" DIFUSA_BUILD_TAG;                                              \
    }                                                                                                                  \
    extern "C" __attribute__((visibility("default"))) const difusa::PluginDescription* difusa_plugin_entry();          \
    extern "C" const difusa::PluginDescription* difusa_plugin_entry() {                                                \
        static const difusa::PluginDescription description{                                                            \
            #kind_, name_, summary_, __VA_ARGS__, [](const difusa::Parameters& parameters) -> void* {                  \
                return static_cast<difusa::plugin_kind::kind_*>(new class_(parameters));                               \
            }};                                                                                                        \
        return &description;                                                                                           \
    }
