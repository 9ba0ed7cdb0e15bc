// reader obj: Wavefront OBJ polygons, with the materials of its MTL libraries.
//
// Read: v (with colours after the coordinates), vt, f (including relative indices), usemtl, mtllib, continued lines;
// the images named by map_Kd and map_Ke of the materials. Skipped: groups, smoothing. Noted: lines, points, free-form
// surfaces, unknown statements, missing materials, libraries and images, normals (vn) against the order of the corners,
// which decides. The format does not say which way is up; most files mean y.
//
// tinyobjloader 2.0 is not used: its numbers are off by an ulp, NaN and anything that is not a number read as 0, a
// polygon has at most 255 corners, faces lose their line numbers, and a continued line is an error.
#include <difusa/core/error.h>
#include <difusa/core/tally.h>
#include <difusa/core/text.h>
#include <difusa/import/file_colours.h>
#include <difusa/import/material_library.h>
#include <difusa/import/reader.h>
#include <difusa/import/stored_normals.h>
#include <difusa/import/texture_files.h>
#include <difusa/plugin/plugin.h>
#include <difusa/repair/texture_coordinates.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <unordered_set>

namespace {

using namespace difusa;
using Reach = TextScanner::Reach;

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

class ObjFile {
  public:
    ObjFile(std::string_view content, const std::filesystem::path& name, PolygonSoup& soup)
        : scanner_(content, soup.file, {.comments = true, .continuation = true}), folder_(name.parent_path()),
          soup_(soup) {
        soup_.up = Vec3::UnitY();
    }

    void read() {
        std::string_view word;
        while (scanner_.next(word, Reach::file)) {
            line_ = scanner_.line();
            statement(word);
        }
        if (soup_.points.empty() && soup_.face_count() == 0) {
            scanner_.fail("the file holds neither points (v) nor faces (f): this is not an OBJ file, or an empty one; "
                          "export the mesh again");
        }
        check_corners();
        compare_normals();
        finish_colours();
        finish_texture_coordinates();
        finish_materials();
        write_notes();
        settle_textures(soup_);
    }

  private:
    void statement(std::string_view word) {
        if (word == "v") {
            read_point();
        } else if (word == "vt") {
            read_texture_coordinates();
        } else if (word == "vn") {
            read_normal();
        } else if (word == "f" || word == "fo") {
            read_face();
        } else if (word == "usemtl") {
            use_material(scanner_.rest_of_line());
        } else if (word == "mtllib") {
            read_libraries(scanner_.rest_of_line());
        } else {
            pass_over(word);
        }
    }

    void pass_over(std::string_view word) {
        if (word == "l" || word == "p") {
            without_surface_.add(line_, excerpt(word));
        } else if (is_one_of(word, {"curv", "curv2", "surf", "call", "bzp", "bsp", "cdc", "cdp", "res"})) {
            free_form_.add(line_, excerpt(word));
        } else if (!is_one_of(word, {"vp",       "g",    "o",      "s",      "mg",        "bevel",      "c_interp",
                                     "d_interp", "lod",  "usemap", "maplib", "trace_obj", "shadow_obj", "cstype",
                                     "deg",      "bmat", "step",   "parm",   "trim",      "hole",       "scrv",
                                     "sp",       "end",  "con",    "ctech",  "stech"})) {
            unknown_.add(line_, excerpt(word));
        }
        // Not rest_of_line: the statement may continue after a `\`.
        while (scanner_.next(word, Reach::line)) {
        }
    }

