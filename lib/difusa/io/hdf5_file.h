// HDF5 files in memory: groups with attributes, and arrays of numbers. Everything is stored in little-endian byte
// order, uncompressed, and without times, so that the same content gives the same bytes.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

/// Types of numbers in arrays: one byte, 32 and 64 bits without sign, double precision.
template <class T>
concept Hdf5Number = std::same_as<T, std::uint8_t> || std::same_as<T, std::uint32_t> ||
    std::same_as<T, std::uint64_t> || std::same_as<T, double>;

/// Groups are named "/", "/sites", "/transport/rows"; a group is made before what is in it. Throws ResourceError if
/// memory does not suffice.
class Hdf5Writer {
  public:
    /// `offset`: bytes that will precede the content in the file (0 or 512 times a power of 2).
    explicit Hdf5Writer(std::size_t offset);
    ~Hdf5Writer();
    Hdf5Writer(const Hdf5Writer&) = delete;
    Hdf5Writer& operator=(const Hdf5Writer&) = delete;

    void group(const std::string& path);
    void attribute(const std::string& group, const std::string& name, double value);
    void attribute(const std::string& group, const std::string& name, std::uint64_t value);
    void attribute(const std::string& group, const std::string& name, const std::string& text);

    /// Rows of `columns` numbers; a single column makes an array of one dimension. `meaning` and `unit` become
    /// attributes of the array.
    template <Hdf5Number T>
    void array(const std::string& path, std::span<const T> values, std::size_t columns, const std::string& meaning);

    /// The content of the file; nothing can be added afterwards.
    std::string finish();

  private:
    std::int64_t file_;
};

/// Reads what Hdf5Writer writes. Everything that is missing or of another type or size throws InputError, naming the
/// file and the item.
class Hdf5Reader {
  public:
    /// `bytes`: the whole file, with what precedes the HDF5 content. `file`: its name, for messages; `remedy`: the end
    /// of each message.
    Hdf5Reader(std::string bytes, std::filesystem::path file, std::string remedy);
    ~Hdf5Reader();
    Hdf5Reader(const Hdf5Reader&) = delete;
    Hdf5Reader& operator=(const Hdf5Reader&) = delete;

    bool has(const std::string& path) const;
    std::vector<std::string> attribute_names(const std::string& group) const;
    double number(const std::string& group, const std::string& name) const; ///< finite
    std::uint64_t whole(const std::string& group, const std::string& name) const;
    std::string text(const std::string& group, const std::string& name) const;

    /// All rows of an array that has this number of columns.
    template <Hdf5Number T> std::vector<T> array(const std::string& path, std::size_t columns) const;

    /// The same, of this number of rows.
    template <Hdf5Number T> std::vector<T> array(const std::string& path, std::size_t columns, std::size_t rows) const;

    /// Throws InputError: "FILE: `what` WHY; REMEDY".
    [[noreturn]] void refuse(const std::string& what, const std::string& why) const;

  private:
    std::vector<std::uint8_t> attribute_bytes(const std::string& group, const std::string& name, bool is_text) const;
    std::int64_t file_ = -1;
    std::string bytes_; ///< HDF5 reads here
    std::filesystem::path name_;
    std::string remedy_;
};

} // namespace difusa
