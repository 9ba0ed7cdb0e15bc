// Memory used by, and available to, this process.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace difusa {

/// Bytes that can still be allocated without swapping: the minimum of what the system calls available and what is left
/// of a control group's or process' limit.
std::size_t available_memory();

/// The same, but no more than is left of `most` bytes for the whole process, beside what it holds now. If `most` is
/// finite, freed memory that the allocator keeps is given back first.
std::size_t available_memory(double most);

/// Resident memory of this process now, in bytes.
std::size_t held_memory();

/// Bytes that are left of the memory limits of the control groups, of either version, that this process is in, and of
/// those that these are in; the largest number if there is no limit. `proc` and `groups`: where the kernel mounts its
/// files, /proc and /sys/fs/cgroup.
std::size_t left_of_control_groups(const std::filesystem::path& proc, const std::filesystem::path& groups);

/// Peak resident memory of this process so far, in bytes.
std::size_t peak_memory();

/// "1.5 GiB", "12 MiB", "300 KiB".
std::string format_bytes(double bytes);

/// Throws ResourceError stating what is needed for what, what is available, and `remedy`, if `bytes` exceed nine tenths
/// of the `available` memory.
void require_memory(double bytes, std::size_t available, const std::string& purpose, const std::string& remedy);

} // namespace difusa