    /// v x y z, then nothing, w, r g b, or r g b and opacity.
    void read_point() {
        words_.clear();
        std::string_view token;
        while (scanner_.next(token, Reach::line)) {
            words_.push_back(token);
        }
        Vec3 point;
        for (std::size_t k = 0; k < 3; ++k) {
            if (k == words_.size()) {
                scanner_.fail_missing({"a coordinate of a point"}, Reach::line);
            }
            if (!parse_real(words_[k], point[static_cast<Eigen::Index>(k)])) {
                scanner_.fail_unexpected(words_[k], {"a coordinate of a point"});
            }
        }
        if (soup_.points.size() + 1 >= none) {
            scanner_.fail("the mesh has more than 2^32 points: split it");
        }
        soup_.points.push_back(point);
        soup_.point_line.push_back(line_);
        switch (words_.size()) {
        case 3:
            break;
        case 4: {
            double weight = 0.0;
            if (!parse_real(words_[3], weight)) {
                scanner_.fail_unexpected(words_[3], {"the weight of a point or the end of the line"});
            }
            if (weight != 1.0) {
                weighted_.add(line_);
            }
            break;
        }
        case 6:
        case 7:
            add_colour(colours_.read(std::span(words_).subspan(3), scanner_));
            break;
        default:
            scanner_.fail("a point has 3 coordinates, and then a weight or a colour of 3 or 4 components, not " +
                          std::to_string(words_.size()) + " numbers: correct the line");
        }
    }

    void add_colour(const Rgb& colour) {
        soup_.point_reflectance.resize(soup_.points.size() - 1, Rgb::Constant(without_colour));
        soup_.point_reflectance.push_back(colour);
    }

    /// vt u, then nothing, v, or v and w.
    void read_texture_coordinates() {
        TextureCoordinates coordinates = TextureCoordinates::Zero();
        std::string_view token;
        int k = 0;
        for (; scanner_.next(token, Reach::line); ++k) {
            double value = 0.0;
            if (k == 3 || !parse_real(token, value)) {
                scanner_.fail_unexpected(token, {k == 3 ? "the end of the line" : "a texture coordinate"});
            }
            if (k < 2) {
                coordinates[k] = value;
            }
        }
        if (k == 0) {
            scanner_.fail_missing({"a texture coordinate"}, Reach::line);
        }
        if (coordinates_.size() + 1 >= none) {
            scanner_.fail("the mesh has more than 2^32 texture coordinates: split it");
        }
        coordinates_.push_back(coordinates);
    }

    /// Whatever it is: normals decide nothing.
    void read_normal() {
        Vec3 normal = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
        std::string_view token;
        for (Eigen::Index k = 0; scanner_.next(token, Reach::line); ++k) {
            if (k < 3 && !parse_real(token, normal[k])) {
                normal[k] = std::numeric_limits<double>::quiet_NaN();
            }
        }
        normals_.push_back(normal);
    }

    void read_face() {
        corners_.clear();
        std::string_view token;
        while (scanner_.next(token, Reach::line)) {
            corners_.push_back(parse_corner(token));
            read_texture_index(token);
            read_normal_index(token);
        }
        if (corners_.empty()) {
            scanner_.fail_missing({"a corner of a face"}, Reach::line);
        }
        soup_.add_face(corners_, material_, line_);
    }

    /// "point", "point/texture", "point//normal" or "point/texture/normal". Indices count from 1, or from -1 backwards
    /// from the latest point. Points may follow the faces that use them, see `check_corners`.
    Index parse_corner(std::string_view token) const {
        const std::size_t slash = std::min(token.find('/'), token.size());
        std::int64_t index = 0;
        if (!parse_integer(token.substr(0, slash), index) ||
            token.find_first_not_of("0123456789+-/", slash) != std::string_view::npos ||
            std::count(token.begin(), token.end(), '/') > 2) {
            scanner_.fail_unexpected(token, {"a corner of a face (point/texture/normal)"});
        }
        const auto points = static_cast<std::int64_t>(soup_.points.size());
        const std::string refers = "the face refers to point " + std::to_string(index);
        if (index == 0) {
            scanner_.fail_at(line_, refers + ", but OBJ numbers points from 1: correct the number, or export the file "
                                             "again");
        }
        const std::int64_t number = index > 0 ? index - 1 : points + index;
        if (number < 0) {
            scanner_.fail_at(line_, refers +
                                        ", which counts back from the latest point, but the lines before it have "
                                        "only " +
                                        counted(soup_.points.size(), "point") + ": correct the number");
        }
        if (number >= none) {
            scanner_.fail_at(line_, refers + ", but a mesh has less than 2^32 points: correct the number");
        }
        return static_cast<Index>(number);
    }

