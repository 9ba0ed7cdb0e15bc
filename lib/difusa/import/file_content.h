// The bytes of a mesh file, and how readers describe missing items in it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace difusa {

/// Throws InputError, with the system's reason, if `file` does not exist, is not a regular file or cannot be opened.
void check_readable(const std::filesystem::path& file);

/// The whole content of a file. Throws what `check_readable` throws, InputError if the file is empty or cannot be read
/// to its end, ResourceError if it does not fit into memory.
std::string read_file(const std::filesystem::path& file);

/// The file meant by `name`, written in a file of `folder`: exporters write paths of other machines, with either kind
/// of slash, while files are moved together with those that name them. Empty if there is none.
std::filesystem::path find_beside(const std::filesystem::path& folder, std::string_view name);

/// The item a reader expects next, for the message if it is missing: "a coordinate of point 5 of 8".
struct Expected {
    const char* what;       ///< "a coordinate of point"
    std::size_t number = 0; ///< which one, from 1; 0: there is only one
    std::size_t total = 0;  ///< out of how many; 0: unknown

    std::string text() const;
};

/// A quoted excerpt of a file, cut to a readable length, with unprintable bytes written as \x00.
std::string excerpt(std::string_view piece);

} // namespace difusa
