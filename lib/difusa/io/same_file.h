// Whether two names mean the same file, and outputs that would overwrite an input.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

namespace difusa {

/// The end of a chain of symbolic links, whether or not there is a file; nothing if the links form a loop.
std::optional<std::filesystem::path> end_of_links(const std::filesystem::path& file);

/// True if both names lead to the same file, however they are spelled and through whatever links; also if there is no
/// such file yet.
bool same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// Throws UsageError, naming both, if one of the outputs is one of the inputs, which exist. Empty names are no files.
void refuse_to_overwrite(const std::vector<std::filesystem::path>& inputs,
                         const std::vector<std::filesystem::path>& outputs);

} // namespace difusa
