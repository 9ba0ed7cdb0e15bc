// reader ply: Stanford polygon file format: text, binary little-endian and binary big-endian.
//
// Read: the elements `vertex` (x y z, red green blue), `face` (vertex_indices or vertex_index, red green blue) and
// `tristrips` (each strip as its triangles), in any order; `diffuse_red` and so on are also accepted as colours.
// Whole-number colours range to 255 (ushort: to 65535), real ones to 1. Everything else is skipped, elements with a
// note.
#include <difusa/core/tally.h>
#include <difusa/import/file_colours.h>
#include <difusa/import/ply_body.h>
#include <difusa/import/reader.h>
#include <difusa/plugin/plugin.h>

#include <algorithm>
#include <array>

namespace {

using namespace difusa;
using namespace difusa::ply;

// ---- body -----------------------------------------------------------------------------------------------------

/// Collects the rows of the elements in a soup.
template <class Values> class Body {
  public:
    Body(Values values, const Header& header, PolygonSoup& soup)
        : values_(std::move(values)), header_(header), soup_(soup) {}

    void read() {
        check_room();
        for (const Element& element : header_.elements) {
            read_element(element);
        }
        colours_.append_materials(1.0, soup_.materials);
        finish(values_.scanner());
        if (!others_.empty()) {
            soup_.notes.push_back("elements without surface were ignored: " + others_.substr(0, 200));
        }
        note_opacity(translucent_, soup_.notes);
    }

    // The sink interface of read_rows.

    static Expected expected(const Element& element, const Property&, std::size_t row) {
        return {element.name.c_str(), row + 1, element.count};
    }
    static bool wants(const Property& property) { return property.role != nothing; }

    void check_length(const Property&, std::int64_t length, const Expected& expected) const {
        if (length < 0 || static_cast<std::size_t>(length) > values_.available()) {
            values_.fail("a list of " + expected.text() + " announces " + std::to_string(length) +
                         " entries, which is impossible: the file is damaged; export it again");
        }
    }
    void begin_row() { row_.line = values_.line(); }

    void value(const Property& property, double value, const Expected& expected) {
        if (property.role >= red) {
            const double one = is_real(property.type) ? 1.0 : (property.type == Type::uint16 ? 65535.0 : 255.0);
            value /= one;
            if (!(value >= 0.0 && value <= 1.0)) {
                values_.fail("the property " + excerpt(property.name) + " of " + expected.text() +
                             " is out of range: colours of a real type range from 0 to 1, of a whole-number "
                             "type from 0 to 255 (ushort: 65535)");
            }
            if (property.role == alpha && value != 1.0) {
                translucent_.add(values_.place());
            }
        }
        row_.value[property.role] = value;
    }

    void corners(std::vector<std::int64_t>& list) { row_.corners.swap(list); }

    void end_row() {
        switch (kind_) {
        case Element::Kind::points:
            soup_.points.emplace_back(row_.value[x], row_.value[y], row_.value[z]);
            if (row_.line > 0) {
                soup_.point_line.push_back(row_.line);
            }
            if (coloured_) {
                soup_.point_reflectance.push_back(colour());
            }
            break;
        case Element::Kind::faces:
            add_face(coloured_ ? colours_.intern(colour()) : none);
            break;
        case Element::Kind::strips:
            add_strips();
            break;
        case Element::Kind::other:
            break;
        }
    }

  private:
    struct Row {
        std::array<double, value_count> value{};
        std::vector<std::int64_t> corners;
        std::uint32_t line = 0;
    };

    /// Rejects counts that do not fit into the rest of the file.
    void check_room() const {
        const double least = least_bytes<Values>(header_);
        if (least > static_cast<double>(values_.available())) {
            values_.fail("the header announces at least " + std::to_string(static_cast<std::uint64_t>(least)) +
                         " bytes of data, but only " + std::to_string(values_.available()) +
                         " follow: the file is truncated or its header is wrong; export it again");
        }
    }

    void read_element(const Element& element) {
        if (element.properties.empty()) {
            return;
        }
        if (element.kind == Element::Kind::other && element.count > 0) {
            others_ += (others_.empty() ? "" : " ") + excerpt(element.name);
        }
        kind_ = element.kind;
        coloured_ = element.has(red) && element.has(green) && element.has(blue);
        if (!coloured_ && (element.has(red) || element.has(green) || element.has(blue))) {
            soup_.notes.push_back("the colours of the element " + excerpt(element.name) +
                                  " are ignored, since they lack red, green or blue");
        }
        row_ = {};
        const std::size_t faces_before = soup_.face_count();
        read_rows(values_, element, *this);
        if (element.kind == Element::Kind::strips) {
            soup_.notes.push_back("the triangle strips were read as " +
                                  std::to_string(soup_.face_count() - faces_before) + " triangles");
        }
    }

    void finish(TextScanner& scanner) {
        std::string_view token;
        if (scanner.next(token, TextScanner::Reach::file)) {
            scanner.fail("the file continues with " + excerpt(token) +
                         " after all its header announces: correct the header, or remove the excess");
        }
        if (scanner.ends_abruptly()) {
            soup_.notes.emplace_back(
                "the last line has no line end: if the file is truncated there, its last number is wrong");
        }
    }
    void finish(const ByteScanner& scanner) {
        if (scanner.remaining() > 0) {
            soup_.notes.push_back("the last " + std::to_string(scanner.remaining()) +
                                  " bytes of the file follow all its header announces, and were ignored");
        }
    }

    Rgb colour() const { return {row_.value[red], row_.value[green], row_.value[blue]}; }

    /// The number of a point, as used in soups.
    static Index corner(std::int64_t number) {
        return number < 0 || number >= none ? none : static_cast<Index>(number);
    }

    void add_face(Index material) {
        corners_.resize(row_.corners.size());
        std::transform(row_.corners.begin(), row_.corners.end(), corners_.begin(), corner);
        soup_.add_face(corners_, material, row_.line);
    }

    /// Triangle strips in sequence, each terminated by -1; every second triangle of a strip runs clockwise.
    void add_strips() {
        std::size_t start = 0;
        for (std::size_t k = 0; k < row_.corners.size(); ++k) {
            if (row_.corners[k] == -1) {
                start = k + 1;
            } else if (k >= start + 2) {
                const bool odd = (k - start) % 2 == 1;
                const std::array<Index, 3> triangle{corner(row_.corners[odd ? k - 1 : k - 2]),
                                                    corner(row_.corners[odd ? k - 2 : k - 1]), corner(row_.corners[k])};
                soup_.add_face(triangle, none, row_.line);
            }
        }
    }

    Values values_;
    const Header& header_;
    PolygonSoup& soup_;
    Element::Kind kind_ = Element::Kind::other; ///< of the element being read
    bool coloured_ = false;
    Row row_;
    ColourTable colours_;
    std::vector<Index> corners_;
    Tally translucent_{Values::unit};
    std::string others_; ///< names of the elements skipped
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
            Body(TextValues(scanner, Layout::lines), header, soup).read();
        } else {
            Body(ByteValues(content, soup.file, header), header, soup).read();
        }
        return soup;
    }
};

} // namespace

DIFUSA_PLUGIN(reader, "ply", PlyReader, "PLY polygons, text or binary in either byte order (.ply).", {})
