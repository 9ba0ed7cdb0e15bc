// reader ply: polygon file format of Stanford: text, binary little-endian and binary big-endian.
//
// Read: the elements `vertex` (x y z, red green blue), `face` (vertex_indices or vertex_index, red green blue) and
// `tristrips` (each strip as its triangles), in any order; `diffuse_red` and the like are colours too. Whole-number
// colours count to 255 (ushort: to 65535), real ones to 1. Everything else is passed over, elements with a note.
#include <difusa/core/error.h>
#include <difusa/core/tally.h>
#include <difusa/import/byte_scanner.h>
#include <difusa/import/file_colours.h>
#include <difusa/import/ply_header.h>
#include <difusa/import/reader.h>
#include <difusa/plugin/plugin.h>

#include <algorithm>

namespace {

using namespace difusa;
using namespace difusa::ply;
using Reach = TextScanner::Reach;

// ---- values, from text and from bytes -------------------------------------------------------------------------

class TextSource {
  public:
    static constexpr const char* unit = "line"; ///< of places

    explicit TextSource(const TextScanner& scanner) : scanner_(scanner) {}

    /// A value takes a digit and a blank; the last one may have no blank.
    static double least_bytes(const Property&) { return 2; }
    std::size_t available() const { return scanner_.remaining() + 1; }

    void begin_row(const Expected& expected) {
        if (!scanner_.to_token()) {
            scanner_.fail_missing(expected, Reach::file);
        }
    }
    void end_row(const Expected& expected) {
        std::string_view token;
        if (scanner_.next(token, Reach::line)) {
            scanner_.fail("the line goes on with " + excerpt(token) + " after what the header announces for " +
                          expected.text() + ": correct the line, or export the file again");
        }
    }
    double real(Type, const Expected& expected) { return scanner_.real(expected, Reach::line); }
    std::int64_t integer(Type, const Expected& expected) { return scanner_.integer(expected, Reach::line); }
    void skip(Type, std::size_t count, const Expected& expected) {
        std::string_view token;
        for (std::size_t i = 0; i < count; ++i) {
            if (!scanner_.next(token, Reach::line)) {
                scanner_.fail_missing(expected, Reach::line);
            }
        }
    }
    std::uint32_t line() const { return scanner_.line(); }
    std::size_t place() const { return scanner_.line(); }
    [[noreturn]] void fail(const std::string& problem) const { scanner_.fail(problem); }

    void finish(std::vector<std::string>& notes) {
        std::string_view token;
        if (scanner_.next(token, Reach::file)) {
            scanner_.fail("the file goes on with " + excerpt(token) +
                          " after all its header announces: correct the header, or remove what is too much");
        }
        if (scanner_.ends_abruptly()) {
            notes.emplace_back("the last line has no end: if the file was cut short there, its last number is wrong");
        }
    }

  private:
    TextScanner scanner_;
};

class ByteSource {
  public:
    static constexpr const char* unit = "byte";

    explicit ByteSource(ByteScanner scanner) : scanner_(std::move(scanner)) {}

    static double least_bytes(const Property& property) {
        return static_cast<double>(size_of(property.count_type.value_or(property.type)));
    }
    std::size_t available() const { return scanner_.remaining(); }

    void begin_row(const Expected&) {}
    void end_row(const Expected&) {}
    double real(Type type, const Expected& expected) {
        switch (type) {
        case Type::float32:
            return static_cast<double>(scanner_.take<float>(expected));
        case Type::float64:
            return scanner_.take<double>(expected);
        default:
            return static_cast<double>(integer(type, expected));
        }
    }
    std::int64_t integer(Type type, const Expected& expected) {
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
            return scanner_.take<std::uint32_t>(expected); // no real type gets here
        }
    }
    void skip(Type type, std::size_t count, const Expected& expected) {
        scanner_.skip(count * size_of(type), expected);
    }
    std::uint32_t line() const { return 0; }
    std::size_t place() const { return scanner_.offset(); }
    [[noreturn]] void fail(const std::string& problem) const { scanner_.fail(problem); }

    void finish(std::vector<std::string>& notes) {
        if (scanner_.remaining() > 0) {
            notes.push_back("the last " + std::to_string(scanner_.remaining()) +
                            " bytes of the file follow all its header announces, and were not read");
        }
    }

  private:
    ByteScanner scanner_;
};

// ---- body -----------------------------------------------------------------------------------------------------

