// A plugin module as a file: its tag, read without mapping or executing any of it.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace difusa {

/// Why a module cannot be used; `what()` is the reason, without the file's name.
struct ModuleRefused : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The content of a module's tag, "difusa-plugin;kind=basis;name=flat;interface=1;...".
struct ModuleTag {
    std::string kind;
    std::string name;
    std::vector<std::pair<std::string, std::string>> build; ///< the rest: ("interface", "1"), ...
};

/// The tag in the section `.difusa_plugin` of a shared object for this kind of machine.
///
/// Everything the dynamic linker would map must lie inside the file, so that a truncated module is refused here instead
/// of causing a bus error later. Throws ModuleRefused.
ModuleTag read_module_tag(const std::filesystem::path& file);

/// Parses a tag. Throws ModuleRefused.
ModuleTag parse_module_tag(std::string_view text);

/// The directory of the shared object containing this function: where the library is installed.
std::filesystem::path library_directory();

} // namespace difusa
