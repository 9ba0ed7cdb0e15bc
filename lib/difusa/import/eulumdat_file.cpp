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

/// One value a line, as the format has it.
class EulumdatFile {
  public:
    EulumdatFile(std::string_view content, const std::filesystem::path& name) : rest_(content), name_(name.string()) {
        if (rest_.starts_with("\xef\xbb\xbf")) {
            rest_.remove_prefix(3);
        }
    }

    Luminaire read(std::size_t lamp_set) {
        skip(1);
        const auto kind = whole("the type indicator", 0, 3);
        (void)kind; // point or linear: the dimensions say more
        symmetry_ = whole("the symmetry indicator", 0, 4);
        planes_ = whole("the number of C-planes", 1, 721);
        skip(1);
        angles_ = whole("the number of angles in a plane", 2, 3601);
        skip(6); // their distance; report, name, number, file, date
        read_opening();
        const double downward = number("the downward flux fraction"), efficiency = number("the light output ratio"),
                     conversion = number("the conversion factor"), tilt = number("the tilt during measurement");
        if (!(conversion > 0.0)) {
            fail("the conversion factor for intensities must be above 0, not " + text_of(conversion));
        }
        if (tilt != 0.0) {
            luminaire_.notes.push_back("it was measured tilted by " + text_of(tilt) +
                                       " degrees: the light is that of the luminaire so tilted");
        }
        const double lumens = lamp_lumens(lamp_set);
        skip(10); // direct ratios of ten rooms, blank in some files
        read_table(conversion * lumens / 1000.0);
        check_flux(downward, efficiency, lumens);
        if (rest_.find_first_not_of(" \t\r\n\x1a") != std::string_view::npos) {
            luminaire_.notes.push_back("what follows its last intensity, after line " + std::to_string(line_) +
                                       ", is ignored");
        }
        return std::move(luminaire_);
    }

  private:
    [[noreturn]] void fail(const std::string& problem) const {
        throw InputError(name_ + ":" + std::to_string(line_) + ": " + problem);
    }

    std::string_view line(const char* what) {
        if (rest_.empty()) {
            fail(std::string("the file ends where ") + what + " is expected: it is truncated; export it again");
        }
        const std::size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
        std::string_view text = rest_.substr(0, end);
        const bool pair = rest_.substr(end, 2) == "\r\n";
        rest_.remove_prefix(std::min(rest_.size(), end + (pair ? 2 : 1)));
        ++line_;
        while (!text.empty() && is_blank(text.front())) {
            text.remove_prefix(1);
        }
        while (!text.empty() && is_blank(text.back())) {
            text.remove_suffix(1);
        }
        return text;
    }

    void skip(int lines) {
        for (int i = 0; i < lines; ++i) {
            line("a line of the heading");
        }
    }

    /// A decimal comma is a point.
    double number(const char* what) {
        std::string text(line(what));
        std::replace(text.begin(), text.end(), ',', '.');
        double value = 0.0;
        if (!parse_real(text, value) || !(std::abs(value) <= 1e15)) {
            fail(std::string("expected ") + what + ", found " + excerpt(text) +
                 ": EULUMDAT has one number a line, in a fixed order; export the file again");
        }
        return value;
    }

    std::size_t whole(const char* what, std::size_t least, std::size_t most) {
        const double value = number(what);
        if (!(value >= static_cast<double>(least) && value <= static_cast<double>(most)) ||
            value != std::floor(value)) {
            fail(std::string(what) + " must be a whole number from " + std::to_string(least) + " to " +
                 std::to_string(most) + ", not " + text_of(value));
        }
        return static_cast<std::size_t>(value);
    }

    /// Lengths are along the luminaire, which is across the plane C0-C180.
    void read_opening() {
        number("the length of the luminaire");
        number("the width of the luminaire");
        number("the height of the luminaire");
        const double length = number("the length of the luminous area"),
                     width = number("the width of the luminous area");
        double height = 0.0;
        for (int i = 0; i < 4; ++i) {
            height = std::max(height, number("a height of the luminous area"));
        }
        if (!(length >= 0.0 && width >= 0.0)) {
            fail("the dimensions of the luminous area must not be negative");
        }
        luminaire_.is_round = width == 0.0 && length > 0.0;
        luminaire_.width = 0.001 * length;
        luminaire_.length = 0.001 * (luminaire_.is_round ? length : width);
        if (height > 0.0) {
            luminaire_.notes.push_back("its luminous sides, up to " + text_of(0.001 * height) +
                                       " m high, count as part of the flat opening");
        }
    }

