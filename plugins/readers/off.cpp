// reader off: Object File Format of Geomview, text and binary.
//
// Read: OFF with any of the prefixes ST, C and N (texture coordinates and normals are skipped), with or without the
// keyword, polygons of any size, colours of points (after C) and of faces. Rejected, with a message: 4OFF and nOFF,
// whose points do not have three coordinates. A face colour that is a single number is an index into a colour map
// stored elsewhere: noted, and ignored.
#include <difusa/core/error.h>
#include <difusa/core/tally.h>
#include <difusa/import/byte_scanner.h>
#include <difusa/import/file_colours.h>
#include <difusa/import/reader.h>
#include <difusa/plugin/plugin.h>

#include <optional>

namespace {

using namespace difusa;
using Reach = TextScanner::Reach;

/// What the keyword says about points.
struct OffLayout {
    bool texture = false, colour = false, normal = false;
};

struct Counts {
    std::size_t points = 0, faces = 0;
};

/// The keyword's prefixes, or nothing if it is not an OFF keyword. Geomview writes them in the order ST, C, N, MeshLab
/// in a different one; the numbers of a point have the same order in both.
std::optional<OffLayout> parse_keyword(std::string_view word) {
    OffLayout layout;
    for (bool found = true; found;) {
        const auto take = [&word, &found](std::string_view prefix, bool& there) {
            if (!there && word.starts_with(prefix)) {
                word.remove_prefix(prefix.size());
                there = found = true;
            }
        };
        found = false;
        take("ST", layout.texture);
        take("C", layout.colour);
        take("N", layout.normal);
    }
    // The keyword is in capitals, but `off` is unambiguous.
    return word == "OFF" || word == "off" || word == "Off" ? std::optional(layout) : std::nullopt;
}

bool is_other_dimension(std::string_view word) {
    return word.size() > 3 && word.ends_with("OFF") && word.find_first_of("4n") != std::string_view::npos &&
           word.find_first_not_of("STCN4n") == word.size() - 3;
}

/// Rejects counts that do not fit into the rest of the file, given the minimum bytes per point and face.
template <class Scanner>
Counts checked(std::int64_t points, std::int64_t faces, double point_bytes, double face_bytes, std::size_t available,
               const Scanner& scanner, const std::string& remedy) {
    if (points < 0 || faces < 0) {
        scanner.fail("the header announces " + std::to_string(points) + " points and " + std::to_string(faces) +
                     " faces, but a count cannot be negative: the header is wrong; " + remedy);
    }
    if (points >= none || static_cast<double>(points) * point_bytes + static_cast<double>(faces) * face_bytes >
                              static_cast<double>(available)) {
        scanner.fail("the header announces " + std::to_string(points) + " points and " + std::to_string(faces) +
                     " faces, which is impossible in the " + std::to_string(available) +
                     " bytes that follow: the file is truncated or its header is wrong; " + remedy);
    }
    return {static_cast<std::size_t>(points), static_cast<std::size_t>(faces)};
}

Index corner(std::int64_t number) {
    return number < 0 || number >= none ? none : static_cast<Index>(number);
}

void note_map_indices(const Tally& faces, PolygonSoup& soup) {
    faces.note("faces whose colour is an index into a colour map", "the map is not read, they have no colour",
               soup.notes);
}

// ---- text -----------------------------------------------------------------------------------------------------

class OffText {
  public:
    OffText(const TextScanner& scanner, OffLayout layout, PolygonSoup& soup)
        : scanner_(scanner), layout_(layout), soup_(soup) {}

