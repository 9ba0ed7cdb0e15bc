#include <difusa/core/memory.h>

#include <difusa/core/error.h>

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <limits>

namespace difusa {

namespace {

constexpr std::size_t unlimited = std::numeric_limits<std::size_t>::max();

/// The number in a file that contains just one, or `unlimited`.
std::size_t number_in(const char* path) {
    std::ifstream file(path);
    std::size_t value = 0;
    return file >> value ? value : unlimited;
}

/// kB entry of a /proc table, in bytes, or `unlimited`.
std::size_t entry(const char* path, const std::string& name) {
    std::ifstream file(path);
    std::string word;
    std::size_t kilobytes = 0;
    while (file >> word) {
        if (word == name && file >> kilobytes) {
            return kilobytes * 1024;
        }
    }
    return unlimited;
}

} // namespace

std::size_t available_memory() {
    std::size_t available = entry("/proc/meminfo", "MemAvailable:");
    const std::size_t group_limit = number_in("/sys/fs/cgroup/memory.max");
    const std::size_t group_used = number_in("/sys/fs/cgroup/memory.current");
    if (group_limit != unlimited && group_used != unlimited) {
        available = std::min(available, group_limit - std::min(group_limit, group_used));
    }
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
        const std::size_t mapped = entry("/proc/self/status", "VmSize:");
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

void require_memory(double bytes, const std::string& purpose, const std::string& remedy) {
    const auto available = static_cast<double>(available_memory());
    if (bytes > 0.9 * available) {
        throw ResourceError(purpose + " would take about " + format_bytes(bytes) + " of memory; " +
                            format_bytes(available) + " are available: " + remedy);
    }
}

} // namespace difusa
