#include <difusa/import/ply_header.h>

#include <difusa/core/types.h>

#include <array>
#include <utility>

namespace difusa::ply {

namespace {

using Reach = TextScanner::Reach;

std::optional<Type> parse_type(std::string_view word) {
    constexpr std::array<std::array<std::string_view, 2>, 8> names{{{"char", "int8"},
                                                                    {"uchar", "uint8"},
                                                                    {"short", "int16"},
                                                                    {"ushort", "uint16"},
                                                                    {"int", "int32"},
                                                                    {"uint", "uint32"},
                                                                    {"float", "float32"},
                                                                    {"double", "float64"}}};
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (word == names[i][0] || word == names[i][1]) {
            return static_cast<Type>(i);
        }
    }
    return std::nullopt;
}

Role role_of(const Property& property, Element::Kind kind) {
    if (property.count_type) {
        const bool points = property.name == "vertex_indices" || property.name == "vertex_index";
        return (kind == Element::Kind::faces || kind == Element::Kind::strips) && points ? corners : nothing;
    }
    std::string_view name = property.name;
    constexpr std::array<std::string_view, value_count> names{"x", "y", "z", "red", "green", "blue", "alpha"};
    const bool diffuse = name.starts_with("diffuse_");
    name.remove_prefix(diffuse ? 8 : 0);
    const auto found = std::find(names.begin(), names.end(), name);
    const auto role = static_cast<Role>(found - names.begin());
    const bool wanted = found != names.end() && ((kind == Element::Kind::points && !(diffuse && role < red)) ||
                                                 (kind == Element::Kind::faces && role >= red));
    return wanted ? role : nothing;
}

class HeaderParser {
  public:
    HeaderParser(std::string_view content, TextScanner& scanner, bool surface)
        : content_(content), scanner_(scanner), surface_(surface) {}

    Header parse() {
        if (take("'ply'") != "ply") {
            scanner_.fail("the first word is not 'ply': this is not a PLY file; if it is another format, give it that "
                          "extension");
        }
        bool has_format = false;
        while (true) {
            scanner_.rest_of_line();
            const std::string_view word = take("a line of the header");
            if (word == "end_header") {
                break;
            }
            if (word == "format") {
                parse_format();
                has_format = true;
            } else if (word == "element") {
                parse_element();
            } else if (word == "property") {
                parse_property();
            } else if (word != "comment" && word != "obj_info") {
                scanner_.fail_unexpected(word, {"'element', 'property', 'comment' or 'end_header'"});
            }
        }
        if (!has_format) {
            scanner_.fail("the header has no line 'format': add 'format ascii 1.0' if the data are text");
        }
        check_elements();
        end_header();
        return std::move(header_);
    }

  private:
    std::string_view take(const char* expected) {
        std::string_view token;
        if (!scanner_.next(token, Reach::file)) {
            scanner_.fail_missing({expected}, Reach::file);
        }
        return token;
    }

    std::string_view take_here(const char* expected) {
        std::string_view token;
        if (!scanner_.next(token, Reach::line)) {
            scanner_.fail_missing({expected}, Reach::line);
        }
        return token;
    }

    void parse_format() {
        const std::string_view word = take_here("the format");
        if (word == "ascii") {
            header_.format = Format::text;
        } else if (word == "binary_little_endian") {
            header_.format = Format::little_endian;
        } else if (word == "binary_big_endian") {
            header_.format = Format::big_endian;
        } else {
            scanner_.fail_unexpected(word, {"'ascii', 'binary_little_endian' or 'binary_big_endian'"});
        }
        const std::string_view version = take_here("the version 1.0");
        if (version != "1.0") {
            scanner_.fail_unexpected(version, {"the version 1.0"});
        }
    }

