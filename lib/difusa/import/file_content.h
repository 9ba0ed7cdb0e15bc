// The bytes of a mesh file, and how readers name what they miss in it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace difusa {

/// Throws InputError, with the system's reason, if `file` does not exist, is not a regular file or cannot be opened.
void check_readable(const std::filesystem::path& file);

/// The whole content of a file. Throws what `check_readable` does, InputError if the file is empty or cannot be read
/// to its end, ResourceError if it does not fit into memory.
std::string read_file(const std::filesystem::path& file);

/// The file that `name`, written in a file of `folder`, means: exporters write paths of other machines, with either
/// kind of slash, and files move along with those that name them. Empty if there is none.
std::filesystem::path find_beside(const std::filesystem::path& folder, std::string_view name);

/// What a reader is about to read, for the message if it is not there: "a coordinate of point 5 of 8".
struct Expected {
    const char* what;       ///< "a coordinate of point"
    std::size_t number = 0; ///< which one, from 1; 0: there is only one
    std::size_t total = 0;  ///< of how many; 0: not known

    std::string text() const;
};

/// A piece of a file in quotation marks, cut to a readable length, with unprintable bytes written as \x00.
std::string excerpt(std::string_view piece);

} // namespace difusa
