// Fuzz target: any bytes as a list of places.
#include "fuzz_file.h"

#include <difusa/output/point_list.h>

#include <cmath>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::read_file_of(data, size, [&](const auto& file) {
        const std::vector<difusa::ListedPoint> points = difusa::read_point_list(file);
        fuzz::hold(!points.empty() && 6 * points.size() <= size + 1, "each point takes three numbers");
        for (const difusa::ListedPoint& point : points) {
            fuzz::hold(point.position.cwiseAbs().maxCoeff() <= 1e75, "coordinates are finite");
            fuzz::hold(!point.normal || std::abs(point.normal->norm() - 1.0) < 1e-6, "normals are unit vectors");
        }
    });
    return 0;
}
