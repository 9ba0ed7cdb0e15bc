#include <difusa/import/file_colours.h>

#include <difusa/core/text.h>

#include <cmath>

namespace difusa {

Index ColourTable::intern(const Rgb& colour) {
    if (latest_ != none && (colours_[latest_] == colour).all()) {
        return latest_;
    }
    const auto [place, is_new] =
        numbers_.try_emplace(Key{colour[0], colour[1], colour[2]}, static_cast<Index>(colours_.size()));
    if (is_new) {
        colours_.push_back(colour);
    }
    return latest_ = place->second;
}

void ColourTable::append_materials(double scale, std::vector<Material>& materials) const {
    materials.reserve(materials.size() + colours_.size());
    for (const Rgb& colour : colours_) {
        Material material;
        material.name = "colour " + std::to_string(materials.size() + 1);
        material.reflectance = colour / scale;
        materials.push_back(std::move(material));
    }
}

Rgb FileColours::read(std::span<const std::string_view> components, const TextScanner& scanner) {
    Rgb colour;
    for (std::size_t k = 0; k < components.size(); ++k) {
        const std::string_view token = components[k];
        double value = 0.0;
        if (!parse_real(token, value) || !(value >= 0.0)) {
            scanner.fail_unexpected(token, {"a colour component (a number from 0 to 1, or from 0 to 255)"});
        }
        if (k == 3) {
            if (value != 1.0) {
                below_one_.add(scanner.line());
            }
            if (value != 255.0) {
                below_255_.add(scanner.line());
            }
            break;
        }
        std::int64_t whole = 0;
        if (real_line_ == 0 && !parse_integer(token, whole)) {
            real_line_ = scanner.line();
        }
        if (value > largest_.value) {
            largest_ = {value, scanner.line()};
        }
        colour[static_cast<Eigen::Index>(k)] = value;
    }
    return colour;
}

double FileColours::scale(const TextScanner& scanner) const {
    if (largest_.value > 1.0 && real_line_ != 0) {
        scanner.fail_at(largest_.line, "a colour component is " + exact_text(largest_.value) + ", but line " +
                                           std::to_string(real_line_) +
                                           " has one written as a real number, and those range from 0 to 1: write all "
                                           "of them as whole numbers from 0 to 255, or divide them by 255");
    }
    if (largest_.value > 255.0) {
        scanner.fail_at(largest_.line, "a colour component is " + exact_text(largest_.value) + ": the maximum is 255");
    }
    return largest_.value > 1.0 ? 255.0 : 1.0;
}

void FileColours::finish(const TextScanner& scanner, PolygonSoup& soup) const {
    const double one = scale(scanner);
    if (real_line_ == 0 && largest_.value == 1.0) {
        soup.notes.emplace_back("all colour components are 0 or 1: assumed to range from 0 to 1, not to 255");
    }
    note_opacity(one == 1.0 ? below_one_ : below_255_, soup.notes);
    for (Rgb& colour : soup.point_reflectance) {
        colour /= one;
    }
    table_.append_materials(one, soup.materials);
}

void note_opacity(const Tally& translucent, std::vector<std::string>& notes) {
    translucent.note("colours that are not opaque", "opacity is ignored, every face is opaque", notes);
}

} // namespace difusa