    /// The corners of all faces are points of the file.
    void check_corners() const {
        for (std::size_t f = 0; f < soup_.face_count(); ++f) {
            for (const Index corner : soup_.face(f)) {
                if (corner >= soup_.points.size()) {
                    scanner_.fail_at(
                        soup_.face_line[f],
                        "the face refers to point " + std::to_string(corner + std::uint64_t{1}) +
                            ", but the file has " + counted(soup_.points.size(), "point") +
                            " (OBJ numbers them from 1): correct the number or remove the face; if points are missing, "
                            "export the file again");
                }
            }
        }
    }

    /// The number after the second slash of a corner, `none` if there is none or it makes no sense.
    void read_normal_index(std::string_view token) {
        const std::size_t first = token.find('/'), second = token.find('/', std::min(first, token.size() - 1) + 1);
        std::int64_t index = 0;
        if (second == std::string_view::npos || !parse_integer(token.substr(second + 1), index)) {
            normal_indices_.push_back(none);
            return;
        }
        const std::int64_t number = index > 0 ? index - 1 : static_cast<std::int64_t>(normals_.size()) + index;
        normal_indices_.push_back(index == 0 || number < 0 || number >= none ? none : static_cast<Index>(number));
    }

    /// Counts the faces whose normals, on average, are against the order of their corners.
    void compare_normals() {
        for (std::size_t f = 0; !normals_.empty() && f < soup_.face_count(); ++f) {
            Vec3 sum = Vec3::Zero();
            for (std::size_t c = soup_.first_corner[f]; c < soup_.first_corner[f + 1]; ++c) {
                if (normal_indices_[c] < normals_.size()) {
                    sum += normals_[normal_indices_[c]];
                }
            }
            if (turned_against(soup_, f, sum)) {
                against_normals_.add(soup_.face_line[f]);
            }
        }
    }

    /// The number after the first slash of a corner, for `finish_texture_coordinates`.
    void read_texture_index(std::string_view token) {
        const std::size_t begin = std::min(token.find('/'), token.size() - 1) + 1;
        const std::string_view word = token.substr(begin, std::min(token.find('/', begin), token.size()) - begin);
        if (word.empty()) {
            texture_indices_.push_back(none);
            return;
        }
        std::int64_t index = 0;
        if (!parse_integer(word, index)) {
            scanner_.fail_unexpected(token, {"a corner of a face (point/texture/normal)"});
        }
        const std::int64_t number = index > 0 ? index - 1 : static_cast<std::int64_t>(coordinates_.size()) + index;
        texture_indices_.push_back(index == 0 || number < 0 || number >= beyond ? beyond : static_cast<Index>(number));
    }

    /// A file without any `vt` may contain any indices; in others they must exist.
    void finish_texture_coordinates() {
        if (coordinates_.empty()) {
            return;
        }
        soup_.corner_texture.reserve(texture_indices_.size());
        for (std::size_t f = 0; f < soup_.face_count(); ++f) {
            for (std::size_t c = soup_.first_corner[f]; c < soup_.first_corner[f + 1]; ++c) {
                const Index index = texture_indices_[c];
                if (index != none && index >= coordinates_.size()) {
                    scanner_.fail_at(soup_.face_line[f],
                                     "a corner of a face refers to texture coordinates that the file does not have (it "
                                     "has " +
                                         std::to_string(coordinates_.size()) + "): correct the number, or remove it");
                }
                soup_.corner_texture.push_back(index == none ? unplaced : coordinates_[index]);
            }
        }
    }

