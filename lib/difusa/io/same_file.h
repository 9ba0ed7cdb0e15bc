// Whether two names mean the same file, and outputs that would overwrite an input.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace difusa {

/// The end of a chain of symbolic links, whether or not there is a file; nothing if the links form a loop.
std::optional<std::filesystem::path> end_of_links(const std::filesystem::path& file);

/// True if both names lead to the same file, however they are spelled and through whatever links; also if there is no
/// such file yet.
bool same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// Names of files, many of them, that are told apart as by `same_file`.
class DistinctFiles {
  public:
    /// False if this file is among them already.
    bool add(const std::filesystem::path& file);

  private:
    std::set<std::pair<std::uint64_t, std::uint64_t>> existing_; ///< device and number
    std::set<std::filesystem::path> names_;                      ///< of the others
};

/// Throws UsageError, naming both, if one of the outputs is one of the inputs, which exist. Empty names are no files.
void refuse_to_overwrite(const std::vector<std::filesystem::path>& inputs,
                         const std::vector<std::filesystem::path>& outputs);

} // namespace difusa