    void parse_element() {
        Element element;
        element.name = take_here("the name of an element");
        element.kind = element.name == "vertex"      ? Element::Kind::points
                       : element.name == "face"      ? Element::Kind::faces
                       : element.name == "tristrips" ? Element::Kind::strips
                                                     : Element::Kind::other;
        const std::int64_t count = scanner_.integer({"the number of elements"}, Reach::line);
        if (count < 0 || count >= none) {
            scanner_.fail("the number of elements is " + std::to_string(count) +
                          ", which is impossible: export the file again");
        }
        element.count = static_cast<std::size_t>(count);
        if (element.kind != Element::Kind::other &&
            std::any_of(header_.elements.begin(), header_.elements.end(),
                        [&](const Element& other) { return other.name == element.name; })) {
            scanner_.fail("the element " + excerpt(element.name) + " occurs twice: export the file again");
        }
        header_.elements.push_back(std::move(element));
    }

    void parse_property() {
        if (header_.elements.empty()) {
            scanner_.fail("a property comes before the first element: export the file again");
        }
        Element& element = header_.elements.back();
        Property property;
        std::string_view word = take_here("the type of a property");
        if (word == "list") {
            property.count_type = type(take_here("the type of a list's length"));
            if (is_real(*property.count_type)) {
                scanner_.fail("the length of a list must have a whole-number type: export the file again");
            }
            word = take_here("the type of a list's entries");
        }
        property.type = type(word);
        property.name = take_here("the name of a property");
        property.role = role_of(property, element.kind);
        // Only meaningful names are compared, so that a header with a million properties is read in linear time.
        if (property.role != nothing &&
            std::any_of(element.properties.begin(), element.properties.end(),
                        [&](const Property& other) { return other.name == property.name; })) {
            scanner_.fail("the element " + excerpt(element.name) + " has the property " + excerpt(property.name) +
                          " twice: export the file again");
        }
        if (property.role != nothing && element.has(property.role)) {
            property.role = nothing; // `red` and `diffuse_red`: the first is used
        }
        if (property.role == corners && is_real(property.type)) {
            scanner_.fail("point numbers must have a whole-number type: export the file again");
        }
        element.properties.push_back(std::move(property));
    }

    Type type(std::string_view word) const {
        const std::optional<Type> type = parse_type(word);
        if (!type) {
            scanner_.fail_unexpected(
                word, {"a type (char uchar short ushort int uint float double, or int8 uint8 ... float64)"});
        }
        return *type;
    }

    void check_elements() const {
        const auto find = [this](Element::Kind kind) {
            return std::find_if(header_.elements.begin(), header_.elements.end(),
                                [kind](const Element& element) { return element.kind == kind; });
        };
        const auto points = find(Element::Kind::points);
        if (points == header_.elements.end() || !points->has(x) || !points->has(y) || !points->has(z)) {
            scanner_.fail("the header announces no element 'vertex' with the properties x, y and z: export the mesh "
                          "again");
        }
        const auto faces = find(Element::Kind::faces), strips = find(Element::Kind::strips);
        if (surface_ && faces == header_.elements.end() && strips == header_.elements.end()) {
            scanner_.fail("the header announces no element 'face': a cloud of points has no surface; reconstruct one "
                          "first");
        }
        for (const auto& element : {faces, strips}) {
            if (element != header_.elements.end() && !element->has(corners)) {
                scanner_.fail("the element " + excerpt(element->name) +
                              " has no list 'vertex_indices' of its corners: export the mesh again");
            }
        }
    }

    /// Binary data begin right after the line end, which is CR LF only if the header's other line ends are: a CR LF
    /// could otherwise be a CR and the first byte of the data.
    void end_header() {
        if (header_.format == Format::text) {
            return;
        }
        const std::size_t first = std::min(content_.find_first_of("\r\n"), content_.size());
        const std::string_view line_end = content_.substr(first, 2) == "\r\n" ? "\r\n" : content_.substr(first, 1);
        const bool more = !scanner_.rest_of_line().empty();
        if (more || !content_.substr(scanner_.offset()).starts_with(line_end)) {
            scanner_.fail("the line 'end_header' must end like the other lines of the header: export the file again");
        }
        header_.bytes = scanner_.offset() + line_end.size();
    }

    std::string_view content_;
    TextScanner& scanner_;
    bool surface_;
    Header header_;
};

} // namespace

Header parse_header(std::string_view content, TextScanner& scanner, bool surface) {
    return HeaderParser(content, scanner, surface).parse();
}

} // namespace difusa::ply