    void read() {
        const Counts counts = read_counts();
        // Geomview ignores line ends between points. If there are enough lines for one point or face on each, they
        // matter here: a line with too many or too few numbers is damage, and is best reported where it is.
        reach_ = scanner_.count_lines() >= counts.points + counts.faces ? Reach::line : Reach::file;
        soup_.points.reserve(counts.points);
        soup_.point_line.reserve(counts.points);
        for (std::size_t i = 0; i < counts.points; ++i) {
            read_point(i + 1, counts.points);
        }
        soup_.first_corner.reserve(counts.faces + 1);
        soup_.face_material.reserve(counts.faces);
        soup_.face_line.reserve(counts.faces);
        for (std::size_t f = 0; f < counts.faces; ++f) {
            read_face(f + 1, counts.faces);
        }
        std::string_view token;
        if (scanner_.next(token, Reach::file)) {
            scanner_.fail("the file continues with " + excerpt(token) + " after the " + std::to_string(counts.points) +
                          " points and " + std::to_string(counts.faces) +
                          " faces its header announces: correct the header, or remove the excess");
        }
        colours_.finish(scanner_, soup_);
        note_map_indices(map_indices_, soup_);
        if (scanner_.ends_abruptly()) {
            soup_.notes.emplace_back(
                "the last line has no line end: if the file is truncated there, its last number is wrong");
        }
    }

  private:
    /// "points faces edges"; the number of edges is meaningless, and some writers omit it.
    Counts read_counts() {
        const std::int64_t points = scanner_.integer({"the number of points"}, Reach::file);
        const std::uint32_t line = scanner_.line();
        const std::int64_t faces = scanner_.integer({"the number of faces"}, Reach::file);
        const bool same_line = scanner_.line() == line;
        if (!scanner_.at_line_end() || !same_line) {
            scanner_.integer({"the number of edges"}, Reach::file);
        }
        // A digit and a blank for each number; the last one may lack the blank. Colours may be missing, see below.
        const double numbers = 3 + 3 * layout_.normal + 2 * layout_.texture;
        return checked(points, faces, 2 * numbers, 2, scanner_.remaining() + 1, scanner_, "export it again");
    }

    void read_point(std::size_t number, std::size_t total) {
        const Expected expected{"a coordinate of point", number, total};
        Vec3 point;
        point[0] = scanner_.real(expected, Reach::file);
        soup_.point_line.push_back(scanner_.line());
        point[1] = scanner_.real(expected, reach_);
        point[2] = scanner_.real(expected, reach_);
        soup_.points.push_back(point);
        for (int k = 0; layout_.normal && k < 3; ++k) {
            scanner_.real({"a component of the normal of point", number, total}, reach_);
        }
        if (layout_.colour) {
            read_point_colour({"a colour component of point", number, total});
        }
        if (reach_ == Reach::file) {
            for (int k = 0; layout_.texture && k < 2; ++k) {
                scanner_.real({"a texture coordinate of point", number, total}, reach_);
            }
        } else if (!layout_.colour) {
            end_point_line(layout_.texture ? 2 : 0);
        }
    }

    /// On its own line a point has 3 or 4 colour components, or no point of the file has any: some writers use COFF
    /// when only faces have colours. In a stream it has 4.
    void read_point_colour(const Expected& expected) {
        words_.clear();
        std::string_view token;
        if (reach_ == Reach::file) {
            while (words_.size() < 4 && scanner_.next(token, reach_)) {
                words_.push_back(token);
            }
            if (words_.size() < 4) {
                scanner_.fail_missing(expected, reach_);
            }
        } else {
            const std::size_t texture = layout_.texture ? 2 : 0;
            while (scanner_.next(token, Reach::line)) {
                words_.push_back(token);
            }
            if (words_.size() == texture && soup_.point_reflectance.empty()) {
                return;
            }
            if (words_.size() < 3 + texture) {
                scanner_.fail_missing(expected, reach_);
            }
            if (soup_.point_reflectance.size() + 1 < soup_.points.size()) {
                scanner_.fail("the point has a colour, but those before it have none: complete or remove the colours");
            }
            words_.resize(words_.size() - texture);
            if (words_.size() > 4) {
                scanner_.fail_unexpected(words_[4], {"the end of the line after a point and its colour"});
            }
        }
        soup_.point_reflectance.push_back(colours_.read(words_, scanner_));
    }

