// reader stl: stereolithography triangles, text and binary.
//
// Each facet has its own points; the diagnosis merges equal ones. Normals follow from the facets' corners, in the
// counterclockwise order prescribed by the format; stored ones that point the other way are noted. A file is binary if
// its size matches its count of facets, whatever its first word is: many binary files begin with "solid".
#include <difusa/core/error.h>
#include <difusa/core/tally.h>
#include <difusa/import/byte_scanner.h>
#include <difusa/import/reader.h>
#include <difusa/import/stored_normals.h>
#include <difusa/import/text_scanner.h>
#include <difusa/plugin/plugin.h>

#include <algorithm>

namespace {

using namespace difusa;
using Reach = TextScanner::Reach;

constexpr std::size_t header_bytes = 84; // 80 of arbitrary content, and the number of facets
constexpr std::size_t facet_bytes = 50;  // 12 floats and a 16-bit attribute

void note_normals(const Tally& against, PolygonSoup& soup) {
    against.note("facets whose normal points to their back",
                 "the order of the corners decides which side is the front, and the normals are ignored", soup.notes);
}

bool begins_with_solid(std::string_view content) {
    content.remove_prefix(content.starts_with("\xef\xbb\xbf") ? 3 : 0);
    content.remove_prefix(std::min(content.find_first_not_of(" \t\r\n\v\f"), content.size()));
    return lower_case(content.substr(0, 5)) == "solid";
}

/// Bytes that cannot occur in text, among the first ones.
bool has_control_bytes(std::string_view content) {
    const std::string_view front = content.substr(0, 512);
    return std::any_of(front.begin(), front.end(), [](char c) {
        const auto byte = static_cast<unsigned char>(c);
        return byte < 0x20 && (byte < '\t' || byte > '\r');
    });
}

class StlText {
  public:
    StlText(std::string_view content, PolygonSoup& soup) : scanner_(content, soup.file, {}), soup_(soup) {}

    void read() {
        while (scanner_.to_token()) {
            read_solid();
        }
        note_normals(against_normals_, soup_);
    }

  private:
    void read_solid() {
        expect("solid");
        scanner_.rest_of_line(); // its name
        while (true) {
            const std::string word = take("'facet' or 'endsolid'");
            if (word == "endsolid") {
                scanner_.rest_of_line();
                return;
            }
            if (word != "facet") {
                scanner_.fail_unexpected(word, {"'facet' or 'endsolid'"});
            }
            read_facet();
        }
    }

    void read_facet() {
        const std::uint32_t line = scanner_.line();
        expect("normal");
        Vec3 normal;
        for (int k = 0; k < 3; ++k) {
            normal[k] = scanner_.real({"a component of a facet's normal"}, Reach::file);
        }
        expect("outer");
        expect("loop");
        corners_.clear();
        while (true) {
            const std::string word = take("'vertex' or 'endloop'");
            if (word == "endloop") {
                break;
            }
            if (word != "vertex") {
                scanner_.fail_unexpected(word, {"'vertex' or 'endloop'"});
            }
            read_vertex();
        }
        expect("endfacet");
        soup_.add_face(corners_, none, line);
        if (turned_against(soup_, soup_.face_count() - 1, normal)) {
            against_normals_.add(line);
        }
    }

    void read_vertex() {
        soup_.point_line.push_back(scanner_.line());
        Vec3 point;
        for (int k = 0; k < 3; ++k) {
            point[k] = scanner_.real({"a coordinate of a vertex"}, Reach::file);
        }
        corners_.push_back(static_cast<Index>(soup_.points.size()));
        soup_.points.push_back(point);
        if (soup_.points.size() >= none) {
            scanner_.fail("the mesh has more than 2^32 points: split it");
        }
    }

    std::string take(const char* expected) {
        std::string_view token;
        if (!scanner_.next(token, Reach::file)) {
            scanner_.fail_missing({expected}, Reach::file);
        }
        return lower_case(token);
    }

    void expect(const char* word) {
        const std::string token = take(word);
        if (token != word) {
            scanner_.fail_unexpected(token, {word});
        }
    }

