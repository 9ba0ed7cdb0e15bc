// Memory this process has taken, and could take.
#pragma once

#include <cstddef>
#include <string>

namespace difusa {

/// Bytes that can still be taken without swapping: what the system calls available, or what is left of a control
/// group's or process' limit, whichever is least.
std::size_t available_memory();

/// The most bytes this process has had resident so far.
std::size_t peak_memory();

/// "1.5 GiB", "12 MiB", "300 KiB".
std::string format_bytes(double bytes);

/// Throws ResourceError that says what is needed for what, what is there, and `remedy`, if `bytes` exceed nine tenths
/// of the available memory.
void require_memory(double bytes, const std::string& purpose, const std::string& remedy);

} // namespace difusa
