// Photometric files of luminaires: IES (ANSI/IES LM-63 of 1986, 1991, 1995, 2002 and 2019) and EULUMDAT.
#pragma once

#include <difusa/scene/intensity_distribution.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace difusa {

struct Luminaire {
    std::shared_ptr<const IntensityDistribution> distribution; ///< in candela, all factors of the file applied
    /// Of a flat luminous opening, in metres: along the plane C0-C180, and across it. 0: none is stated.
    double length = 0.0, width = 0.0;
    bool is_round = false;
    std::optional<double> stated_flux; ///< of the luminaire, lm, if the file says
    /// Factors on the intensity by the angle of tilt in degrees, ascending; none: it does not depend on it.
    std::vector<std::pair<double, double>> tilt;
    std::vector<std::filesystem::path> files; ///< that were read besides this one
    std::vector<std::string> notes;           ///< what the user should know

    /// The factor at a tilt, by linear interpolation; beyond the angles of the file that of the nearest.
    double tilt_factor(double degrees) const;
};

/// Reads `.ies` or `.ldt`. `lamp_set`: of those in an EULUMDAT file, from 1. A note says if the flux stated differs
/// from the integral of the intensities by more than 2 %. Throws InputError naming file, line and remedy.
Luminaire read_luminaire(const std::filesystem::path& file, std::size_t lamp_set = 1);

/// From memory; `name` is for messages and to find a file of tilt factors beside it.
Luminaire parse_ies(std::string_view content, const std::filesystem::path& name);
Luminaire parse_eulumdat(std::string_view content, const std::filesystem::path& name, std::size_t lamp_set = 1);

} // namespace difusa