    void end_point_line(int numbers) {
        std::string_view token;
        for (int k = 0; scanner_.next(token, Reach::line); ++k) {
            if (k == numbers) {
                scanner_.fail("the line has more numbers than a point of this file; if they are colours, the first "
                              "word of the file must be COFF, if normals NOFF; otherwise correct the line");
            }
        }
    }

    void read_face(std::size_t number, std::size_t total) {
        const std::int64_t size = scanner_.integer({"the number of corners of face", number, total}, Reach::file);
        const std::uint32_t line = scanner_.line();
        if (size < 0 || static_cast<std::size_t>(size) > scanner_.remaining()) {
            scanner_.fail("face " + std::to_string(number) + " of " + std::to_string(total) + " announces " +
                          std::to_string(size) + " corners, which is impossible: correct the line");
        }
        corners_.clear();
        for (std::int64_t k = 0; k < size; ++k) {
            corners_.push_back(corner(scanner_.integer({"a point number of face", number, total}, reach_)));
        }
        soup_.add_face(corners_, read_face_colour(), line);
    }

    /// The rest of the line.
    Index read_face_colour() {
        words_.clear();
        std::string_view token;
        while (scanner_.next(token, Reach::line)) {
            words_.push_back(token);
        }
        std::int64_t map_index = 0;
        switch (words_.size()) {
        case 0:
            return none;
        case 1:
            if (!parse_integer(words_[0], map_index)) {
                scanner_.fail_unexpected(words_[0], {"a colour or the end of the line"});
            }
            map_indices_.add(scanner_.line());
            return none;
        case 3:
        case 4:
            return colours_.face_material(colours_.read(words_, scanner_));
        default:
            scanner_.fail("the corners of a face are followed by its colour, which has 3 or 4 components, not " +
                          std::to_string(words_.size()) + ": correct the line");
        }
    }

    TextScanner scanner_;
    OffLayout layout_;
    PolygonSoup& soup_;
    FileColours colours_;
    Reach reach_ = Reach::line;
    std::vector<std::string_view> words_;
    std::vector<Index> corners_;
    Tally map_indices_;
};

// ---- binary: 32-bit big-endian numbers ------------------------------------------------------------------------

class BinaryFile {
  public:
    BinaryFile(const ByteScanner& scanner, OffLayout layout, PolygonSoup& soup)
        : scanner_(scanner), layout_(layout), soup_(soup) {}

    void read() {
        const auto points = scanner_.take<std::int32_t>({"the number of points"});
        const auto faces = scanner_.take<std::int32_t>({"the number of faces"});
        scanner_.take<std::int32_t>({"the number of edges"});
        const double numbers = 3 + 3 * layout_.normal + 4 * layout_.colour + 2 * layout_.texture;
        const Counts counts = checked(points, faces, 4 * numbers, 8, scanner_.remaining(), scanner_,
                                      "or its numbers are not big-endian, as those of a binary OFF file must be: "
                                      "export it as text");
        for (std::size_t i = 0; i < counts.points; ++i) {
            read_point({"point", i + 1, counts.points});
        }
        for (std::size_t f = 0; f < counts.faces; ++f) {
            read_face({"face", f + 1, counts.faces});
        }
        table_.append_materials(1.0, soup_.materials);
        note_opacity(translucent_, soup_.notes);
        note_map_indices(map_indices_, soup_);
        if (scanner_.remaining() > 0) {
            soup_.notes.push_back("the last " + std::to_string(scanner_.remaining()) +
                                  " bytes of the file follow what its header announces, and were ignored");
        }
    }

  private:
    void read_point(const Expected& expected) {
        Vec3 point;
        for (int k = 0; k < 3; ++k) {
            point[k] = static_cast<double>(scanner_.take<float>(expected));
        }
        soup_.points.push_back(point);
        scanner_.skip(layout_.normal ? 12 : 0, expected);
        if (layout_.colour) {
            soup_.point_reflectance.push_back(read_colour(4, expected));
        }
        scanner_.skip(layout_.texture ? 8 : 0, expected);
    }

