#include <difusa/import/ply_body.h>

namespace difusa::ply {

using Reach = TextScanner::Reach;

TextValues::TextValues(const TextScanner& scanner, Layout layout) : scanner_(scanner), layout_(layout) {}

void TextValues::begin_row(const Expected& expected) {
    if (layout_ == Layout::lines && !scanner_.to_token()) {
        scanner_.fail_missing(expected, Reach::file);
    }
}

void TextValues::end_row(const Expected& expected) {
    std::string_view token;
    if (layout_ == Layout::lines && scanner_.next(token, Reach::line)) {
        scanner_.fail("the line continues with " + excerpt(token) + " after what the header announces for " +
                      expected.text() + ": correct the line, or export the file again");
    }
}

double TextValues::real(Type type, const Expected& expected) {
    if (layout_ == Layout::lines || is_real(type)) {
        return scanner_.real(expected, reach());
    }
    const std::int64_t value = scanner_.integer(expected, reach());
    const bool has_sign = type == Type::int8 || type == Type::int16 || type == Type::int32;
    const std::int64_t values = std::int64_t{1} << (8 * size_of(type)), least = has_sign ? -values / 2 : 0;
    if (value < least || value >= least + values) {
        scanner_.fail(std::to_string(value) + " is out of the range of " + expected.text() +
                      ", as typed in the header: correct the header, or export the file again");
    }
    return static_cast<double>(value);
}

void TextValues::skip(Type type, std::size_t count, const Expected& expected) {
    for (std::size_t i = 0; i < count; ++i) {
        std::string_view token;
        if (layout_ == Layout::free) {
            real(type, expected);
        } else if (!scanner_.next(token, Reach::line)) {
            scanner_.fail_missing(expected, Reach::line);
        }
    }
}

ByteValues::ByteValues(std::string_view content, std::string file, const Header& header)
    : scanner_(content, std::move(file), header.format == Format::big_endian ? std::endian::big : std::endian::little,
               header.bytes) {}

double ByteValues::real(Type type, const Expected& expected) {
    switch (type) {
    case Type::float32:
        return static_cast<double>(scanner_.take<float>(expected));
    case Type::float64:
        return scanner_.take<double>(expected);
    default:
        return static_cast<double>(integer(type, expected));
    }
}

std::int64_t ByteValues::integer(Type type, const Expected& expected) {
    switch (type) {
    case Type::int8:
        return scanner_.take<std::int8_t>(expected);
    case Type::uint8:
        return scanner_.take<std::uint8_t>(expected);
    case Type::int16:
        return scanner_.take<std::int16_t>(expected);
    case Type::uint16:
        return scanner_.take<std::uint16_t>(expected);
    case Type::int32:
        return scanner_.take<std::int32_t>(expected);
    default:
        return scanner_.take<std::uint32_t>(expected); // list lengths and corner numbers never have a real type
    }
}

} // namespace difusa::ply
