// Reads numbers from a binary file, in either byte order, never past its end.
#pragma once

#include <difusa/import/file_content.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string>
#include <string_view>

namespace difusa {

/// Reads bytes once, from front to back. They must outlive the scanner.
class ByteScanner {
  public:
    /// Starts at byte `offset` of `content`; `file` is for messages.
    ByteScanner(std::string_view content, std::string file, std::endian order, std::size_t offset);

    /// Takes a number. Throws InputError if the file ends before or within it.
    template <class T> T take(const Expected& expected) {
        std::array<char, sizeof(T)> bytes;
        if (remaining() < bytes.size()) {
            fail_missing(expected);
        }
        std::memcpy(bytes.data(), content_.data() + at_, bytes.size());
        at_ += bytes.size();
        if (swap_) {
            std::reverse(bytes.begin(), bytes.end());
        }
        return std::bit_cast<T>(bytes);
    }

    /// Skips `count` bytes. Throws like `take`.
    void skip(std::size_t count, const Expected& expected);

    std::size_t offset() const { return at_; }
    std::size_t remaining() const { return content_.size() - at_; }

    /// Throws InputError "file, byte n: problem" for the current position.
    [[noreturn]] void fail(const std::string& problem) const;
    [[noreturn]] void fail_missing(const Expected& expected) const;

  private:
    std::string_view content_;
    std::string file_;
    bool swap_;
    std::size_t at_;
};

} // namespace difusa