    void read_face(const Expected& expected) {
        const auto size = scanner_.take<std::int32_t>(expected);
        if (size < 0 || static_cast<std::size_t>(size) > scanner_.remaining() / 4) {
            scanner_.fail(expected.text() + " announces " + std::to_string(size) +
                          " corners, which is impossible: the file is damaged; export it again");
        }
        corners_.clear();
        for (std::int32_t k = 0; k < size; ++k) {
            corners_.push_back(corner(scanner_.take<std::int32_t>(expected)));
        }
        Index material = none;
        switch (const auto components = scanner_.take<std::int32_t>(expected); components) {
        case 0:
            break;
        case 1:
            map_indices_.add(scanner_.offset());
            scanner_.skip(4, expected);
            break;
        case 3:
        case 4:
            material = table_.intern(read_colour(components, expected));
            break;
        default:
            scanner_.fail("a colour has 0, 1, 3 or 4 components, not " + std::to_string(components) +
                          ": the file is damaged; export it again");
        }
        soup_.add_face(corners_, material, 0);
    }

    Rgb read_colour(int components, const Expected& expected) {
        Rgb colour;
        for (int k = 0; k < 3; ++k) {
            colour[k] = static_cast<double>(scanner_.take<float>(expected));
        }
        if (!(colour >= 0.0).all() || !(colour <= 1.0).all()) {
            scanner_.fail("a colour component of " + expected.text() +
                          " is not between 0 and 1: correct the colours, or export the file without");
        }
        if (components == 4 && scanner_.take<float>(expected) != 1.0F) {
            translucent_.add(scanner_.offset() - 4);
        }
        return colour;
    }

    ByteScanner scanner_;
    OffLayout layout_;
    PolygonSoup& soup_;
    ColourTable table_;
    std::vector<Index> corners_;
    Tally map_indices_{"byte"}, translucent_{"byte"};
};

// ---- both -----------------------------------------------------------------------------------------------------

class OffReader final : public Reader {
  public:
    explicit OffReader(const Parameters&) {}

    std::vector<std::string> extensions() const override { return {"off", "coff", "noff", "cnoff", "stoff"}; }

    PolygonSoup read(const std::filesystem::path& file) const override { return parse(read_file(file), file); }

    PolygonSoup parse(std::string_view content, const std::filesystem::path& name) const override {
        PolygonSoup soup;
        soup.file = name.string();
        TextScanner scanner(content, soup.file, {.comments = true});
        const TextScanner start = scanner;
        std::string_view word;
        if (!scanner.next(word, Reach::file)) {
            scanner.fail("the file contains only blanks and comments: export the mesh again");
        }
        const std::optional<OffLayout> layout = parse_keyword(word);
        std::int64_t count = 0;
        if (!layout && parse_integer(word, count)) {
            soup.notes.emplace_back("the file does not begin with the word OFF; it was read as if it did");
            OffText(start, OffLayout{}, soup).read();
            return soup;
        }
        if (!layout && is_other_dimension(word)) {
            scanner.fail("the first word is " + excerpt(word) +
                         ", a mesh whose points do not have three coordinates: export it as OFF");
        }
        if (!layout) {
            scanner.fail("the first word is " + excerpt(word) +
                         ", not OFF (with prefixes ST, C, N as needed): this is not an OFF file; if it is another "
                         "format, give it that extension");
        }
        TextScanner after = scanner;
        if (after.next(word, Reach::line) && word == "BINARY") {
            after.rest_of_line();
            const std::size_t line_end = content.substr(after.offset()).starts_with("\r\n") ? 2 : 1;
            BinaryFile(ByteScanner(content, soup.file, std::endian::big, after.offset() + line_end), *layout, soup)
                .read();
        } else {
            OffText(scanner, *layout, soup).read();
        }
        return soup;
    }
};

} // namespace

DIFUSA_PLUGIN(reader, "off", OffReader, "OFF and COFF polygon meshes, text or binary (.off .coff).", {})
