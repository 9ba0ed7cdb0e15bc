// tinyobjloader 2.0 reads MTL too, but silently reads `Kd 0.5` as a saturated red, and `Kd xyz ...`, `Kd 0,5 0,5 0,5`
// and a continued line as black or shifted, and is off by an ulp for numbers like 0.725.
#include <difusa/import/material_library.h>

#include <difusa/core/tally.h>
#include <difusa/import/text_scanner.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <unordered_set>

namespace difusa {

namespace {

using Reach = TextScanner::Reach;

/// The least Ns of a mirror. Exporters write 900 or 1000 for a surface without any roughness.
constexpr double polished = 900.0;

/// Statements that would make a surface look different.
constexpr std::array<std::string_view, 13> unsupported{"map_Ks", "map_Ns",   "map_Pr",   "map_Pm", "map_Ps",
                                                       "map_Tr", "map_bump", "map_Bump", "bump",   "norm",
                                                       "disp",   "decal",    "refl"};

class Parser {
  public:
    Parser(std::string_view content, const std::string& file)
        : file_(file), scanner_(content, file, {.comments = true, .continuation = true}) {}

    MaterialLibrary parse() {
        std::string_view word;
        while (scanner_.next(word, Reach::file)) {
            statement(word);
            scanner_.rest_of_line();
        }
        finish_material();
        write_notes();
        return std::move(library_);
    }

  private:
    void statement(std::string_view word) {
        if (word == "newmtl") {
            finish_material();
            begin_material();
        } else if (word == "Kd") {
            has_kd_ = colour("Kd", current().reflectance);
        } else if (word == "Ke") {
            has_ke_ = colour("Ke", current().emission);
        } else if (word == "Ks") {
            lenient_colour(specular_);
        } else if (word == "illum") {
            std::string_view token;
            scanner_.next(token, Reach::line);
            has_illum_3_ = token == "3";
            is_dull_ = token == "0" || token == "1";
        } else if (word == "Ns") {
            std::string_view token;
            double value = 0.0;
            if (scanner_.next(token, Reach::line) && parse_real(token, value)) {
                exponent_ = value;
            }
        } else if (word == "map_Kd" || word == "map_Ke") {
            texture(word == "map_Ke");
        } else if (word == "d" || word == "Tr") {
            opacity(word);
        } else if (word == "map_d") {
            add_translucent();
        } else if (word == "Pm") {
            std::string_view token;
            double metallic = 0.0;
            if (scanner_.next(token, Reach::line) && parse_real(token, metallic) && metallic > 0.0) {
                ignored_.add(scanner_.line(), excerpt(word));
            }
        } else if (std::find(unsupported.begin(), unsupported.end(), word) != unsupported.end()) {
            ignored_.add(scanner_.line(), excerpt(word));
        }
    }

    void begin_material() {
        line_ = scanner_.line();
        material_ = Material{};
        material_.name = scanner_.rest_of_line();
        if (material_.name.empty()) {
            scanner_.fail("newmtl has no name: write the name that the usemtl lines of the OBJ file use");
        }
        open_ = true;
        has_kd_ = has_ke_ = translucent_here_ = has_illum_3_ = is_dull_ = false;
        exponent_ = std::numeric_limits<double>::infinity();
        specular_ = Rgb::Zero();
        maps_ = {};
    }

    void finish_material() {
        if (!open_) {
            return;
        }
        if (!names_.insert(material_.name).second) {
            repeated_.add(line_);
            return;
        }
        if (!has_kd_ && maps_[0]) {
            material_.reflectance = Rgb::Ones();
        } else if (!has_kd_ && has_illum_3_ && (specular_ > 0.0).any()) {
            material_.reflectance = Rgb::Zero(); // nothing but a mirror, or gloss
        } else if (!has_kd_) {
            without_kd_.add(line_);
        }
        if (has_kd_ && maps_[0] && (material_.reflectance == 0.0).all()) {
            black_.add(line_);
        }
        if (!has_ke_ && maps_[1]) {
            material_.emission = Rgb::Ones();
        }
        if (has_illum_3_) {
            Rgb specular = specular_.max(0.0).min(1.0);
            const Rgb left = (1.0 - material_.reflectance).max(0.0);
            if ((specular > left).any()) {
                too_bright_.add(line_);
                specular = specular.min(left);
            }
            if (exponent_ >= polished) {
                material_.mirror = specular;
            } else if ((specular > 0.0).any()) {
                material_.gloss =
                    Gloss{{LobeShape::Model::phong, std::max(LobeShape::least_exponent, exponent_)}, specular};
            }
        } else if (!is_dull_ && (specular_ > 0.0).any()) {
            specular_unused_.add(line_);
        }
        for (std::optional<TextureUse>& use : maps_) {
            if (use) {
                use->alone = use->emission ? !has_ke_ : !has_kd_;
                library_.textures.push_back(std::move(*use));
            }
        }
        library_.materials.push_back(std::move(material_));
    }

    Material& current() {
        if (!open_) {
            scanner_.fail("a colour comes before the first newmtl: name its material");
        }
        return material_;
    }

    /// Three numbers, or one for all three. False, with a note, for the two unsupported notations.
    bool colour(const char* keyword, Rgb& value) {
        std::string_view token;
        if (!scanner_.next(token, Reach::line)) {
            scanner_.fail_missing({"the red component of a colour"}, Reach::line);
        }
        if (token == "spectral" || token == "xyz") {
            foreign_.add(scanner_.line());
            return false;
        }
        Rgb read;
        for (int k = 0; k < 3; ++k) {
            if (k > 0 && !scanner_.next(token, Reach::line)) {
                if (k == 1) {
                    value = Rgb::Constant(read[0]);
                    return true;
                }
                scanner_.fail(std::string(keyword) + " has two numbers: write one for grey or three for R G B");
            }
            if (!parse_real(token, read[k])) {
                scanner_.fail_unexpected(token, {"a component of a colour"});
            }
        }
        if (scanner_.next(token, Reach::line)) {
            scanner_.fail_unexpected(token, {"the end of the line after R G B"});
        }
        value = read;
        return true;
    }

