// Numbers as bytes of a file, little-endian on every machine.
#pragma once

#include <difusa/io/whole_file.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
#include <string>

namespace difusa {

/// Buffers bytes for the file; `flush` must follow the last.
class ByteStream {
  public:
    explicit ByteStream(WholeFile& file) : file_(file) {}

    template <typename T> void put(T value) {
        char bytes[sizeof(T)];
        std::memcpy(bytes, &value, sizeof(T));
        if constexpr (std::endian::native == std::endian::big) {
            std::reverse(bytes, bytes + sizeof(T));
        }
        buffer_.append(bytes, sizeof(T));
        if (buffer_.size() >= std::size_t{1} << 20) {
            flush();
        }
    }

    void flush() {
        file_.write(buffer_);
        buffer_.clear();
    }

  private:
    WholeFile& file_;
    std::string buffer_;
};

} // namespace difusa