    double lamp_lumens(std::size_t lamp_set) {
        const std::size_t sets = whole("the number of lamp sets", 1, 100);
        if (lamp_set < 1 || lamp_set > sets) {
            fail("it has " + std::to_string(sets) + " sets of lamps: there is no number " + std::to_string(lamp_set));
        }
        double lumens = 0.0;
        for (std::size_t set = 1; set <= sets; ++set) {
            number("the number of lamps");
            skip(1);
            const double flux = number("the flux of the lamps");
            if (set == lamp_set) {
                lumens = flux;
                if (!(lumens > 0.0)) {
                    fail("the flux of the lamps must be above 0, not " + text_of(lumens));
                }
            }
            skip(2);
            number("the watts");
        }
        if (sets > 1) {
            luminaire_.notes.push_back("has " + std::to_string(sets) + " sets of lamps: number " +
                                       std::to_string(lamp_set) + " is used, of " + text_of(lumens) +
                                       " lm (\"lamp_set\")");
        }
        return lumens;
    }

    /// First and last of the planes in the file, from 0, counted on beyond 360 degrees.
    std::pair<std::size_t, std::size_t> stored() const {
        switch (symmetry_) {
        case 1:
            return {0, 0};
        case 2:
            return {0, planes_ / 2};
        case 3:
            return {3 * planes_ / 4, 3 * planes_ / 4 + planes_ / 2};
        case 4:
            return {0, planes_ / 4};
        default:
            return {0, planes_ - 1};
        }
    }

    void read_table(double factor) {
        if (symmetry_ > 1 && planes_ % (symmetry_ == 2 ? 2 : 4) != 0) {
            fail(std::to_string(planes_) + " C-planes cannot be symmetric as the symmetry indicator says");
        }
        std::vector<double> all(planes_);
        for (double& angle : all) {
            angle = number("an angle of a C-plane");
        }
        IntensityDistribution::Table table;
        for (std::size_t i = 0; i < angles_; ++i) {
            table.in_plane.push_back(number("an angle in a plane"));
        }
        const auto [first, last] = stored();
        const auto angle_of = [&](std::size_t p) { return p < planes_ ? all[p] : all[p - planes_] + 360.0; };
        std::vector<double> values((last - first + 1) * angles_);
        for (double& value : values) {
            value = factor * number("an intensity");
        }
        if (symmetry_ == 3) { // from 270 over 360 to 450; the same from 270 back to 90
            for (std::size_t p = last + 1; p-- > first;) {
                table.plane.push_back(540.0 - angle_of(p));
                const auto row = values.begin() + static_cast<std::ptrdiff_t>((p - first) * angles_);
                table.value.insert(table.value.end(), row, row + static_cast<std::ptrdiff_t>(angles_));
            }
        } else {
            for (std::size_t p = first; p <= last; ++p) {
                table.plane.push_back(angle_of(p));
            }
            table.value = values;
        }
        if (const double end = table.plane.back(), wanted = symmetry_ == 2   ? 180.0
                                                            : symmetry_ == 3 ? 270.0
                                                                             : 90.0;
            symmetry_ > 1 && (end != wanted || table.plane.front() != (symmetry_ == 3 ? 90.0 : 0.0))) {
            fail("its C-planes are not those that the symmetry indicator " + std::to_string(symmetry_) +
                 " stands for: see that they are evenly spaced from 0 on, or export it again without symmetry");
        }
        try {
            luminaire_.distribution = std::make_shared<IntensityDistribution>(std::move(table));
        } catch (const std::invalid_argument& error) {
            fail(std::string("the table cannot be used: ") + error.what());
        }
    }

    void check_flux(double downward, double efficiency, double lumens) {
        if (efficiency > 0.0) {
            luminaire_.stated_flux = 0.01 * efficiency * lumens;
        }
        const double share = 100.0 * luminaire_.distribution->downward_flux() / luminaire_.distribution->flux();
        if (downward > 0.0 && std::abs(share - downward) > 2.0) {
            luminaire_.notes.push_back("states that " + text_of(downward) +
                                       " % of its flux go down; of its intensities " + text_of(share) + " % do");
        }
    }

    std::string_view rest_;
    std::string name_;
    std::uint32_t line_ = 0;
    std::size_t symmetry_ = 0, planes_ = 0, angles_ = 0;
    Luminaire luminaire_;
};

} // namespace

Luminaire parse_eulumdat(std::string_view content, const std::filesystem::path& name, std::size_t lamp_set) {
    return EulumdatFile(content, name).read(lamp_set);
}

} // namespace difusa
