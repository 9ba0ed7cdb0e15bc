// form_factors_bench [grouped] [spheres] [N [TOLERANCE...]]: time and row sums of the form factors between the
// triangles of the box [-1,1]³ around the cube [-1/2,1/2]³, 24 n² triangles for n = 4, 8, ... up to N (16), on one
// core, as a table. The surface is closed, so that row sums tell the error: nothing is normalised. With "spheres",
// those of two concentric spheres, the radii 1/2 and 1, of 40 n² triangles. With "grouped", those with far triangles in
// groups. "Numbers" are the factors above 0, or the links between groups.
#include "../meshes.h"

#include <difusa/form_factors/form_factors.h>
#include <difusa/form_factors/grouped.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <vector>

namespace form_factors_bench {

using difusa::Vec3;

struct Outcome {
    std::vector<double> row_sums;
    std::size_t numbers = 0;
};

Outcome compute(const difusa::Mesh& mesh, double tolerance, bool grouped, difusa::FormFactorCounts& counts) {
    Outcome outcome;
    if (grouped) {
        const auto F = difusa::grouped_form_factors(mesh, {tolerance}, difusa::Execution{1}, &counts);
        outcome = {F.row_sums(), F.links.size()};
    } else {
        const auto F =
            difusa::form_factors(mesh, difusa::surfaces_by_face(mesh), {tolerance}, difusa::Execution{1}, &counts);
        for (std::size_t i = 0; i < F.size(); ++i) {
            outcome.row_sums.push_back(F.row_sum(i));
        }
        outcome.numbers = F.nonzeros();
    }
    return outcome;
}

/// A closed surface of two bodies, one inside the other.
difusa::Mesh nested(int n, bool spheres) {
    namespace test = difusa::test;
    if (spheres) {
        const int level = std::bit_width(static_cast<unsigned>(n)) - 1;
        return test::together(test::icosphere(level, 1.0, true), test::icosphere(level, 0.5));
    }
    return test::together(test::moved(test::box(Vec3(2, 2, 2), n, true), 1.0, Vec3::Constant(-1.0)),
                          test::moved(test::box(Vec3(1, 1, 1), n), 1.0, Vec3::Constant(-0.5)));
}

void measure(const difusa::Mesh& mesh, double tolerance, bool grouped) {
    difusa::FormFactorCounts counts;
    const auto began = std::chrono::steady_clock::now();
    const Outcome outcome = compute(mesh, tolerance, grouped, counts);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
    double largest = 0.0, squares = 0.0;
    for (const double sum : outcome.row_sums) {
        largest = std::max(largest, std::abs(sum - 1.0));
        squares += (sum - 1.0) * (sum - 1.0);
    }
    std::printf("| %zu | %g | %.2f | %.1e | %.1e | %zu | %zu | %zu |\n", mesh.triangles.size(), tolerance, took.count(),
                largest, std::sqrt(squares / static_cast<double>(outcome.row_sums.size())), counts.clear,
                counts.partial, outcome.numbers);
    std::fflush(stdout);
}

} // namespace form_factors_bench

int main(int count, char** words) {
    int first = 1;
    const auto takes = [&](std::string_view word) {
        const bool is_next = count > first && words[first] == word; // NOLINT: a benchmark's own argument
        first += is_next ? 1 : 0;
        return is_next;
    };
    const bool grouped = takes("grouped"), spheres = takes("spheres");
    const int largest = count > first ? std::atoi(words[first]) : 16; // NOLINT: likewise
    std::vector<double> tolerances;
    for (int k = first + 1; k < count; ++k) {
        tolerances.push_back(std::atof(words[k])); // NOLINT: likewise
    }
    if (tolerances.empty()) {
        tolerances = {1e-3, 1e-5, 5e-6, 1e-6};
    }
    std::printf(
        "| triangles | tolerance | seconds | row sums off by at most | rms | clear pairs | partly hidden | numbers "
        "|\n|---|---|---|---|---|---|---|---|\n");
    for (const double tolerance : tolerances) {
        for (int n = 4; n <= largest; n *= 2) {
            form_factors_bench::measure(form_factors_bench::nested(n, spheres), tolerance, grouped);
        }
    }
    return 0;
}
