// Pictures of a bake, without a display: rays through each pixel, their hits, and the light there.
#pragma once

#include <difusa/bake.h>
#include <difusa/render/colour_map.h>
#include <difusa/render/show.h>
#include <difusa/render/tone_map.h>
#include <difusa/scene/camera.h>
#include <difusa/scene/image.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace difusa {

struct ViewOptions {
    Camera camera;
    std::size_t width = 800, height = 600;
    std::size_t samples = 16;     ///< per pixel, a square number
    bool cull_backs = false;      ///< rays pass through back faces
    std::size_t final_gather = 0; ///< rays from each sample; 0: the basis is evaluated
    std::size_t glossy_rays = 4;  ///< that go on where a sample meets a glossy surface
    std::uint64_t seed = 1;       ///< for the positions of the samples, and these rays
};

/// What a camera ray hit.
enum class CameraHit : std::uint8_t { surface, lamp, back, nothing };

/// The samples of a picture: options.samples per pixel, adjacent, pixels row by row from the top.
struct View {
    ViewOptions options;
    std::vector<Show> shows;
    std::vector<CameraHit> seen;
    std::vector<std::vector<std::array<float, 3>>> values; ///< of each show; for scalars, three equal ones
    std::size_t rays = 0, segments = 0;                    ///< cast, excluding the camera's
};

/// Throws UsageError for an invalid size or number of samples.
void check_view(const ViewOptions& options);

/// Renders a bake. Where rays hit nothing, light that reaches the eye (radiosity, direct, group, luminance, weighted
/// radiosity) is that of the sky, as radiosity, pi times the radiance, or of the surroundings of a thermal scene;
/// everything else is 0 there, and on backs. Bit-identical for any number of threads.
/// Throws UsageError for a missing element, group or error estimate, ResourceError.
View look(const BakeResult& result, const ViewOptions& options, const std::vector<Show>& shows,
          const Execution& execution);

/// How samples become pixels.
struct Development {
    double exposure = 1.0;
    ToneCurve curve = ToneCurve::linear;
    ColourScale scale;             ///< for shows in false colours
    std::optional<Rgb> background; ///< linear, shown as is where rays hit nothing; absent: a neutral grey, or the sky
    bool sky = false;              ///< pictures of light show the sky there, unless there is a background
};

/// exposure_for the luminances of a show on non-emitting surfaces; if there are none, of all hits.
double exposure_of(const View& view, std::size_t show);

/// scale_for its values on surfaces, excluding emitting ones for the luminance.
ColourScale scale_of(const View& view, std::size_t show, bool logarithmic);

/// Linear display values: each pixel is the mean of its tone-mapped samples; mapping first makes the edge of a bright
/// area light as smooth as any other. Backs are dark grey. Sites appear as dots with a radius of two pixels, and false
/// colours get a colour bar beside the picture, which makes it wider (render/draw.h).
Image develop(const BakeResult& result, const View& view, std::size_t show, const Development& how,
              const Execution& execution);

/// Unmapped linear values: means of each pixel's samples; radiances, W/(m² sr), for light that reaches the eye.
Image linear_picture(const View& view, std::size_t show, const std::optional<Rgb>& background,
                     const Execution& execution = {});

} // namespace difusa
