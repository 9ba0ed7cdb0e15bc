// Normals that files store with their faces.
#pragma once

#include <difusa/mesh/triangle_area.h>
#include <difusa/repair/polygon_soup.h>

namespace difusa {

/// True if the corners of a face, which must exist, run clockwise around `normal`: with a normal of their own that
/// differs from it by more than 120 degrees, beyond what rounding and smooth shading account for. False if either of
/// the two is zero or not finite.
inline bool turned_against(const PolygonSoup& soup, std::size_t face, const Vec3& normal) {
    const auto corners = soup.face(face);
    Vec3 own = Vec3::Zero();
    for (std::size_t k = 2; k < corners.size(); ++k) {
        own += twice_vector_area(soup.points[corners[0]], soup.points[corners[k - 1]], soup.points[corners[k]]);
    }
    return own.dot(normal) < -0.5 * own.norm() * normal.norm();
}

} // namespace difusa
