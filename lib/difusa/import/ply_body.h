// The body of a PLY file: the values of its elements, as text or binary, passed to a sink row by row.
#pragma once

#include <difusa/import/byte_scanner.h>
#include <difusa/import/ply_header.h>

#include <cstdint>
#include <string>
#include <vector>

namespace difusa::ply {

/// The layout of a text body: one row per line, as in PLY, with any number as a value; or values separated by any white
/// space, whole ones in the range of their types.
enum class Layout { lines, free };

class TextValues {
  public:
    static constexpr const char* unit = "line"; ///< of positions

    TextValues(const TextScanner& scanner, Layout layout);

    /// A value takes a digit and a blank; the last one may lack the blank.
    static double least_bytes(Type) { return 2.0; }
    std::size_t available() const { return scanner_.remaining() + 1; }

    void begin_row(const Expected& expected);
    void end_row(const Expected& expected);
    double real(Type type, const Expected& expected);
    std::int64_t integer(Type, const Expected& expected) { return scanner_.integer(expected, reach()); }
    void skip(Type type, std::size_t count, const Expected& expected);

    std::uint32_t line() const { return scanner_.line(); }
    std::size_t place() const { return scanner_.line(); }
    [[noreturn]] void fail(const std::string& problem) const { scanner_.fail(problem); }
    TextScanner& scanner() { return scanner_; }

  private:
    TextScanner::Reach reach() const {
        return layout_ == Layout::lines ? TextScanner::Reach::line : TextScanner::Reach::file;
    }
    TextScanner scanner_;
    Layout layout_;
};

class ByteValues {
  public:
    static constexpr const char* unit = "byte";

    /// `content` is the whole file, `file` its name for messages.
    ByteValues(std::string_view content, std::string file, const Header& header);

    static double least_bytes(Type type) { return static_cast<double>(size_of(type)); }
    std::size_t available() const { return scanner_.remaining(); }

    void begin_row(const Expected&) {}
    void end_row(const Expected&) {}
    double real(Type type, const Expected& expected);
    std::int64_t integer(Type type, const Expected& expected); ///< not for real types
    void skip(Type type, std::size_t count, const Expected& expected) {
        scanner_.skip(count * size_of(type), expected);
    }

    std::uint32_t line() const { return 0; }
    std::size_t place() const { return scanner_.offset(); }
    [[noreturn]] void fail(const std::string& problem) const { scanner_.fail(problem); }
    ByteScanner& scanner() { return scanner_; }

  private:
    ByteScanner scanner_;
};

/// The minimum number of bytes for the elements of a header.
template <class Values> double least_bytes(const Header& header) {
    double least = 0.0;
    for (const Element& element : header.elements) {
        for (const Property& property : element.properties) {
            least +=
                static_cast<double>(element.count) * Values::least_bytes(property.count_type.value_or(property.type));
        }
    }
    return least;
}

/// Reads the rows of an element, in file order. A sink has
///     Expected expected(const Element&, const Property&, std::size_t row)   what messages call the value being read
///     bool wants(const Property&)                                           others are skipped
///     void value(const Property&, double, const Expected&)
///     void check_length(const Property&, std::int64_t length, const Expected&)   throws if a list cannot be so long
///     void corners(std::vector<std::int64_t>&)                              of a face or strip; may be moved from
///     void begin_row(), end_row()
template <class Values, class Sink> void read_rows(Values& values, const Element& element, Sink& sink) {
    if (element.properties.empty()) {
        return; // empty, whatever its count
    }
    std::vector<std::int64_t> list;
    for (std::size_t row = 0; row < element.count; ++row) {
        values.begin_row(sink.expected(element, element.properties.front(), row));
        sink.begin_row();
        for (const Property& property : element.properties) {
            const Expected expected = sink.expected(element, property, row);
            if (!property.count_type) {
                if (sink.wants(property)) {
                    sink.value(property, values.real(property.type, expected), expected);
                } else {
                    values.skip(property.type, 1, expected);
                }
                continue;
            }
            const std::int64_t length = values.integer(*property.count_type, expected);
            sink.check_length(property, length, expected);
            if (property.role != corners) {
                values.skip(property.type, static_cast<std::size_t>(length), expected);
                continue;
            }
            list.clear();
            for (std::int64_t k = 0; k < length; ++k) {
                list.push_back(values.integer(property.type, expected));
            }
            sink.corners(list);
        }
        values.end_row(sink.expected(element, element.properties.back(), row));
        sink.end_row();
    }
}

} // namespace difusa::ply
