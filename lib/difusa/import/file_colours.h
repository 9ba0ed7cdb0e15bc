// Colours in mesh files: linear reflectances that range from 0 to 1 or from 0 to 255, and face colours as materials.
#pragma once

#include <difusa/core/tally.h>
#include <difusa/import/text_scanner.h>
#include <difusa/repair/polygon_soup.h>

#include <array>
#include <map>
#include <span>
#include <string_view>
#include <vector>

namespace difusa {

/// Numbers distinct colours in order of appearance. n colours take n log n steps, whatever they are.
class ColourTable {
  public:
    /// The number of a colour without NaN, from 0.
    Index intern(const Rgb& colour);

    /// Appends one material for each distinct colour, "colour 1", "colour 2", ..., reflectance = colour / scale.
    void append_materials(double scale, std::vector<Material>& materials) const;

  private:
    using Key = std::array<double, 3>;
    std::map<Key, Index> numbers_;
    std::vector<Rgb> colours_;
    Index latest_ = none; ///< neighbouring faces usually share a colour
};

/// The colours of one text file. Their scale is a property of the whole file: if any component is written as a real
/// number (with a point or exponent) they range from 0 to 1; if all are whole and any is above 1, from 0 to 255; if all
/// are whole and none is above 1, from 0 to 1. Collect them as written, then `finish`.
class FileColours {
  public:
    /// The 3 or 4 components of a colour, as written; a fourth is opacity, which is not part of it.
    /// Throws InputError unless they are numbers >= 0.
    Rgb read(std::span<const std::string_view> components, const TextScanner& scanner);

    /// The material number that a face of this colour will have, if `finish` finds no other materials in the soup.
    Index face_material(const Rgb& colour) { return table_.intern(colour); }

    /// Scales point_reflectance, appends the materials, and notes what the user should know.
    /// Throws InputError naming the line of a component above the end of the scale.
    void finish(const TextScanner& scanner, PolygonSoup& soup) const;

  private:
    struct Largest {
        double value = 0.0;
        std::uint32_t line = 0;
    };
    double scale(const TextScanner& scanner) const;

    ColourTable table_;
    Largest largest_;
    std::uint32_t real_line_ = 0; ///< line of the first component written as a real number
    Tally below_one_, below_255_; ///< opacities other than 1, other than 255
};

/// What the user should know about colours with an opacity below 1.
void note_opacity(const Tally& translucent, std::vector<std::string>& notes);

} // namespace difusa
