// NumPy's .npz files: arrays under names in an uncompressed zip container, each in NumPy's .npy format (version 1.0).
#pragma once

#include <difusa/io/whole_file.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

/// Writes arrays one after the other; `finish` ends the file. Everything is little-endian and without times, so that
/// the same content gives the same bytes. numpy.load(file)["name"] reads an array. Throws ResourceError if the file
/// would exceed 4 GiB, the limit of the container.
class NpzWriter {
  public:
    explicit NpzWriter(WholeFile& file) : file_(file) {}

    /// Rows of `columns` numbers; `columns` 0: an array of one dimension.
    void array(const std::string& name, std::span<const double> values, std::size_t columns = 0);
    void array(const std::string& name, std::span<const float> values, std::size_t columns = 0);
    void array(const std::string& name, std::span<const std::int32_t> values);
    void array(const std::string& name, std::span<const std::int64_t> values);

    /// Bytes as an array without dimensions (b'csr').
    void bytes(const std::string& name, std::string_view text);

    /// Texts in UTF-8 as an array of byte strings of equal length, padded with zeros.
    void texts(const std::string& name, std::span<const std::string> values);

    void finish();

  private:
    struct Entry {
        std::string name;
        std::uint32_t crc, size, offset;
    };
    void add(const std::string& name, const std::string& type, const std::string& shape, std::string_view data);

    WholeFile& file_;
    std::vector<Entry> entries_;
    std::uint64_t written_ = 0;
};

} // namespace difusa