    TextScanner scanner_;
    PolygonSoup& soup_;
    std::vector<Index> corners_;
    Tally against_normals_;
};

Vec3 take_vector(ByteScanner& scanner, const Expected& expected) {
    Vec3 vector;
    for (int k = 0; k < 3; ++k) {
        vector[k] = static_cast<double>(scanner.take<float>(expected));
    }
    return vector;
}

void read_binary(std::string_view content, PolygonSoup& soup) {
    ByteScanner scanner(content, soup.file, std::endian::little, header_bytes - 4);
    const std::size_t facets = scanner.take<std::uint32_t>({"the number of facets"});
    const std::size_t possible = scanner.remaining() / facet_bytes;
    if (facets > possible) {
        scanner.fail("the header announces " + std::to_string(facets) + " facets of 50 bytes, but only " +
                     std::to_string(scanner.remaining()) +
                     " bytes follow: the file is truncated or is not an STL file; export it again");
    }
    if (3 * facets >= none) {
        scanner.fail("the mesh has more than 2^32 points: split it");
    }
    soup.points.reserve(3 * facets);
    soup.corners.reserve(3 * facets);
    soup.first_corner.reserve(facets + 1);
    soup.face_material.reserve(facets);
    soup.face_line.reserve(facets);
    Tally coloured{"byte"}, against_normals{"byte"};
    for (std::size_t f = 0; f < facets; ++f) {
        const Expected expected{"facet", f + 1, facets};
        const std::size_t place = scanner.offset();
        const Vec3 normal = take_vector(scanner, expected);
        std::array<Index, 3> corners;
        for (Index& corner : corners) {
            corner = static_cast<Index>(soup.points.size());
            soup.points.push_back(take_vector(scanner, expected));
        }
        soup.add_face(corners, none, 0);
        if (turned_against(soup, f, normal)) {
            against_normals.add(place);
        }
        if ((scanner.take<std::uint16_t>(expected) & 0x8000U) != 0) {
            coloured.add(scanner.offset() - 2);
        }
    }
    note_normals(against_normals, soup);
    coloured.note(
        "facets with colour bits in their attribute",
        "there are two conflicting conventions for them, and they are ignored: export as PLY, OFF or OBJ to keep "
        "colours",
        soup.notes);
    if (scanner.remaining() > 0) {
        soup.notes.push_back("the last " + std::to_string(scanner.remaining()) +
                             " bytes of the file follow the facets its header announces, and were ignored");
    }
}

class StlReader final : public Reader {
  public:
    explicit StlReader(const Parameters&) {}

    std::vector<std::string> extensions() const override { return {"stl", "stla", "stlb"}; }

    PolygonSoup read(const std::filesystem::path& file) const override { return parse(read_file(file), file); }

    PolygonSoup parse(std::string_view content, const std::filesystem::path& name) const override {
        PolygonSoup soup;
        soup.file = name.string();
        const bool text = begins_with_solid(content) && !has_control_bytes(content);
        if (content.size() < header_bytes && !text) {
            throw InputError(soup.file + ": does not begin with the word solid, and " + std::to_string(content.size()) +
                             " bytes are less than the 84 of the header of a binary STL file: it is truncated or "
                             "in another format");
        }
        if (text && !has_binary_size(content)) {
            StlText(content, soup).read();
        } else if (has_binary_size(content) || has_control_bytes(content)) {
            read_binary(content, soup);
        } else {
            throw InputError(soup.file + ": is text that does not begin with the word solid: this is not an STL "
                                         "file; if it is in another format, give it that extension");
        }
        return soup;
    }

  private:
    static bool has_binary_size(std::string_view content) {
        if (content.size() < header_bytes) {
            return false;
        }
        ByteScanner scanner(content, {}, std::endian::little, header_bytes - 4);
        const std::size_t facets = scanner.take<std::uint32_t>({"the number of facets"});
        return scanner.remaining() == facets * facet_bytes;
    }
};

} // namespace

DIFUSA_PLUGIN(reader, "stl", StlReader, "STL triangles, text or binary (.stl).", {})
