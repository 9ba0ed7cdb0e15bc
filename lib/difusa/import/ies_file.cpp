#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/import/file_content.h>
#include <difusa/import/luminaire_file.h>
#include <difusa/import/text_scanner.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace difusa {

namespace {

constexpr std::size_t most_angles = 100000;

/// The numbers of a file, between blanks, commas and line ends.
class IesFile {
  public:
    IesFile(std::string_view content, std::filesystem::path name)
        : text_(content), name_(std::move(name)), scanner_(text_without_commas(), name_.string(), {}) {}

    Luminaire read() {
        read_keywords();
        read_tilt();
        read_photometry();
        return std::move(luminaire_);
    }

  private:
    /// Commas separate numbers as blanks do; keywords are not needed.
    std::string_view text_without_commas() {
        std::replace(text_.begin(), text_.end(), ',', ' ');
        return text_;
    }

    /// Up to and including the line with TILT=.
    void read_keywords() {
        bool first = true;
        while (scanner_.to_token()) {
            const std::string_view line = scanner_.rest_of_line();
            const std::string lower = lower_case(line);
            // Labels of 1986 may begin with any word.
            const std::size_t sign = lower.find_first_not_of(" \t", std::min<std::size_t>(4, lower.size()));
            if (lower.starts_with("tilt") && sign != std::string::npos && lower[sign] == '=') {
                tilt_ = line.substr(sign + 1);
                tilt_.erase(0, tilt_.find_first_not_of(" \t"));
                return;
            }
            // Before 1995 the third factor was that of ballast and lamp.
            if (first && (lower.starts_with("iesna:lm-63-") || lower.starts_with("ies:lm-63-"))) {
                has_lamp_factor_ = false;
            }
            first = false;
        }
        scanner_.fail("no line TILT=...: this is not an IES file (LM-63), or it is truncated");
    }

    void read_tilt() {
        const std::string kind = lower_case(tilt_);
        if (kind == "none") {
            return;
        }
        if (kind == "include") {
            read_tilt_factors(scanner_);
            return;
        }
        const std::filesystem::path file = find_beside(name_.parent_path(), tilt_);
        if (tilt_.empty() || file.empty()) {
            scanner_.fail("TILT names a file that cannot be found, " + excerpt(tilt_) +
                          ": put it beside this one, or write TILT=NONE if the lamp gives the same light at any tilt");
        }
        std::string content = read_file(file);
        std::replace(content.begin(), content.end(), ',', ' ');
        TextScanner factors(content, file.string(), {});
        read_tilt_factors(factors);
        luminaire_.files.push_back(file);
    }

    void read_tilt_factors(TextScanner& from) {
        const std::int64_t geometry = from.integer({"the lamp-to-luminaire geometry"}, TextScanner::Reach::file);
        if (geometry < 1 || geometry > 3) {
            from.fail("the lamp-to-luminaire geometry must be 1, 2 or 3, not " + std::to_string(geometry));
        }
        const std::size_t count = whole(from, "the number of tilt angles");
        for (std::size_t i = 0; i < count; ++i) {
            luminaire_.tilt.emplace_back(number(from, "a tilt angle"), 0.0);
            if (i > 0 && !(luminaire_.tilt[i].first > luminaire_.tilt[i - 1].first)) {
                from.fail("tilt angles must ascend");
            }
        }
        for (std::size_t i = 0; i < count; ++i) {
            luminaire_.tilt[i].second = number(from, "a tilt factor");
            if (!(luminaire_.tilt[i].second >= 0.0)) {
                from.fail("a tilt factor must not be negative");
            }
        }
    }

