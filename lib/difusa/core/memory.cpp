#include <difusa/core/memory.h>

#include <difusa/core/error.h>

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <limits>
#include <optional>

namespace difusa {

namespace {

constexpr std::size_t unlimited = std::numeric_limits<std::size_t>::max();

/// The number in a file that contains just one, or `unlimited`.
std::size_t number_in(const char* path) {
    std::ifstream file(path);
    std::size_t value = 0;
    return file >> value ? value : unlimited;
}

/// The number after `name` in a table of names and numbers, or nothing.
std::optional<std::size_t> entry(const char* path, const std::string& name) {
    std::ifstream file(path);
    std::string word;
    std::size_t value = 0;
    while (file >> word) {
        if (word == name && file >> value) {
            return value;
        }
    }
    return std::nullopt;
}

/// That in kB of a /proc table, in bytes, or `unlimited`.
std::size_t kilobytes(const char* path, const std::string& name) {
    const std::optional<std::size_t> value = entry(path, name);
    return value ? *value * 1024 : unlimited;
}

} // namespace

std::size_t available_memory() {
    std::size_t available = kilobytes("/proc/meminfo", "MemAvailable:");
    const std::size_t group_limit = number_in("/sys/fs/cgroup/memory.max");
    const std::size_t group_used = number_in("/sys/fs/cgroup/memory.current");
    if (group_limit != unlimited && group_used != unlimited) {
        // The kernel gives up pages of files before it refuses memory to a program.
        const std::size_t files = entry("/sys/fs/cgroup/memory.stat", "inactive_file").value_or(0);
        const std::size_t held = group_used - std::min(group_used, files);
        available = std::min(available, group_limit - std::min(group_limit, held));
    }
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
        const std::size_t mapped = kilobytes("/proc/self/status", "VmSize:");
        const auto most = static_cast<std::size_t>(limit.rlim_cur);
        available = std::min(available, most - std::min(most, mapped));
    }
    return available;
}

std::size_t peak_memory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

std::string format_bytes(double bytes) {
    constexpr std::array<const char*, 5> unit{"B", "KiB", "MiB", "GiB", "TiB"};
    std::size_t k = 0;
    while (bytes >= 1024.0 && k + 1 < unit.size()) {
        bytes /= 1024.0;
        ++k;
    }
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), bytes < 10.0 && k > 0 ? "%.1f %s" : "%.0f %s", bytes, unit[k]);
    return text.data();
}

std::size_t available_memory(double most) {
    const double left = std::max(0.0, most - static_cast<double>(peak_memory()));
    const std::size_t available = available_memory();
    return left < static_cast<double>(available) ? static_cast<std::size_t>(left) : available;
}

void require_memory(double bytes, std::size_t available, const std::string& purpose, const std::string& remedy) {
    const auto most = static_cast<double>(available);
    if (bytes > 0.9 * most) {
        throw ResourceError(purpose + " would take about " + format_bytes(bytes) + " of memory; " + format_bytes(most) +
                            " are available: " + remedy);
    }
}

} // namespace difusa