template <class Source> class Body {
  public:
    Body(Source source, const Header& header, PolygonSoup& soup)
        : source_(std::move(source)), header_(header), soup_(soup) {}

    void read() {
        check_room();
        for (const Element& element : header_.elements) {
            read_element(element);
        }
        colours_.append_materials(1.0, soup_.materials);
        source_.finish(soup_.notes);
        if (!others_.empty()) {
            soup_.notes.push_back("elements that carry no surface were not read: " + others_.substr(0, 200));
        }
        note_opacity(translucent_, soup_.notes);
    }

  private:
    struct Row {
        std::array<double, value_count> value{};
        std::vector<std::int64_t> corners;
        std::uint32_t line = 0;
    };

    /// Refuses counts that do not fit into the rest of the file.
    void check_room() const {
        double least = 0.0;
        for (const Element& element : header_.elements) {
            for (const Property& property : element.properties) {
                least += static_cast<double>(element.count) * Source::least_bytes(property);
            }
        }
        if (least > static_cast<double>(source_.available())) {
            source_.fail("the header announces at least " + std::to_string(static_cast<std::uint64_t>(least)) +
                         " bytes of data, but only " + std::to_string(source_.available()) +
                         " follow: the file was cut short or its header is wrong; export it again");
        }
    }

    void read_element(const Element& element) {
        if (element.properties.empty()) {
            return; // of no size, whatever its count
        }
        if (element.kind == Element::Kind::other && element.count > 0) {
            others_ += (others_.empty() ? "" : " ") + excerpt(element.name);
        }
        const bool coloured = element.has(red) && element.has(green) && element.has(blue);
        if (!coloured && (element.has(red) || element.has(green) || element.has(blue))) {
            soup_.notes.push_back("the colours of the element " + excerpt(element.name) +
                                  " are not read, for they lack red, green or blue");
        }
        Row row;
        const std::size_t faces_before = soup_.face_count();
        for (std::size_t i = 0; i < element.count; ++i) {
            read_row(element, {element.name.c_str(), i + 1, element.count}, row);
            switch (element.kind) {
            case Element::Kind::points:
                soup_.points.emplace_back(row.value[x], row.value[y], row.value[z]);
                if (row.line > 0) {
                    soup_.point_line.push_back(row.line);
                }
                if (coloured) {
                    soup_.point_reflectance.push_back(colour(row));
                }
                break;
            case Element::Kind::faces:
                add_face(row, 0, row.corners.size(), coloured ? colours_.intern(colour(row)) : none);
                break;
            case Element::Kind::strips:
                add_strips(row);
                break;
            case Element::Kind::other:
                break;
            }
        }
        if (element.kind == Element::Kind::strips) {
            soup_.notes.push_back("the triangle strips were read as " +
                                  std::to_string(soup_.face_count() - faces_before) + " triangles");
        }
    }

    void read_row(const Element& element, const Expected& expected, Row& row) {
        source_.begin_row(expected);
        row.line = source_.line();
        for (const Property& property : element.properties) {
            if (!property.count_type) {
                read_value(property, expected, row);
                continue;
            }
            const std::int64_t length = source_.integer(*property.count_type, expected);
            if (length < 0 || static_cast<std::size_t>(length) > source_.available()) {
                source_.fail("a list of " + expected.text() + " announces " + std::to_string(length) +
                             " entries, which is impossible: the file is damaged; export it again");
            }
            if (property.role != corners) {
                source_.skip(property.type, static_cast<std::size_t>(length), expected);
                continue;
            }
            row.corners.clear();
            for (std::int64_t k = 0; k < length; ++k) {
                row.corners.push_back(source_.integer(property.type, expected));
            }
        }
        source_.end_row(expected);
    }

    void read_value(const Property& property, const Expected& expected, Row& row) {
        if (property.role == nothing) {
            source_.skip(property.type, 1, expected);
            return;
        }
        double value = source_.real(property.type, expected);
        if (property.role >= red) {
            const double one = is_real(property.type) ? 1.0 : (property.type == Type::uint16 ? 65535.0 : 255.0);
            value /= one;
            if (!(value >= 0.0 && value <= 1.0)) {
                source_.fail("the property " + excerpt(property.name) + " of " + expected.text() +
                             " is outside of its range: colours of a real type count from 0 to 1, of a whole-number "
                             "type from 0 to 255 (ushort: 65535)");
            }
            if (property.role == alpha && value != 1.0) {
                translucent_.add(source_.place());
            }
        }
        row.value[property.role] = value;
    }

    static Rgb colour(const Row& row) { return {row.value[red], row.value[green], row.value[blue]}; }

    void add_face(const Row& row, std::size_t begin, std::size_t end, Index material) {
        corners_.clear();
        for (std::size_t k = begin; k < end; ++k) {
            const std::int64_t number = row.corners[k];
            corners_.push_back(number < 0 || number >= none ? none : static_cast<Index>(number));
        }
        soup_.add_face(corners_, material, row.line);
    }

    /// Strips of triangles one after another, each ended by -1; every second triangle of a strip runs clockwise.
    void add_strips(Row& row) {
        std::size_t start = 0;
        for (std::size_t k = 0; k < row.corners.size(); ++k) {
            if (row.corners[k] == -1) {
                start = k + 1;
            } else if (k >= start + 2) {
                const bool odd = (k - start) % 2 == 1;
                std::array<Index, 3> triangle;
                const std::array<std::size_t, 3> order{odd ? k - 1 : k - 2, odd ? k - 2 : k - 1, k};
                std::transform(order.begin(), order.end(), triangle.begin(), [&](std::size_t i) {
                    const std::int64_t number = row.corners[i];
                    return number < 0 || number >= none ? none : static_cast<Index>(number);
                });
                soup_.add_face(triangle, none, row.line);
            }
        }
    }

    Source source_;
    const Header& header_;
    PolygonSoup& soup_;
    ColourTable colours_;
    std::vector<Index> corners_;
    Tally translucent_{Source::unit};
    std::string others_; ///< names of the elements passed over
};

// ---- reader ---------------------------------------------------------------------------------------------------

class PlyReader final : public Reader {
  public:
    explicit PlyReader(const Parameters&) {}

    std::vector<std::string> extensions() const override { return {"ply"}; }

    PolygonSoup read(const std::filesystem::path& file) const override { return parse(read_file(file), file); }

    PolygonSoup parse(std::string_view content, const std::filesystem::path& name) const override {
        PolygonSoup soup;
        soup.file = name.string();
        TextScanner scanner(content, soup.file, {});
        const Header header = parse_header(content, scanner);
        if (header.format == Format::text) {
            Body(TextSource(scanner), header, soup).read();
        } else {
            const std::endian order = header.format == Format::big_endian ? std::endian::big : std::endian::little;
            Body(ByteSource(ByteScanner(content, soup.file, order, header.bytes)), header, soup).read();
        }
        return soup;
    }
};

} // namespace

DIFUSA_PLUGIN(reader, "ply", PlyReader, "PLY polygons, text or binary of either byte order (.ply).", {})
