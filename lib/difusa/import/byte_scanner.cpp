#include <difusa/import/byte_scanner.h>

#include <difusa/core/error.h>

#include <utility>

namespace difusa {

ByteScanner::ByteScanner(std::string_view content, std::string file, std::endian order, std::size_t offset)
    : content_(content), file_(std::move(file)), swap_(order != std::endian::native),
      at_(std::min(offset, content.size())) {}

void ByteScanner::skip(std::size_t count, const Expected& expected) {
    if (remaining() < count) {
        fail_missing(expected);
    }
    at_ += count;
}

void ByteScanner::fail(const std::string& problem) const {
    throw InputError(file_ + ", byte " + std::to_string(at_) + ": " + problem);
}

void ByteScanner::fail_missing(const Expected& expected) const {
    fail("the file ends where " + expected.text() +
         " is expected: it is truncated, or its header announces too much; export it again");
}

} // namespace difusa
