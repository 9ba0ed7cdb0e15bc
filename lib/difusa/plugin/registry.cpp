#include <difusa/core/error.h>
#include <difusa/plugin/module_file.h>
#include <difusa/plugin/registry.h>

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <exception>
#include <new>

namespace difusa {

namespace fs = std::filesystem;

namespace {

constexpr std::array all_kinds = {kind_of<Basis>(),   kind_of<Directions>(), kind_of<Kernel>(),    kind_of<Reader>(),
                                  kind_of<Sampler>(), kind_of<Solver>(),     kind_of<Visibility>()};

bool same_name(std::string_view a, std::string_view b) {
    const auto same = [](char x, char y) { return x == y || ((x == '-' || x == '_') && (y == '-' || y == '_')); };
    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), same);
}

std::string join(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) {
        text += (text.empty() ? "" : ", ") + word;
    }
    return text;
}

/// Throws ModuleRefused unless the tag has an existing kind, and the interface and build tags of this library.
void check_tag(const ModuleTag& tag) {
    if (std::find(all_kinds.begin(), all_kinds.end(), tag.kind) == all_kinds.end()) {
        throw ModuleRefused("its kind '" + tag.kind + "' is not one of " +
                            join(std::vector<std::string>(all_kinds.begin(), all_kinds.end())));
    }
    const ModuleTag own = parse_module_tag("difusa-plugin;kind=any;name=own;" DIFUSA_BUILD_TAG);
    for (std::size_t i = 0; i < own.build.size(); ++i) {
        const auto& [what, expected] = own.build[i];
        const std::string found =
            i < tag.build.size() && tag.build[i].first == what ? tag.build[i].second : std::string("none");
        if (found != expected) {
            throw ModuleRefused("its " + what + " tag is " + found + ", expected " + expected +
                                ": rebuild it with this version of difusa and the same compiler options");
        }
    }
    if (tag.build.size() > own.build.size()) {
        throw ModuleRefused("it has an unexpected tag '" + tag.build[own.build.size()].first +
                            "': rebuild it with this version of difusa");
    }
}

/// The first line of the dynamic linker's message, without the file's name.
std::string linker_message(const fs::path& file) {
    const char* text = dlerror();
    std::string message = text != nullptr ? text : "unknown error";
    const std::string prefix = file.string() + ": ";
    return message.starts_with(prefix) ? message.substr(prefix.size()) : message;
}

/// Calls the module's entry. From here on its code runs. Throws ModuleRefused.
const PluginDescription* call_entry(const fs::path& file) {
    // Never unmapped (RTLD_NODELETE): see LoadedPlugin.
    void* const module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (module == nullptr) {
        throw ModuleRefused("the dynamic linker rejects it: " + linker_message(file));
    }
    void* const symbol = dlsym(module, "difusa_plugin_entry");
    if (symbol == nullptr) {
        throw ModuleRefused("it has a plugin tag but no entry difusa_plugin_entry");
    }
    try {
        return reinterpret_cast<PluginEntry>(symbol)();
    } catch (const std::exception& error) {
        throw ModuleRefused(std::string("its entry failed: ") + error.what());
    } catch (...) {
        throw ModuleRefused("its entry failed with an exception not derived from std::exception");
    }
}

/// The entry's description, if it matches the tag. Throws ModuleRefused.
PluginDescription describe_module(const fs::path& file, const ModuleTag& tag) {
    const PluginDescription* description = call_entry(file);
    if (description == nullptr || description->create == nullptr) {
        throw ModuleRefused("its entry describes nothing that can be instantiated");
    }
    if (description->kind != tag.kind || description->name != tag.name) {
        throw ModuleRefused("its entry describes " + description->kind + " '" + description->name +
                            "', but its tag says " + tag.kind + " '" + tag.name + "'");
    }
    try {
        Parameters({}, description->parameters, tag.kind + " " + tag.name);
    } catch (const Error& error) {
        throw ModuleRefused(std::string("its parameters are declared incorrectly: ") + error.what());
    }
    return *description;
}

std::vector<fs::path> environment_directories() {
    std::vector<fs::path> directories;
    const char* const variable = std::getenv("DIFUSA_PLUGIN_PATH");
    std::string_view rest = variable != nullptr ? variable : "";
    while (!rest.empty()) {
        const std::size_t colon = std::min(rest.find(':'), rest.size());
        if (colon > 0) {
            directories.emplace_back(rest.substr(0, colon));
        }
        rest.remove_prefix(std::min(colon + 1, rest.size()));
    }
    return directories;
}

/// The directory's entries `*.so`, sorted by name. Throws std::filesystem::filesystem_error.
std::vector<fs::path> modules_in(const fs::path& directory) {
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(directory)) {
        if (entry.path().extension() == ".so") {
            files.push_back(entry.path());
        }
    }
    std::sort(files.begin(), files.end());
    return files;
}

std::pair<std::string_view, std::string_view> split_choice(std::string_view choice) {
    const std::size_t colon = choice.find(':');
    return colon == std::string_view::npos ? std::pair{choice, std::string_view{}}
                                           : std::pair{choice.substr(0, colon), choice.substr(colon + 1)};
}

/// Whether a refused module is the one the user means: by its tag or, if that cannot be read, by its file's name.
bool carries_name(const RefusedPlugin& refused, std::string_view kind, std::string_view name) {
    if (!refused.name.empty()) {
        return refused.kind == kind && same_name(refused.name, name);
    }
    const std::string stem = refused.file.stem().string();
    return stem.size() >= name.size() && same_name(std::string_view(stem).substr(stem.size() - name.size()), name) &&
           (stem.size() == name.size() ||
            std::string_view("-_.").find(stem[stem.size() - name.size() - 1]) != std::string_view::npos);
}

} // namespace

