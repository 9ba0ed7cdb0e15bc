// Finds plugin modules, checks them before any of their code runs, and makes instances by name.
#pragma once

#include <difusa/core/error.h>
#include <difusa/plugin/plugin.h>

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

/// A module that was found but cannot be used.
struct RefusedPlugin {
    std::filesystem::path file;
    std::string reason;
    std::string kind, name; ///< from its tag; empty if it has no readable one
};

/// One usable plugin. Its module stays mapped until the process ends: an exception thrown by its code may be inspected
/// after the last object and the registry are gone.
struct LoadedPlugin {
    PluginDescription description;
    std::filesystem::path file;
};

/// The plugins a program can choose from. A plain value: no global state.
class Registry {
  public:
    /// Where modules are searched for, in this order: `extra` (from --plugin-path), the directories of the environment
    /// variable DIFUSA_PLUGIN_PATH, and the directory `difusa/plugins` next to the difusa library.
    static std::vector<std::filesystem::path> search_path(const std::vector<std::filesystem::path>& extra);

    /// Loads every module (`*.so`) in the directories, in the order of the path, then of file names. One that is
    /// damaged, of another kind, version or build, or has a duplicate name is recorded in `refused` and skipped; so is
    /// a directory of DIFUSA_PLUGIN_PATH that cannot be listed.
    /// Throws UsageError if a directory of `extra` does not exist or cannot be listed, or if the program that calls it
    /// was compiled so that its types differ from the library's (plugin/build_tag.h), as with -mavx: `build` is to be
    /// omitted.
    static Registry load(const std::vector<std::filesystem::path>& extra = {},
                         std::string_view build = DIFUSA_BUILD_TAG);

    /// Loads one module into the registry or records why not; returns true if it is usable.
    bool add(const std::filesystem::path& module_file);

    const std::vector<LoadedPlugin>& plugins() const { return plugins_; }
    const std::vector<RefusedPlugin>& refused() const { return refused_; }

    /// The modules of all of them.
    std::vector<std::filesystem::path> files() const;

    /// Makes the plugin `choice` = "name" or "name:parameter=value,...". '-' and '_' in names are equal.
    /// T is the interface, for example Basis.
    /// Throws UsageError for an unknown name (with the nearest one, and why a module of that name was refused)
    /// or a wrong parameter; InternalError, with the name and file of the plugin, if it fails with anything but an
    /// Error.
    template <class T> std::shared_ptr<T> create(std::string_view choice) const;

    /// The plugin of a kind by name, or null.
    const LoadedPlugin* find(std::string_view kind, std::string_view name) const;

    /// All names of a kind, sorted.
    std::vector<std::string> names(std::string_view kind) const;

    /// "name:all=parameters" with defaults filled in, as stated in reports.
    std::string describe(std::string_view kind, std::string_view choice) const;

  private:
    struct Choice {
        const LoadedPlugin* plugin;
        Parameters parameters;
    };
    static void* created(const Choice& choice);
    Choice choose(std::string_view kind, std::string_view choice) const;
    std::vector<LoadedPlugin> plugins_;
    std::vector<RefusedPlugin> refused_;
};

/// The name of the kind for an interface: "basis" for Basis.
template <class T> constexpr std::string_view kind_of();
template <> constexpr std::string_view kind_of<Basis>() {
    return "basis";
}
template <> constexpr std::string_view kind_of<Directions>() {
    return "directions";
}
template <> constexpr std::string_view kind_of<Kernel>() {
    return "kernel";
}
template <> constexpr std::string_view kind_of<Reader>() {
    return "reader";
}
template <> constexpr std::string_view kind_of<Sampler>() {
    return "sampler";
}
template <> constexpr std::string_view kind_of<Solver>() {
    return "solver";
}
template <> constexpr std::string_view kind_of<Visibility>() {
    return "visibility";
}

template <class T> std::shared_ptr<T> Registry::create(std::string_view choice) const {
    const Choice chosen = choose(kind_of<T>(), choice);
    return std::shared_ptr<T>(static_cast<T*>(created(chosen)));
}

} // namespace difusa
