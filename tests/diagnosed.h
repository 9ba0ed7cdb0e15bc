// For tests of the diagnosis: what it says of a soup, and soups to be diagnosed.
#pragma once

#include <difusa/core/error.h>
#include <difusa/repair/diagnosis.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "meshes.h"
#include "soups.h"

namespace difusa::diagnosed {

using test::make_soup;

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

inline constexpr double infinity = std::numeric_limits<double>::infinity();

using Counts = std::map<std::string, std::size_t>;

inline Counts counts(const Diagnosis& diagnosis) {
    Counts result;
    for (const Finding& finding : diagnosis.findings) {
        EXPECT_TRUE(result.emplace(finding.code, finding.count).second) << finding.code << " is listed twice";
    }
    return result;
}

inline const Finding& finding(const Diagnosis& diagnosis, const std::string& code) {
    for (const Finding& each : diagnosis.findings) {
        if (each.code == code) {
            return each;
        }
    }
    throw std::out_of_range(code);
}

/// The message with which the soup is refused; empty if it is not.
inline std::string refusal(const PolygonSoup& soup) {
    try {
        diagnose(soup);
    } catch (const InputError& error) {
        return error.what();
    }
    return {};
}

/// Points and faces of a mesh with these triangles.
inline PolygonSoup soup_of(const Mesh& mesh) {
    std::vector<std::vector<Index>> faces;
    for (const auto& t : mesh.triangles) {
        faces.emplace_back(t.begin(), t.end());
    }
    return make_soup(mesh.points, faces);
}

inline PolygonSoup moved(PolygonSoup soup, const test::Motion& motion) {
    soup.points = motion(soup.points);
    return soup;
}

/// The unit cube as six quads, facing outward.
inline PolygonSoup cube() {
    return make_soup({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}},
                     {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}});
}

/// The soup with the faces reversed whose bits are set.
inline PolygonSoup with_reversed(const PolygonSoup& soup, std::uint64_t bits) {
    auto faces = test::faces_of(soup);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        if ((bits >> f & 1U) != 0) {
            std::reverse(faces[f].begin(), faces[f].end());
        }
    }
    return make_soup(soup.points, faces);
}

/// Volume enclosed, positive if the fronts are outside.
inline double signed_volume(const Mesh& mesh) {
    double volume = 0.0;
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3 origin = mesh.points[0];
        volume += (mesh.points[a] - origin).dot((mesh.points[b] - origin).cross(mesh.points[c] - origin)) / 6.0;
    }
    return volume;
}

} // namespace difusa::diagnosed