    /// Numbers stand for names until the libraries are read: `mtllib` may follow the faces.
    void use_material(std::string_view name) {
        if (name.empty()) {
            material_ = none;
            return;
        }
        const auto [place, is_new] = name_numbers_.try_emplace(std::string(name), static_cast<Index>(names_.size()));
        if (is_new) {
            names_.push_back({place->first, line_});
        }
        material_ = place->second;
    }

    /// One name, which may contain blanks, or several.
    void read_libraries(std::string_view names) {
        if (names.empty()) {
            scanner_.fail("mtllib names no file: write the name of the material library, or remove the line");
        }
        if (read_library(names, names)) {
            return;
        }
        TextScanner parts(names, soup_.file, {});
        std::string_view part;
        bool all_read = true;
        while (parts.next(part, Reach::line)) {
            all_read = (read_library(part, part) || read_library(part, file_name(part))) && all_read;
        }
        if (!all_read && !read_library(names, file_name(names))) {
            missing_libraries_.add(line_, excerpt(names));
        }
    }

    /// Exporters write paths of their own machine: the file may have been moved together with the OBJ file.
    static std::string_view file_name(std::string_view path) {
        return path.substr(path.find_last_of("/\\") + 1); // npos + 1 = 0
    }

    /// Reads the library `name` from the file `path`, relative to the OBJ file. False if there is no such file.
    bool read_library(std::string_view name, std::string_view path) {
        if (libraries_.contains(std::string(name))) {
            return true;
        }
        std::string portable(path);
        std::replace(portable.begin(), portable.end(), '\\', '/');
        for (const std::filesystem::path& candidate : {folder_ / std::string(path), folder_ / portable}) {
            std::error_code error;
            if (std::filesystem::is_regular_file(candidate, error)) {
                libraries_.insert(std::string(name));
                add_library(candidate);
                return true;
            }
        }
        return false;
    }

    void add_library(const std::filesystem::path& path) {
        soup_.files.push_back(path);
        std::error_code error;
        if (std::filesystem::file_size(path, error) == 0 && !error) {
            return; // a library without materials; those used will be reported as missing
        }
        MaterialLibrary library = parse_material_library(read_file(path), path.string());
        read_textures(library, path);
        for (Material& material : library.materials) {
            const auto number = static_cast<Index>(soup_.materials.size());
            if (defined_.try_emplace(material.name, number).second) {
                soup_.materials.push_back(std::move(material));
            } else {
                redefined_.add(line_, excerpt(material.name));
            }
        }
        soup_.notes.insert(soup_.notes.end(), library.notes.begin(), library.notes.end());
    }

    void read_textures(MaterialLibrary& library, const std::filesystem::path& path) {
        Tally missing;
        for (const TextureUse& use : library.textures) {
            Material& material = library.materials[use.material];
            const std::filesystem::path picture = find_beside(path.parent_path(), use.file);
            if (picture.empty()) {
                missing.add(use.line, excerpt(use.file));
                if (use.alone) {
                    (use.emission ? material.emission = Rgb::Zero() : material.reflectance = Material{}.reflectance);
                }
                continue;
            }
            const Texture::Wrap wrap = use.clamp ? Texture::Wrap::clamp : Texture::Wrap::repeat;
            (use.emission ? material.emission_texture : material.reflectance_texture) =
                textures_.texture(picture, wrap, wrap, use.placement);
        }
        missing.note(path.string() + ": missing texture images",
                     "only Kd and Ke are used (without Kd: 0.5); put the images next to the MTL file", library.notes);
    }

    void finish_colours() {
        if (soup_.point_reflectance.empty()) {
            return;
        }
        soup_.point_reflectance.resize(soup_.points.size(), Rgb::Constant(without_colour));
        colours_.finish(scanner_, soup_);
        std::size_t uncoloured = 0;
        for (Rgb& colour : soup_.point_reflectance) {
            if (std::isnan(colour[0])) {
                colour = Material{}.reflectance;
                ++uncoloured;
            }
        }
        if (uncoloured > 0) {
            soup_.notes.push_back(std::to_string(uncoloured) + " of " + std::to_string(soup_.points.size()) +
                                  " points have no colour although others do: their reflectance is 0.5");
        }
    }