std::vector<fs::path> Registry::search_path(const std::vector<fs::path>& extra) {
    std::vector<fs::path> path = extra;
    for (fs::path& directory : environment_directories()) {
        path.push_back(std::move(directory));
    }
    path.push_back(library_directory() / "difusa" / "plugins");
    return path;
}

Registry Registry::load(const std::vector<fs::path>& extra, std::string_view build) {
    if (build != DIFUSA_BUILD_TAG) {
        throw UsageError("this program was compiled with " + std::string(build) + ", but the difusa library with " +
                         DIFUSA_BUILD_TAG + ", so that their types differ in memory: compile both with the same " +
                         "options (-march=native, -mavx, -fsanitize=address and debug containers make a difference)");
    }
    Registry registry;
    std::vector<fs::path> seen;
    const std::vector<fs::path> path = search_path(extra);
    for (std::size_t i = 0; i < path.size(); ++i) {
        std::error_code error;
        fs::path canonical = fs::canonical(path[i], error);
        if (!error && std::find(seen.begin(), seen.end(), canonical) != seen.end()) {
            continue; // listed twice: its modules are not duplicates
        }
        try {
            for (const fs::path& file : modules_in(path[i])) {
                registry.add(file);
            }
            seen.push_back(std::move(canonical));
        } catch (const fs::filesystem_error& failure) {
            const std::string reason = failure.code().message();
            if (i < extra.size()) {
                throw UsageError("plugin directory '" + path[i].string() + "' cannot be listed (" + reason +
                                 "); name a directory that holds plugin modules (*.so)");
            }
            // The library's own directory may be missing if all plugins come from elsewhere.
            if (i + 1 < path.size()) {
                registry.refused_.push_back({path[i], "directory of DIFUSA_PLUGIN_PATH: " + reason, {}, {}});
            }
        }
    }
    return registry;
}

bool Registry::add(const fs::path& module_file) {
    ModuleTag tag;
    try {
        // With a directory in the name, dlopen takes the file itself and does not search for a library of that name.
        const fs::path file = fs::absolute(module_file);
        tag = read_module_tag(file);
        check_tag(tag);
        if (const LoadedPlugin* first = find(tag.kind, tag.name)) {
            throw ModuleRefused("a " + tag.kind + " named '" + first->description.name + "' was already found in " +
                                first->file.string());
        }
        plugins_.push_back({describe_module(file, tag), module_file});
        return true;
    } catch (const ModuleRefused& refusal) {
        refused_.push_back({module_file, refusal.what(), tag.kind, tag.name});
        return false;
    }
}

const LoadedPlugin* Registry::find(std::string_view kind, std::string_view name) const {
    const auto found = std::find_if(plugins_.begin(), plugins_.end(), [&](const LoadedPlugin& plugin) {
        return plugin.description.kind == kind && same_name(plugin.description.name, name);
    });
    return found == plugins_.end() ? nullptr : &*found;
}

std::vector<std::string> Registry::names(std::string_view kind) const {
    std::vector<std::string> names;
    for (const LoadedPlugin& plugin : plugins_) {
        if (plugin.description.kind == kind) {
            names.push_back(plugin.description.name);
        }
    }
    std::sort(names.begin(), names.end());
    return names;
}

std::vector<fs::path> Registry::files() const {
    std::vector<fs::path> files;
    for (const LoadedPlugin& plugin : plugins_) {
        files.push_back(plugin.file);
    }
    for (const RefusedPlugin& refused : refused_) {
        files.push_back(refused.file);
    }
    return files;
}

std::string Registry::describe(std::string_view kind, std::string_view choice) const {
    const Choice chosen = choose(kind, choice);
    const std::string parameters = chosen.parameters.text();
    return chosen.plugin->description.name + (parameters.empty() ? "" : ":" + parameters);
}

void* Registry::created(const Choice& choice) {
    const LoadedPlugin& plugin = *choice.plugin;
    const auto failed = [&](const std::string& why) {
        return InternalError("the " + plugin.description.kind + " " + plugin.description.name + " (" +
                             plugin.file.string() + ") cannot be made: " + why);
    };
    void* made = nullptr;
    try {
        made = plugin.description.create(choice.parameters);
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        throw failed(error.what());
    } catch (...) {
        throw failed("it throws something other than an exception");
    }
    if (made == nullptr) {
        throw failed("it returns nothing");
    }
    return made;
}

Registry::Choice Registry::choose(std::string_view kind, std::string_view choice) const {
    const auto [name, parameters] = split_choice(choice);
    if (const LoadedPlugin* plugin = find(kind, name)) {
        const PluginDescription& description = plugin->description;
        return {plugin, Parameters(parameters, description.parameters, description.kind + " " + description.name)};
    }
    std::string message = "no " + std::string(kind) + " is named '" + std::string(name) + "'";
    const std::vector<std::string> known = names(kind);
    const std::string near = nearest_name(name, known);
    message += near.empty() ? "." : "; did you mean '" + near + "'?";
    message += known.empty() ? " None was found in any plugin directory" : " Known: " + join(known);
    for (const RefusedPlugin& refused : refused_) {
        if (carries_name(refused, kind, name)) {
            message += ". " + refused.file.string() + " was refused: " + refused.reason;
        }
    }
    throw UsageError(message);
}

} // namespace difusa
