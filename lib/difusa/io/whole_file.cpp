#include <difusa/io/whole_file.h>

#include <difusa/core/error.h>
#include <difusa/io/field_file.h>
#include <difusa/io/same_file.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <optional>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace difusa {

namespace {

namespace fs = std::filesystem;

std::string quoted_path(const fs::path& path) {
    return "`" + path.string() + "`";
}

/// The system's message, and what to do about it.
std::string explain(int error, const fs::path& directory) {
    const std::string said = std::generic_category().message(error);
    std::error_code ignored;
    switch (error) {
    case ENOENT:
    case ENOTDIR:
        if (fs::is_directory(directory, ignored)) { // such as /proc
            return "no file can be created in the directory " + quoted_path(directory) + ": choose another";
        }
        if (fs::exists(directory, ignored)) {
            return quoted_path(directory) + " is not a directory: choose another";
        }
        return "the directory " + quoted_path(directory) + " does not exist: create it, or choose another";
    case EACCES:
    case EPERM:
    case EROFS:
        return said + ": choose a directory you may write to (this is " + quoted_path(directory) + ")";
    case ENOSPC:
    case EDQUOT:
        return said + ": make room, or choose another disk";
    case EFBIG:
        return said + ": raise the limit on file sizes (`ulimit -f`), or choose another disk";
    default:
        return said;
    }
}

fs::path directory_of(const fs::path& file) {
    return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

fs::path follow_links(const fs::path& target) {
    const std::optional<fs::path> end = end_of_links(target);
    if (!end) {
        throw ResourceError("cannot write " + quoted_path(target) + ": its symbolic links form a loop");
    }
    return *end;
}

/// Names are unique among and within processes. They do not contain the target's name, whose length is limited too.
fs::path temporary_name(const fs::path& directory) {
    static std::atomic<unsigned> counter{0};
    return directory / (".difusa-" + std::to_string(getpid()) + "-" + std::to_string(counter++) + ".part");
}

} // namespace

WholeFile::WholeFile(const fs::path& target) : target_(target), resolved_(follow_links(target)) {
    if (target.empty() || target == "-") {
        throw UsageError("cannot write to " + std::string(target.empty() ? "an empty name" : "standard output") +
                         ": name a file");
    }
    std::error_code ignored;
    const fs::file_status status = fs::status(resolved_, ignored);
    if (fs::is_directory(status) || !resolved_.has_filename()) {
        throw UsageError("cannot write " + quoted_path(target) + ": it is a directory; name a file in it");
    }
    if (fs::exists(status) && !fs::is_regular_file(status)) {
        throw UsageError("cannot write " + quoted_path(target) + ": it is a device or pipe; name an ordinary file");
    }
    // A rename would silently replace it.
    if (fs::exists(status) && faccessat(AT_FDCWD, resolved_.c_str(), W_OK, AT_EACCESS) != 0) {
        fail("the file is write-protected: remove it, or choose another name");
    }
    const fs::path directory = directory_of(resolved_);
    do { // a file may be left over from a killed process
        temporary_ = temporary_name(directory);
        descriptor_ = open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    } while (descriptor_ < 0 && (errno == EEXIST || errno == EINTR));
    if (descriptor_ < 0) {
        fail(explain(errno, directory));
    }
    keep_permissions();
}

/// Whoever may not read the file that is replaced may not read the new one: of another group that this process is not
/// in, no member may.
void WholeFile::keep_permissions() const {
    struct stat old {};
    if (stat(resolved_.c_str(), &old) != 0) {
        return; // there is none
    }
    const bool same_group = fchown(descriptor_, static_cast<uid_t>(-1), old.st_gid) == 0;
    const mode_t mode = old.st_mode & (same_group ? 0777U : 0707U);
    if (fchmod(descriptor_, mode) != 0 && errno != EPERM) { // some file systems have no permissions
        fail(explain(errno, directory_of(resolved_)));
    }
}

WholeFile::~WholeFile() {
    if (descriptor_ >= 0) {
        ::close(descriptor_);
    }
    if (!temporary_.empty()) {
        unlink(temporary_.c_str());
    }
}

void WholeFile::write(std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
        if (written < 0 && errno != EINTR) {
            fail(explain(errno, directory_of(resolved_)));
        }
        bytes.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
    }
}

void WholeFile::seek(std::int64_t position) {
    if (lseek(descriptor_, static_cast<off_t>(position), SEEK_SET) < 0) {
        fail(explain(errno, directory_of(resolved_)));
    }
}

void WholeFile::finish() {
    // File systems that cannot flush report EINVAL; there is nothing to wait for then.
    if (fsync(descriptor_) != 0 && errno != EINVAL) {
        fail(explain(errno, directory_of(resolved_)));
    }
    ::close(descriptor_);
    descriptor_ = -1;
}

void WholeFile::commit() {
    if (descriptor_ >= 0) {
        finish();
    }
    if (rename(temporary_.c_str(), resolved_.c_str()) != 0) {
        fail(explain(errno, directory_of(resolved_)));
    }
    temporary_.clear();
}

void WholeFile::fail(const std::string& reason) const {
    throw ResourceError("cannot write " + quoted_path(target_) + ": " + reason);
}

void write_whole_file(const fs::path& file, const std::string& content) {
    WholeFile whole(file);
    whole.write(content);
    whole.commit();
}

} // namespace difusa
