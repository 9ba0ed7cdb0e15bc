// form_factors_bench [N [TOLERANCE...]]: time and row sums of the form factors between the triangles of the box [-1,1]³
// around the cube [-1/2,1/2]³, 24 n² triangles for n = 4, 8, ... up to N (16), on one core, as a table. The surface is
// closed, so that row sums tell the error: nothing is normalised.
#include "../meshes.h"

#include <difusa/form_factors/form_factors.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace form_factors_bench {

using difusa::Vec3;

void measure(int n, double tolerance) {
    const difusa::Mesh mesh = difusa::test::together(
        difusa::test::moved(difusa::test::box(Vec3(2, 2, 2), n, true), 1.0, Vec3::Constant(-1.0)),
        difusa::test::moved(difusa::test::box(Vec3(1, 1, 1), n), 1.0, Vec3::Constant(-0.5)));
    difusa::FormFactorCounts counts;
    const auto began = std::chrono::steady_clock::now();
    const difusa::FormFactors F =
        difusa::form_factors(mesh, difusa::surfaces_by_face(mesh), {tolerance}, difusa::Execution{1}, &counts);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
    double largest = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < F.size(); ++i) {
        const double error = F.row_sum(i) - 1.0;
        largest = std::max(largest, std::abs(error));
        squares += error * error;
    }
    std::printf("| %zu | %g | %.2f | %.1e | %.1e | %zu | %zu |\n", F.size(), tolerance, took.count(), largest,
                std::sqrt(squares / static_cast<double>(F.size())), counts.clear, counts.partial);
    std::fflush(stdout);
}

} // namespace form_factors_bench

int main(int count, char** words) {
    const int largest = count > 1 ? std::atoi(words[1]) : 16; // NOLINT: a benchmark's own argument
    std::vector<double> tolerances;
    for (int k = 2; k < count; ++k) {
        tolerances.push_back(std::atof(words[k])); // NOLINT: likewise
    }
    if (tolerances.empty()) {
        tolerances = {1e-3, 1e-5, 5e-6, 1e-6};
    }
    std::printf("| triangles | tolerance | seconds | row sums off by at most | rms | clear pairs | partly hidden |\n"
                "|---|---|---|---|---|---|---|\n");
    for (const double tolerance : tolerances) {
        for (int n = 4; n <= largest; n *= 2) {
            form_factors_bench::measure(n, tolerance);
        }
    }
    return 0;
}