    void finish_materials() {
        std::vector<Index> number(names_.size(), none);
        for (std::size_t i = 0; i < names_.size(); ++i) {
            const auto place = defined_.find(names_[i].name);
            if (place != defined_.end()) {
                number[i] = place->second;
            } else {
                undefined_.add(names_[i].line, excerpt(names_[i].name));
                Material material; // still a surface of its own
                material.name = names_[i].name;
                material.is_undefined = true;
                number[i] = static_cast<Index>(soup_.materials.size());
                soup_.materials.push_back(std::move(material));
            }
        }
        for (Index& material : soup_.face_material) {
            if (material != none) {
                material = number[material];
                faces_without_ += soup_.materials[material].is_undefined ? 1 : 0;
            }
        }
    }

    void write_notes() {
        std::vector<std::string>& notes = soup_.notes;
        textures_.report(soup_);
        missing_libraries_.note("mtllib lines with missing files", "put the files next to the OBJ file", notes);
        if (faces_without_ > 0) {
            undefined_.note("materials that are used but not defined",
                            "their faces, " + std::to_string(faces_without_) +
                                " in all, are like faces without a material, unless a scene file gives them another",
                            notes);
            soup_.undefined_note = notes.back();
        }
        redefined_.note("materials defined by more than one library", "the first definition is used", notes);
        without_surface_.note("lines of kind l or p", "they have no surface and are ignored", notes);
        free_form_.note("free-form or called statements", "export polygons, or their surface is missing", notes);
        unknown_.note("lines that begin with unknown words", "they are ignored", notes);
        against_normals_.note("faces whose normals (vn) point to their back",
                              "the order of the corners decides which side is the front, and the normals are ignored",
                              notes);
        weighted_.note("points with a weight other than 1", "weights are meaningless for polygons", notes);
        if (scanner_.ends_abruptly()) {
            soup_.notes.emplace_back(
                "the last line has no line end: if the file is truncated there, its last number is wrong");
        }
    }

    static constexpr double without_colour = std::numeric_limits<double>::quiet_NaN(); // until all points are read

    static constexpr Index beyond = none - 1; ///< index of nonexistent texture coordinates

    struct UsedName {
        std::string name;
        std::uint32_t line;
    };

    TextScanner scanner_;
    std::filesystem::path folder_;
    PolygonSoup& soup_;
    FileColours colours_;
    std::uint32_t line_ = 0; ///< where the current statement starts
    std::vector<std::string_view> words_;
    std::vector<Index> corners_;
    std::vector<TextureCoordinates> coordinates_;
    std::vector<Index> texture_indices_; ///< for each corner, `none` if it names no texture coordinates
    std::vector<Vec3> normals_;
    std::vector<Index> normal_indices_; ///< for each corner, `none` if it names no normal
    TextureFiles textures_;

    Index material_ = none; ///< number in `names_`
    std::vector<UsedName> names_;
    std::unordered_map<std::string, Index> name_numbers_;
    std::unordered_map<std::string, Index> defined_; ///< number in the soup's materials
    std::unordered_set<std::string> libraries_;      ///< read already
    std::size_t faces_without_ = 0;

    Tally missing_libraries_, undefined_, redefined_, without_surface_, free_form_, unknown_, weighted_,
        against_normals_;
};

class ObjReader final : public Reader {
  public:
    explicit ObjReader(const Parameters&) {}

    std::vector<std::string> extensions() const override { return {"obj"}; }

    PolygonSoup read(const std::filesystem::path& file) const override { return parse(read_file(file), file); }

    PolygonSoup parse(std::string_view content, const std::filesystem::path& name) const override {
        PolygonSoup soup;
        soup.file = name.string();
        ObjFile(content, name, soup).read();
        return soup;
    }
};

} // namespace

DIFUSA_PLUGIN(reader, "obj", ObjReader, "Wavefront OBJ polygons with MTL materials and their textures (.obj).", {})
