#include <difusa/io/npz_file.h>

#include <difusa/core/error.h>
#include <difusa/io/checksum.h>

#include <algorithm>
#include <bit>
#include <limits>

namespace difusa {

namespace {

static_assert(std::endian::native == std::endian::little, "arrays are written as they are in memory");

void append_little(std::string& bytes, std::uint32_t value, unsigned count) {
    for (unsigned k = 0; k < count; ++k) {
        bytes += static_cast<char>(value >> (8U * k) & 0xffU);
    }
}

template <class T> std::string_view bytes_of(std::span<const T> values) {
    return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

std::string shape_of(std::size_t count, std::size_t columns) {
    return columns == 0 ? "(" + std::to_string(count) + ",)"
                        : "(" + std::to_string(count / columns) + ", " + std::to_string(columns) + ")";
}

/// Common fields of both headers of an entry: version 2.0, names in UTF-8, stored, 1 January 1980.
std::string entry_fields(std::uint32_t crc, std::uint32_t size, std::size_t name_length) {
    std::string fields;
    append_little(fields, 20, 2);
    append_little(fields, 1U << 11U, 2);
    append_little(fields, 0, 2);
    append_little(fields, 0, 2);
    append_little(fields, 1U << 5U | 1U, 2);
    append_little(fields, crc, 4);
    append_little(fields, size, 4);
    append_little(fields, size, 4);
    append_little(fields, static_cast<std::uint32_t>(name_length), 2);
    append_little(fields, 0, 2);
    return fields;
}

} // namespace

void NpzWriter::array(const std::string& name, std::span<const double> values, std::size_t columns) {
    add(name, "<f8", shape_of(values.size(), columns), bytes_of(values));
}

void NpzWriter::array(const std::string& name, std::span<const float> values, std::size_t columns) {
    add(name, "<f4", shape_of(values.size(), columns), bytes_of(values));
}

void NpzWriter::array(const std::string& name, std::span<const std::int32_t> values) {
    add(name, "<i4", shape_of(values.size(), 0), bytes_of(values));
}

void NpzWriter::array(const std::string& name, std::span<const std::int64_t> values) {
    add(name, "<i8", shape_of(values.size(), 0), bytes_of(values));
}

void NpzWriter::bytes(const std::string& name, std::string_view text) {
    add(name, "|S" + std::to_string(text.size()), "()", text);
}

void NpzWriter::texts(const std::string& name, std::span<const std::string> values) {
    std::size_t width = 1;
    for (const std::string& text : values) {
        width = std::max(width, text.size());
    }
    std::string data;
    for (const std::string& text : values) {
        data += text;
        data.append(width - text.size(), '\0');
    }
    add(name, "|S" + std::to_string(width), shape_of(values.size(), 0), data);
}

void NpzWriter::add(const std::string& name, const std::string& type, const std::string& shape, std::string_view data) {
    std::string header = "{'descr': '" + type + "', 'fortran_order': False, 'shape': " + shape + ", }";
    constexpr std::size_t before = 10; // magic, version and length; all of it in multiples of 64, ending in a line end
    header.append(63 - (before + header.size()) % 64, ' ');
    header += '\n';
    std::string start("\x93NUMPY\x01\x00", 8);
    append_little(start, static_cast<std::uint32_t>(header.size()), 2);
    start += header;
    const std::string file_name = name + ".npy";
    const std::uint64_t size = start.size() + data.size();
    constexpr std::uint64_t room = 1U << 20U; // for the directory at the end
    if (written_ + size + room > std::numeric_limits<std::uint32_t>::max()) {
        throw ResourceError(
            "the .npz file would exceed 4 GiB: write .mtx or .csv, the sparse layout, or fewer surfaces");
    }
    const std::uint32_t crc = crc32_of(data, crc32_of(start));
    entries_.push_back({file_name, crc, static_cast<std::uint32_t>(size), static_cast<std::uint32_t>(written_)});
    const std::string local = "PK\x03\x04" + entry_fields(crc, static_cast<std::uint32_t>(size), file_name.size());
    file_.write(local + file_name + start);
    file_.write(data);
    written_ += local.size() + file_name.size() + size;
}

void NpzWriter::finish() {
    std::string directory;
    for (const Entry& entry : entries_) {
        directory += "PK\x01\x02";
        append_little(directory, 20, 2);
        directory += entry_fields(entry.crc, entry.size, entry.name.size());
        append_little(directory, 0, 4); // no comment, first disk
        append_little(directory, 0, 2);
        append_little(directory, 0, 4);
        append_little(directory, entry.offset, 4);
        directory += entry.name;
    }
    std::string end = "PK\x05\x06";
    append_little(end, 0, 4);
    append_little(end, static_cast<std::uint32_t>(entries_.size()), 2);
    append_little(end, static_cast<std::uint32_t>(entries_.size()), 2);
    append_little(end, static_cast<std::uint32_t>(directory.size()), 4);
    append_little(end, static_cast<std::uint32_t>(written_), 4);
    append_little(end, 0, 2);
    file_.write(directory + end);
}

} // namespace difusa
