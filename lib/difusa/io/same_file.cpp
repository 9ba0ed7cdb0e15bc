#include <difusa/io/same_file.h>

#include <difusa/core/error.h>

#include <sys/stat.h>

#include <system_error>
#include <utility>

namespace difusa {

namespace {

namespace fs = std::filesystem;

constexpr int most_links = 40; // as Linux

/// Device and number of an existing file.
std::optional<std::pair<dev_t, ino_t>> identity(const fs::path& file) {
    struct stat status {};
    if (stat(file.c_str(), &status) != 0) {
        return std::nullopt;
    }
    return std::pair(status.st_dev, status.st_ino);
}

/// The name of a file that need not exist, without links and dots.
fs::path canonical_path(const fs::path& file) {
    std::error_code ignored;
    return fs::weakly_canonical(fs::absolute(end_of_links(file).value_or(file), ignored), ignored);
}

} // namespace

std::optional<fs::path> end_of_links(const fs::path& file) {
    fs::path place = file;
    std::error_code ignored;
    for (int links = 0; fs::is_symlink(place, ignored); ++links) {
        if (links == most_links) {
            return std::nullopt;
        }
        place = place.parent_path() / fs::read_symlink(place); // an absolute link replaces the directory
    }
    return place;
}

bool same_file(const fs::path& a, const fs::path& b) {
    const auto first = identity(a), second = identity(b);
    return first || second ? first == second : canonical_path(a) == canonical_path(b);
}

bool DistinctFiles::add(const fs::path& file) {
    if (const auto known = identity(file)) {
        return existing_.emplace(known->first, known->second).second;
    }
    return names_.insert(canonical_path(file)).second;
}

void refuse_to_overwrite(const std::vector<fs::path>& inputs, const std::vector<fs::path>& outputs) {
    for (const fs::path& output : outputs) {
        const auto target = identity(output);
        if (!target) {
            continue; // new, or an empty name
        }
        for (const fs::path& input : inputs) {
            if (identity(input) == target) {
                throw UsageError(output.string() + ": would overwrite " + input.string() +
                                 ", which is read; give the output another name");
            }
        }
    }
}

} // namespace difusa
