// A program of a stranger: the parts of the library as plain values. It makes two facing squares, places sites,
// asks the plugin it is given about the sum of its elements, and prints what it found.
#include <difusa/core/error.h>
#include <difusa/discretisation/basis.h>
#include <difusa/discretisation/sampler.h>
#include <difusa/discretisation/site_set.h>
#include <difusa/mesh/mesh.h>
#include <difusa/plugin/registry.h>

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <numeric>

namespace {

difusa::Mesh two_squares() {
    difusa::Mesh mesh;
    mesh.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 6, 5}, {4, 7, 6}};
    mesh.original_face = {0, 1, 2, 3};
    mesh.material = {0, 0, 0, 0};
    mesh.derive();
    return mesh;
}

int run(const char* plugin_directory) {
    const difusa::Registry registry = difusa::Registry::load({plugin_directory});
    const difusa::Mesh mesh = two_squares();
    const difusa::Execution execution;
    const double spacing = 0.1;

    const auto sampler = registry.create<difusa::Sampler>("poisson_disk");
    const difusa::SiteSet sites = difusa::make_site_set(
        mesh, sampler->sample(mesh, nullptr, spacing, 100'000, difusa::RandomStream(1, "sites"), execution), spacing,
        10, execution);

    const auto basis = registry.create<difusa::Basis>("wendland:width=1.5");
    basis->bind(mesh, sites);

    double worst = 0.0;
    difusa::BasisRow row;
    for (int i = 0; i < 20; ++i) {
        basis->evaluate(mesh.at(static_cast<difusa::Index>(i % 4), 0.04 * i, 0.5 - 0.02 * i), row);
        worst = std::max(worst, std::abs(std::accumulate(row.weight.begin(), row.weight.end(), 0.0) - 1.0));
    }
    std::cout << sites.size() << " sites on an area of " << mesh.area << ", elements of "
              << registry.describe("basis", "wendland:width=1.5") << " sum to 1 within " << worst << '\n';
    // A sum of some tens of weights, each divided by their sum.
    return sites.size() > 50 && worst < 1e-14 ? EXIT_SUCCESS : EXIT_FAILURE;
}

} // namespace

int main(int argc, char** argv) {
    try {
        return argc == 2 ? run(argv[1]) : EXIT_FAILURE;
    } catch (const difusa::Error& error) {
        std::cerr << error.what() << '\n';
        return static_cast<int>(error.code());
    }
}