    void read_photometry() {
        const double lamps = number(scanner_, "the number of lamps"), lumens = number(scanner_, "lumens per lamp");
        const double multiplier = number(scanner_, "the multiplier");
        if (!(multiplier > 0.0)) {
            scanner_.fail("the multiplier must be above 0, not " + text_of(multiplier));
        }
        const std::size_t vertical = whole(scanner_, "the number of vertical angles"),
                          horizontal = whole(scanner_, "the number of horizontal angles");
        const std::int64_t type = scanner_.integer({"the photometric type"}, TextScanner::Reach::file);
        const std::int64_t unit = scanner_.integer({"the unit"}, TextScanner::Reach::file);
        if (type < 1 || type > 3) {
            scanner_.fail("the photometric type must be 1 (C), 2 (B) or 3 (A), not " + std::to_string(type));
        }
        if (unit != 1 && unit != 2) {
            scanner_.fail("the unit must be 1 (feet) or 2 (metres), not " + std::to_string(unit));
        }
        read_opening(unit == 1 ? 0.3048 : 1.0);
        const double ballast = number(scanner_, "the ballast factor"),
                     third = number(scanner_, "the ballast-lamp factor"), watts = number(scanner_, "the input watts");
        const double factor = multiplier * ballast * (has_lamp_factor_ ? third : 1.0);
        if (!(factor > 0.0) || !(watts >= 0.0)) {
            scanner_.fail("the ballast factors must be above 0, and the input watts not negative");
        }
        read_table(static_cast<int>(type), vertical, horizontal, factor);
        const double flux = luminaire_.distribution->flux();
        if (lumens >= 0.0 && lamps * lumens * ballast > 0.0 && flux > 1.02 * lamps * lumens * ballast) {
            luminaire_.notes.push_back("its intensities integrate to " + text_of(flux) + " lm, more than the " +
                                       text_of(lamps * lumens * ballast) + " lm that it states for its lamps");
        }
    }

    /// Width, across the plane 0-180, length along it, height; negative: round (tables of 1995, 2002 and 2019).
    void read_opening(double metres) {
        const double width = number(scanner_, "the luminous width"), length = number(scanner_, "the luminous length"),
                     height = number(scanner_, "the luminous height");
        luminaire_.width = std::abs(width) * metres;
        luminaire_.length = std::abs(length) * metres;
        luminaire_.is_round = width < 0.0 || length < 0.0;
        if (luminaire_.is_round && width == 0.0) {
            luminaire_.width = luminaire_.length;
        }
        if (luminaire_.is_round && length == 0.0) {
            luminaire_.length = luminaire_.width;
        }
        if (height != 0.0) {
            luminaire_.notes.push_back("its luminous sides, of height " + text_of(std::abs(height) * metres) +
                                       " m, count as part of the flat opening");
        }
    }

    void read_table(int type, std::size_t vertical, std::size_t horizontal, double factor) {
        const std::vector<double> v = angles(vertical, "a vertical angle"),
                                  h = angles(horizontal, "a horizontal angle");
        if (scanner_.remaining() < vertical * horizontal) {
            scanner_.fail_missing({"a candela value"}, TextScanner::Reach::file);
        }
        std::vector<double> candela(vertical * horizontal);
        for (double& value : candela) {
            value = factor * number(scanner_, "a candela value");
        }
        IntensityDistribution::Table table{type == 1   ? PhotometryType::C
                                           : type == 2 ? PhotometryType::B
                                                       : PhotometryType::A,
                                           h, v, candela};
        if (type == 2) { // the planes are those of the vertical angles
            table.plane = v;
            table.in_plane = h;
            for (std::size_t i = 0; i < vertical; ++i) {
                for (std::size_t j = 0; j < horizontal; ++j) {
                    table.value[i * horizontal + j] = candela[j * vertical + i];
                }
            }
        }
        try {
            luminaire_.distribution = std::make_shared<IntensityDistribution>(std::move(table));
        } catch (const std::invalid_argument& error) {
            scanner_.fail(std::string("the table cannot be used: ") + error.what());
        }
        if (scanner_.to_token()) {
            luminaire_.notes.push_back("what follows its last candela value, from line " +
                                       std::to_string(scanner_.line()) + " on, is ignored");
        }
    }

    std::vector<double> angles(std::size_t count, const char* what) {
        std::vector<double> result;
        for (std::size_t i = 0; i < count; ++i) {
            result.push_back(number(scanner_, what));
        }
        return result;
    }

    static double number(TextScanner& from, const char* what) {
        const double value = from.real({what}, TextScanner::Reach::file);
        if (!(std::abs(value) <= 1e15)) {
            from.fail(std::string(what) + " is not a number up to 1e15");
        }
        return value;
    }

    static std::size_t whole(TextScanner& from, const char* what) {
        const std::int64_t value = from.integer({what}, TextScanner::Reach::file);
        if (value < 1 || value > static_cast<std::int64_t>(most_angles)) {
            from.fail(std::string(what) + " must be from 1 to 100000, not " + std::to_string(value));
        }
        return static_cast<std::size_t>(value);
    }

    std::string text_, tilt_;
    std::filesystem::path name_;
    TextScanner scanner_;
    bool has_lamp_factor_ = true;
    Luminaire luminaire_;
};

} // namespace

Luminaire parse_ies(std::string_view content, const std::filesystem::path& name) {
    return IesFile(content, name).read();
}

} // namespace difusa
