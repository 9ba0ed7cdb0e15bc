#include <difusa/bake/near_lights.h>

#include <difusa/core/text.h>
#include <difusa/lighting/narrow_beams.h>
#include <difusa/mesh/surface_finder.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace difusa {

namespace {

constexpr double near_in_widths = 0.25;
constexpr double narrow_in_widths = 0.1; ///< of a beam: 32 of the 4096 points of a surfel (surfel_light.h) meet it

void note_beams(const Scene& scene, const Tracer& tracer, double width, const Execution& execution) {
    std::size_t count = 0;
    std::string first;
    for (const PointLight& light : scene.point_lights) {
        const double angle = light.beyond_beam();
        if (!(light.intensity > 0.0).any() || !(angle < NarrowBeams::widest)) {
            continue;
        }
        const Ray axis{light.position, light.direction, none};
        Hit hit;
        tracer.first_hits({&axis, 1}, {&hit, 1});
        const double across = 2.0 * (hit.t * std::tan(angle) + light.radius());
        if (hit.face != none && hit.front && across < narrow_in_widths * width && count++ == 0) {
            first = "that at " + coordinates(light.position) + ", " + text_of(across) + " wide on face " +
                    std::to_string(scene.mesh.original_face[hit.face]);
        }
    }
    if (count > 0) {
        execution.note(counted(count, "beam") + " so narrow that the spot on the surface is not resolved (" + first +
                       "): what it reflects may be missing, and its error is not seen; give more --sites");
    }
}

} // namespace

void note_near_lights(const Scene& scene, const Tracer& tracer, std::size_t surfels, const Execution& execution) {
    const double width = std::sqrt(scene.mesh.area / static_cast<double>(surfels));
    note_beams(scene, tracer, width, execution);
    const auto is_bright_point = [](const PointLight& light) {
        return !light.is_extended() && (light.intensity > 0.0).any();
    };
    if (std::none_of(scene.point_lights.begin(), scene.point_lights.end(), is_bright_point)) {
        return;
    }
    const SurfaceFinder surface(scene.mesh);
    std::size_t count = 0;
    std::string first;
    const auto is_lit = [](const PointLight& light, const SurfacePoint& x) {
        return light.kernel(light.position, x.position, x.normal) > 0.0;
    };
    for (const PointLight& light : scene.point_lights) {
        if (!is_bright_point(light)) {
            continue;
        }
        auto found = surface.nearest(light.position);
        if (found && !is_lit(light, found->point)) { // it may be behind one of two faces back to back
            found = surface.nearest(light.position, -found->point.normal);
        }
        if (found && found->distance > 0.0 && found->distance < near_in_widths * width && is_lit(light, found->point) &&
            count++ == 0) {
            first = "that at " + coordinates(light.position) + ", " + text_of(found->distance) + " from face " +
                    std::to_string(scene.mesh.original_face[found->point.face]);
        }
    }
    if (count > 0) {
        execution.note(counted(count, "point light") + " so near the surface that the spot below is not resolved (" +
                       first +
                       "): what it reflects may be missing, and its error is not seen; move the light away from the "
                       "surface, or give it a luminous opening");
    }
}

} // namespace difusa
