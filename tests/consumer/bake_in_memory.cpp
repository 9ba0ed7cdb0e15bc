// The whole library in a page: a scene made by a program, its bake, and the light at a place of one's choice.
#include <difusa/bake.h>
#include <difusa/import/shapes.h>
#include <difusa/mesh/surface_finder.h>

#include <cmath>
#include <cstdlib>
#include <iostream>

int main() {
    try {
        // A closed room of 4 by 3 by 2.5 m. All of its walls reflect 60 % and emit 10 W/m².
        difusa::Scene scene;
        scene.mesh = difusa::box({0, 0, 0}, {4, 3, 2.5}, 1, difusa::Front::inside);
        scene.materials.resize(6); // one for each side of the box
        for (difusa::Material& material : scene.materials) {
            material.reflectance = difusa::Rgb::Constant(0.6);
            material.emission = difusa::Rgb::Constant(10.0);
        }

        difusa::BakeOptions options;
        options.sites = 500;
        const difusa::Execution execution; // all processors, silently
        const difusa::BakeResult result = difusa::bake(difusa::Registry::load(), scene, "room", options, execution);

        // The place on the surface that is nearest to a point of the room, on its floor; mesh.at(0, 0.25, 0.25) would
        // be one on the first triangle, by barycentric coordinates.
        const difusa::SurfacePoint x = difusa::SurfaceFinder(result.scene->mesh).nearest({1, 2, 0.1})->point;
        const difusa::PointValues light = result.field().at({&x, 1}, 0, 1, "example", execution);
        std::cout << "at " << x.position.transpose() << ": irradiance " << light.H(0, 0) << " W/m², radiosity "
                  << light.B(0, 0) << " W/m²\n";

        // Everywhere alike: H = B = E / (1 - rho), up to the solver's tolerance.
        const double exact = 10.0 / (1.0 - 0.6), error = std::abs(light.H(0, 0) - exact);
        return error < 1e-5 * exact && light.B(0, 0) > 0.0 ? EXIT_SUCCESS : EXIT_FAILURE;
    } catch (const difusa::Error& error) {
        std::cerr << error.what() << '\n';
        return static_cast<int>(error.code());
    }
}
