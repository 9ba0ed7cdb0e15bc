#include <difusa/scene/sky_parts.h>

namespace difusa {

Values sky_radiosity(const Scene& scene, int channels) {
    constexpr int across = 4; // directions per part, along each side
    Values radiosity(SkyParts::count, channels);
    for (Index part = 0; part < SkyParts::count; ++part) {
        Rgb mean = Rgb::Zero();
        for (int i = 0; scene.dome && i < across * across; ++i) {
            const double u = (i / across + 0.5) / across, v = (i % across + 0.5) / across; // NOLINT: whole rows
            mean += scene.dome->radiance(SkyParts::direction(part, u, v)) / (across * across);
        }
        radiosity.row(part) = (scene.sky + std::numbers::pi * mean).head(channels).matrix().transpose();
    }
    return radiosity;
}

} // namespace difusa
