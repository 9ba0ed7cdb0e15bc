#include <difusa/import/file_content.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <new>
#include <system_error>

namespace difusa {

namespace fs = std::filesystem;

void check_readable(const fs::path& file) {
    const std::string name = file.string();
    std::error_code error;
    const fs::file_status status = fs::status(file, error);
    if (error) {
        throw InputError(name + ": cannot be opened (" + error.message() + "): check the path and its permissions");
    }
    if (fs::is_directory(status)) {
        throw InputError(name + ": is a directory: name a file in it");
    }
    if (!fs::is_regular_file(status)) {
        throw InputError(name + ": is not a regular file: save its content to one");
    }
    errno = 0;
    if (!std::ifstream(file, std::ios::binary)) {
        throw InputError(name + ": cannot be opened (" + std::generic_category().message(errno) +
                         "): check its permissions");
    }
}

std::string read_file(const fs::path& file) {
    check_readable(file);
    const std::string name = file.string();
    std::error_code error;
    const std::uintmax_t size = fs::file_size(file, error);
    if (error) {
        throw InputError(name + ": its size cannot be read (" + error.message() + ")");
    }
    std::string content;
    try {
        content.resize(size);
    } catch (const std::exception&) { // bad_alloc or length_error
        throw ResourceError(name + ": its " + std::to_string(size) + " bytes do not fit into memory");
    }
    std::ifstream stream(file, std::ios::binary);
    stream.read(content.data(), static_cast<std::streamsize>(size));
    if (stream.gcount() != static_cast<std::streamsize>(size)) {
        throw InputError(name + ": only " + std::to_string(stream.gcount()) + " of " + std::to_string(size) +
                         " bytes could be read: check the disk, and that nothing is writing to the file");
    }
    if (content.empty()) {
        throw InputError(name + ": is empty");
    }
    return content;
}

fs::path find_beside(const fs::path& folder, std::string_view name) {
    std::string portable(name);
    std::replace(portable.begin(), portable.end(), '\\', '/');
    for (const fs::path& candidate :
         {folder / std::string(name), folder / portable, folder / portable.substr(portable.find_last_of('/') + 1)}) {
        std::error_code error;
        if (fs::is_regular_file(candidate, error)) {
            return candidate;
        }
    }
    return {};
}

std::string Expected::text() const {
    std::string result = what;
    if (number > 0) {
        result += " " + std::to_string(number);
        if (total > 0) {
            result += " of " + std::to_string(total);
        }
    }
    return result;
}

std::string excerpt(std::string_view piece) {
    constexpr std::size_t longest = 40;
    constexpr const char* digits = "0123456789abcdef";
    std::string result = "'";
    for (const char c : piece.substr(0, longest)) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x20 || byte >= 0x7f) {
            result += "\\x";
            result += digits[byte >> 4];
            result += digits[byte & 15];
        } else {
            result += c;
        }
    }
    return result + (piece.size() > longest ? "...'" : "'");
}

} // namespace difusa
