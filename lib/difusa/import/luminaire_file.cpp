#include <difusa/import/luminaire_file.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/import/file_content.h>
#include <difusa/import/text_scanner.h>

#include <algorithm>
#include <cmath>

namespace difusa {

double Luminaire::tilt_factor(double degrees) const {
    if (tilt.empty()) {
        return 1.0;
    }
    const auto above = std::find_if(tilt.begin(), tilt.end(), [&](const auto& pair) { return pair.first >= degrees; });
    if (above == tilt.begin()) {
        return above->second;
    }
    if (above == tilt.end()) {
        return tilt.back().second;
    }
    const auto& [a, at_a] = above[-1];
    const auto& [b, at_b] = above[0];
    return at_a + (at_b - at_a) * (degrees - a) / (b - a);
}

Luminaire read_luminaire(const std::filesystem::path& file, std::size_t lamp_set) {
    const std::string extension = lower_case(file.extension().string());
    if (extension != ".ies" && extension != ".ldt") {
        throw InputError(file.string() + ": photometric files end in .ies (IES LM-63) or .ldt (EULUMDAT)");
    }
    if (extension == ".ies" && lamp_set != 1) {
        throw InputError(file.string() + ": an IES file has one set of lamps: omit \"lamp_set\"");
    }
    const std::string content = read_file(file);
    Luminaire luminaire = extension == ".ies" ? parse_ies(content, file) : parse_eulumdat(content, file, lamp_set);
    const double flux = luminaire.distribution->flux();
    if (luminaire.stated_flux && !(std::abs(flux - *luminaire.stated_flux) <= 0.02 * *luminaire.stated_flux)) {
        luminaire.notes.push_back("states a flux of " + text_of(*luminaire.stated_flux) +
                                  " lm, but its intensities integrate to " + text_of(flux) +
                                  " lm: these are used as they are (\"luminous_flux\" replaces them)");
    }
    for (std::string& note : luminaire.notes) {
        note = file.string() + ": " + note;
    }
    return luminaire;
}

} // namespace difusa
