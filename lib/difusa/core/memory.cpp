#include <difusa/core/memory.h>

#include <difusa/core/error.h>

#include <sys/resource.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <limits>
#include <optional>
#include <string>

namespace difusa {

namespace {

constexpr std::size_t unlimited = std::numeric_limits<std::size_t>::max();

/// The number in a file that contains just one, or `unlimited`.
std::size_t number_in(const std::filesystem::path& path) {
    std::ifstream file(path);
    std::size_t value = 0;
    return file >> value ? value : unlimited;
}

/// The number after `name` in a table of names and numbers, or nothing.
std::optional<std::size_t> entry(const std::filesystem::path& path, const std::string& name) {
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

/// What a version of the kernel's control groups calls its files.
struct GroupFiles {
    const char *limit, *used, *reclaimable; ///< the last in memory.stat
};

constexpr GroupFiles files_of_v1{"memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"};
constexpr GroupFiles files_of_v2{"memory.max", "memory.current", "inactive_file"};

/// What is left of the limit of one group, or `unlimited`.
std::size_t left_of_group(const std::filesystem::path& group, const GroupFiles& files) {
    const std::size_t limit = number_in(group / files.limit), used = number_in(group / files.used);
    if (limit == unlimited || used == unlimited) {
        return unlimited;
    }
    // The kernel gives up pages of files before it refuses memory to a program.
    const std::size_t reclaimable = entry(group / "memory.stat", files.reclaimable).value_or(0);
    const std::size_t held = used - std::min(used, reclaimable);
    return limit - std::min(limit, held);
}

/// The least of a group and of all that it is in, up to the root, which is there even where a container hides the path.
std::size_t left_up_from(const std::filesystem::path& root, const std::string& group, const GroupFiles& files) {
    std::size_t left = left_of_group(root, files);
    std::filesystem::path path = root;
    for (const std::filesystem::path& part : std::filesystem::path(group).relative_path()) {
        if (part == "..") { // outside of what is mounted
            break;
        }
        path /= part;
        left = std::min(left, left_of_group(path, files));
    }
    return left;
}

/// Whether a list of names separated by commas has this one.
bool lists(const std::string& names, const std::string& name) {
    return ("," + names + ",").find("," + name + ",") != std::string::npos;
}

} // namespace

std::size_t left_of_control_groups(const std::filesystem::path& proc, const std::filesystem::path& groups) {
    std::size_t left = left_of_group(groups, files_of_v2);
    std::ifstream file(proc / "self" / "cgroup");
    for (std::string line; std::getline(file, line);) { // number:controllers:path
        const std::size_t first = line.find(':'), second = line.find(':', first + 1);
        if (first == std::string::npos || second == std::string::npos) {
            continue;
        }
        const std::string controllers = line.substr(first + 1, second - first - 1), group = line.substr(second + 1);
        if (controllers.empty()) {
            left = std::min(left, left_up_from(groups, group, files_of_v2));
        } else if (lists(controllers, "memory")) {
            left = std::min(left, left_up_from(groups / "memory", group, files_of_v1));
        }
    }
    return left;
}

std::size_t available_memory() {
    std::size_t available =
        std::min(kilobytes("/proc/meminfo", "MemAvailable:"), left_of_control_groups("/proc", "/sys/fs/cgroup"));
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
        const std::size_t mapped = kilobytes("/proc/self/status", "VmSize:");
        const auto most = static_cast<std::size_t>(limit.rlim_cur);
        available = std::min(available, most - std::min(most, mapped));
    }
    return available;
}

std::size_t held_memory() {
    const std::size_t held = kilobytes("/proc/self/status", "VmRSS:");
    return held < unlimited ? held : peak_memory();
}

std::size_t peak_memory() {
    // ru_maxrss begins with what the process held that started this one.
    if (const std::size_t peak = kilobytes("/proc/self/status", "VmHWM:"); peak < unlimited) {
        return peak;
    }
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
    if (most == std::numeric_limits<double>::infinity()) {
        return available_memory();
    }
#ifdef __GLIBC__
    malloc_trim(0);
#endif
    const double left = std::max(0.0, most - static_cast<double>(held_memory()));
    const std::size_t available = available_memory();
    return left < static_cast<double>(available) ? static_cast<std::size_t>(left) : available;
}

void require_memory(double bytes, std::size_t available, const std::string& purpose, const std::string& remedy) {
    const auto most = static_cast<double>(available);
    if (bytes > 0.9 * most) {
        throw ResourceError(purpose + " would take about " + format_bytes(bytes) + " of memory; " + format_bytes(most) +
                            " are available, of which nine tenths may be used: " + remedy);
    }
}

} // namespace difusa
