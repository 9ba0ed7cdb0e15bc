// A file that appears under its name only once it is complete.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace difusa {

/// Written under a temporary name in the directory of its target, then renamed to it. Unless `commit` succeeded, the
/// destructor removes what was written, and an older file under the target's name stays as it was.
///
/// A target that is a symbolic link remains one: the file it leads to is replaced. Throws UsageError for a name that is
/// not a file's ("-", a directory, a device), ResourceError if the system refuses; both name the target.
class WholeFile {
  public:
    /// Creates the temporary file, with the permissions of any new file.
    explicit WholeFile(const std::filesystem::path& target);
    ~WholeFile();
    WholeFile(const WholeFile&) = delete;
    WholeFile& operator=(const WholeFile&) = delete;

    /// Writes where the last `write` or `seek` ended; initially at the start.
    void write(std::string_view bytes);

    /// Moves to this number of bytes from the start.
    void seek(std::int64_t position);

    /// Waits until all data are on disk, and closes the file: nothing more is written. For programs that hold many
    /// files before they commit the first.
    void finish();

    /// Does so if it has not been done, then renames.
    void commit();

  private:
    [[noreturn]] void fail(const std::string& reason) const;
    void keep_permissions() const;

    std::filesystem::path target_;    ///< as the user named it, for messages
    std::filesystem::path resolved_;  ///< with all symbolic links resolved
    std::filesystem::path temporary_; ///< empty: renamed
    int descriptor_ = -1;
};

} // namespace difusa
