// Speed against error where the exact answer is known: a square lamp over a black floor. The irradiance of the floor is
// Lambert's form factor in closed form; what a bake gets wrong is what its basis cannot represent between the sites.
//
//     accuracy_bench [BASIS[:parameters]]...        (all bases with their defaults)
//
// Prints Markdown: for each basis and number of sites the relative L2 and largest error of the irradiance at even
// points of the floor, and the time of the steps that depend on them (place and bind sites, light, coefficients).
#include "setting.h"

#include <difusa/basis/projection.h>
#include <difusa/field/evaluate.h>
#include <difusa/lighting/lambert.h>
#include <difusa/lighting/lamps.h>
#include <difusa/transport/transport.h>
#include <difusa/visibility/visibility.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace {

using namespace difusa;

constexpr double half_floor = 2.0, half_lamp = 0.5, height = 1.0;

/// The floor [-2,2]² at z = 0 looking up, and the lamp [-½,½]² at z = 1 looking down.
Scene lamp_over_floor() {
    PolygonSoup soup;
    soup.file = "lamp over floor";
    const auto square = [&soup](double half, double z, bool up, Index material) {
        const auto first = static_cast<Index>(soup.points.size());
        for (const auto& [x, y] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)}) {
            soup.points.emplace_back(half * x, half * y, z);
        }
        const std::array<Index, 4> counterclockwise{first, first + 1, first + 2, first + 3};
        const std::array<Index, 4> clockwise{first, first + 3, first + 2, first + 1};
        soup.add_face(up ? counterclockwise : clockwise, material, 0);
    };
    soup.materials = {{"floor", Rgb::Zero(), Rgb::Zero(), false}, {"lamp", Rgb::Zero(), Rgb::Ones(), false}};
    square(half_floor, 0.0, true, 0);
    square(half_lamp, height, false, 1);
    Scene scene;
    scene.mesh = diagnose(soup).mesh;
    scene.materials = soup.materials;
    return scene;
}

void measure(const Registry& registry, const std::string& choice, std::size_t count, const Execution& execution) {
    const Scene scene = lamp_over_floor();
    const auto visibility = registry.create<Visibility>("cgal");
    visibility->build(scene.mesh);

    const auto begin = std::chrono::steady_clock::now();
    const SiteSet sites = bench::make_sites(registry, scene, count, execution);
    const auto basis = bench::make_basis(registry, choice, scene, sites);
    const Projection projection(*basis, sites, execution);
    Transport transport;
    gather_lamps(scene, lamp_triangles(scene), sites, *visibility, 64, bench::seed, execution, transport);
    const Values coefficients = projection.coefficients(direct_irradiance(scene, transport, 1, execution));
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;

    std::vector<SurfacePoint> points;
    std::vector<double> exact;
    RandomStream stream(bench::seed, "points of the floor");
    while (points.size() < 20000) {
        const auto t = static_cast<Index>(stream.below(scene.mesh.triangles.size()));
        const double root = std::sqrt(stream.uniform()), part = stream.uniform();
        if (scene.mesh.material[t] != 0) {
            continue;
        }
        points.push_back(scene.mesh.at(t, root * (1.0 - part), root * part));
        double F = 0.0;
        for (const Index lamp : lamp_triangles(scene)) {
            F += lambert_form_factor(points.back().position, points.back().normal, scene.mesh.corner(lamp, 0),
                                     scene.mesh.corner(lamp, 1), scene.mesh.corner(lamp, 2));
        }
        exact.push_back(F);
    }
    const Values H = evaluate(*basis, coefficients, points, execution);
    double error = 0.0, square = 0.0, worst = 0.0, largest = 0.0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
        const double miss = H(static_cast<Eigen::Index>(i), 0) - exact[i];
        error += miss * miss;
        square += exact[i] * exact[i];
        worst = std::max(worst, std::abs(miss));
        largest = std::max(largest, exact[i]);
    }
    std::printf("| %s | %zu | %.4f | %.2e | %.2e | %.3f |\n", choice.c_str(), sites.size(), sites.spacing,
                std::sqrt(error / square), worst / largest, took.count());
    std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv) {
    try {
        const Execution execution{2, nullptr};
        const Registry registry = Registry::load();
        std::printf("| basis | sites | spacing | relative L2 error | largest error / largest value | seconds |\n"
                    "|---|---|---|---|---|---|\n");
        std::vector<std::string> choices(argv + 1, argv + argc);
        if (choices.empty()) {
            choices = registry.names("basis");
        }
        for (const std::string& choice : choices) {
            for (const std::size_t count : {500UL, 2000UL, 8000UL, 32000UL}) {
                measure(registry, choice, count, execution);
            }
        }
        return 0;
    } catch (const Error& error) {
        std::fprintf(stderr, "accuracy_bench: %s\n", error.what());
        return static_cast<int>(error.code());
    }
}
