// Pictures of a bake, without a display: rays through each pixel, what they meet, and what is known about the light
// there.
#pragma once

#include <difusa/bake.h>
#include <difusa/render/colour_map.h>
#include <difusa/render/tone_map.h>
#include <difusa/scene/camera.h>
#include <difusa/scene/image.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace difusa {

/// What a picture can show.
enum class Quantity {
    radiosity,           ///< E + rho H
    direct,              ///< E + rho H_direct: as if nothing reflected light but what one looks at
    indirect,            ///< rho H_indirect, the rest
    group,               ///< the radiosity of one light group
    irradiance,          ///< H
    irradiance_direct,   ///< H_direct
    irradiance_indirect, ///< H_indirect
    emission,            ///< E
    reflectance,         ///< rho
    luminance,           ///< of the radiosity, by Rec. 709
    error,               ///< the bound of BakeResult::error_bound
    basis,               ///< an element of the basis, or the sum of all
    sites                ///< dots on pale surfaces
};

/// How values become colours.
enum class Colouring { light, plain, map, dots };
Colouring colouring_of(Quantity quantity);

/// What one picture shows.
struct Show {
    Quantity quantity = Quantity::radiosity;
    std::string group;            ///< name of the light group
    std::optional<Index> element; ///< of the basis; absent: the sum
    std::string title;            ///< over the colour bar, "luminance, W/m^2"
};

/// A name as a user types it: "radiosity", "irradiance-direct", "group:NAME". Throws UsageError with the nearest name
/// and all names.
Show parse_show(const std::string& text);

struct ViewOptions {
    Camera camera;
    std::size_t width = 800, height = 600;
    std::size_t samples = 4;      ///< for each pixel, a square number
    bool cull_backs = false;      ///< rays pass through the backs of faces
    std::size_t final_gather = 0; ///< rays from each sample; 0: the basis is evaluated
    std::uint64_t seed = 1;       ///< places of the samples
};

/// What a camera ray met.
enum class Seen : std::uint8_t { surface, lamp, back, nothing };

/// The samples of a picture: options.samples for each pixel beside each other, pixels row after row from the top.
struct View {
    ViewOptions options;
    std::vector<Show> shows;
    std::vector<Seen> seen;
    std::vector<std::vector<std::array<float, 3>>> values; ///< of each show; of scalars, three equal ones
    std::size_t rays = 0, segments = 0;                    ///< cast, but for the camera's
};

/// Throws UsageError for a size or a number of samples that cannot be.
void check_view(const ViewOptions& options);

/// Looks at a bake. Colours of light that meets the eye (radiosity, direct, group) are those of the sky where nothing
/// is met, as radiosities, pi times the radiance; all else is 0 there, and on backs. Bit-identical for any number of
/// threads. Throws UsageError for an element, a group or an estimate of the error that is not there, ResourceError.
View look(const BakeResult& result, const ViewOptions& options, const std::vector<Show>& shows,
          const Execution& execution);

/// How samples become pixels.
struct Development {
    double exposure = 1.0;
    ToneCurve curve = ToneCurve::linear;
    ColourScale scale;             ///< for those that are mapped
    std::optional<Rgb> background; ///< linear, shown as it is where nothing is met
};

/// exposure_for the luminances of a show on surfaces that are no lamps; where there are none, of all that is met.
double exposure_of(const View& view, std::size_t show);

/// scale_for its values on surfaces, those of lamps left out for the luminance.
ColourScale scale_of(const View& view, std::size_t show, bool logarithmic);

/// Linear display values: each pixel is the mean of its samples, each as the eye would see it: mapped first, so that
/// the edge of a bright lamp is as smooth as any other. Backs are dark grey. Sites are seen as dots of a radius of two
/// pixels, colour maps are explained by a bar.
Image develop(const BakeResult& result, const View& view, std::size_t show, const Development& how,
              const Execution& execution);

/// Linear values as they are: means of each pixel's samples; of light that meets the eye radiances, W/(m² sr).
Image linear_picture(const View& view, std::size_t show, const std::optional<Rgb>& background);

} // namespace difusa