    /// A colour that most files hold without a meaning here: one in another notation is black.
    void lenient_colour(Rgb& value) {
        value = Rgb::Zero();
        std::string_view token;
        int k = 0;
        while (k < 3 && scanner_.next(token, Reach::line) && parse_real(token, value[k]) && std::isfinite(value[k])) {
            ++k;
        }
        if (k == 1) {
            value = Rgb::Constant(value[0]);
        } else if (k != 3) {
            value = Rgb::Zero();
        }
    }

    /// Options, then the name of a file, which may contain blanks.
    void texture(bool emission) {
        current();
        TextureUse use{library_.materials.size(), emission, {}, scanner_.line()};
        std::string_view token;
        while (scanner_.next(token, Reach::line)) {
            if (token == "-s" || token == "-o" || token == "-t") {
                numbers(token, use);
            } else if (token == "-clamp") {
                use.clamp = scanner_.next(token, Reach::line) && token == "on";
            } else if (token == "-mm") {
                scanner_.next(token, Reach::line);
                scanner_.next(token, Reach::line);
                unread_.add(use.line, "'-mm'");
            } else if (token == "-blendu" || token == "-blendv" || token == "-cc" || token == "-texres" ||
                       token == "-imfchan" || token == "-boost" || token == "-bm" || token == "-type") {
                unread_.add(use.line, excerpt(token));
                scanner_.next(token, Reach::line);
            } else {
                const std::string_view rest = scanner_.rest_of_line();
                use.file = rest.empty() ? token : std::string_view(token.data(), rest.data() + rest.size());
                break;
            }
        }
        if (use.file.empty()) {
            scanner_.fail("a texture names no file: write the name of the image, or remove the line");
        }
        maps_[emission ? 1 : 0] = std::move(use);
    }

    /// One to three numbers, for u, v and w: scale, offset, or turbulence.
    void numbers(std::string_view option, TextureUse& use) {
        for (int k = 0; k < 3 && !scanner_.at_line_end(); ++k) {
            const TextScanner before = scanner_;
            std::string_view token;
            double value = 0.0;
            scanner_.next(token, Reach::line);
            if (!parse_real(token, value) || !std::isfinite(value)) {
                scanner_ = before;
                if (k == 0) {
                    scanner_.fail_unexpected(token, {"a number for -s, -o or -t"});
                }
                break;
            }
            if (k < 2) {
                use.placement(k, option == "-s" ? k : 2) = option == "-t" ? use.placement(k, 2) : value;
            }
            if (option == "-t" && value != 0.0) {
                unread_.add(use.line, "'-t'");
            }
        }
    }

    /// `d 1` and `Tr 0` are opaque.
    void opacity(std::string_view word) {
        std::string_view token;
        double value = 0.0;
        const bool halo = scanner_.next(token, Reach::line) && token == "-halo";
        if (halo) {
            scanner_.next(token, Reach::line);
        }
        const bool opaque = parse_real(token, value) && value == (word == "d" ? 1.0 : 0.0);
        if (!opaque) {
            add_translucent();
        }
    }

    void add_translucent() {
        if (open_ && !translucent_here_) {
            translucent_.add(line_);
            translucent_here_ = true; // exporters write several of the keywords
        }
    }

    void write_notes() {
        std::vector<std::string>& notes = library_.notes;
        const std::string materials = file_ + ": materials ";
        without_kd_.note(materials + "without Kd", "their reflectance is 0.5", notes);
        black_.note(materials + "whose Kd of 0 makes their map_Kd black",
                    "Kd is a factor on the image: write Kd 1 1 1 to have the image as it is", notes);
        ignored_.note(file_ + ": unsupported statements", "they are ignored", notes);
        unread_.note(file_ + ": unsupported texture options", "they are ignored", notes);
        translucent_.note(materials + "that are not opaque", "transparency is ignored, every face is opaque", notes);
        too_bright_.note(materials + "whose Kd and Ks (illum 3) add up to more than 1",
                         "the specular share is what Kd leaves", notes);
        specular_unused_.note(
            materials + "with a specular colour Ks but without illum 3",
            "Ks is ignored, they only reflect diffusely: with illum 3 it is that of a mirror, or of a "
            "gloss if Ns is below 900",
            notes);
        foreign_.note(materials + "with a spectral or xyz colour", "it is ignored: write R G B instead", notes);
        repeated_.note(materials + "whose name was defined before", "the first definition is used", notes);
    }

    std::string file_;
    TextScanner scanner_;
    MaterialLibrary library_;
    std::unordered_set<std::string> names_;
    Material material_; ///< being read, if `open_`
    std::uint32_t line_ = 0;
    bool open_ = false, has_kd_ = false, has_ke_ = false, translucent_here_ = false;
    bool has_illum_3_ = false, is_dull_ = false;    ///< is_dull_: illum 0 or 1, which do not use Ks
    double exponent_ = 0.0;                         ///< Ns; infinite if not given
    Rgb specular_ = Rgb::Zero();                    ///< Ks
    std::array<std::optional<TextureUse>, 2> maps_; ///< map_Kd, map_Ke
    Tally without_kd_, black_, ignored_, unread_, too_bright_, specular_unused_, translucent_, foreign_, repeated_;
};

} // namespace

MaterialLibrary parse_material_library(std::string_view content, const std::string& file) {
    return Parser(content, file).parse();
}

} // namespace difusa
