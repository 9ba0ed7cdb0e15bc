// The input as a file, for readers that are given a name. It stays in memory.
#pragma once

#include "fuzz_reader.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <string>

namespace fuzz {

/// A file that holds the input.
inline std::filesystem::path file_of(const std::uint8_t* data, std::size_t size) {
    static const int file = memfd_create("input", 0);
    hold(file >= 0 && ftruncate(file, 0) == 0 && pwrite(file, data, size, 0) == static_cast<ssize_t>(size),
         "there is memory for the input");
    return "/proc/self/fd/" + std::to_string(file);
}

/// Calls `read` with that file; an InputError has to name it.
template <class Read> void read_file_of(const std::uint8_t* data, std::size_t size, const Read& read) {
    const std::filesystem::path file = file_of(data, size);
    try {
        read(file);
    } catch (const difusa::InputError& error) {
        hold(std::string_view(error.what()).find(file.string()) != std::string_view::npos, "messages name the file");
    } catch (const difusa::ResourceError&) { // a large field of few bytes
    }
}

} // namespace fuzz
