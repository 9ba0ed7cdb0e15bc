#include <difusa/mesh/floor_share.h>

namespace difusa {

double floor_share(const Mesh& mesh, const Vec3& up) {
    constexpr double level = 0.9063077870366499; // cos 25 degrees
    const Vec3 size = mesh.high - mesh.low;
    const double height = size.dot(up);
    const Vec3 aside = (Vec3::Ones() - up).cwiseProduct(size) + up; // the two other extents, and 1
    const double footprint = aside.prod(), least = mesh.low.dot(up) + 0.05 * height;
    double area = 0.0;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        const double rise = mesh.normals[t].dot(up);
        if (rise >= level && mesh.corner(t, 0).dot(up) <= least && mesh.corner(t, 1).dot(up) <= least &&
            mesh.corner(t, 2).dot(up) <= least) {
            area += rise * mesh.areas[t];
        }
    }
    return footprint > 0.0 ? area / footprint : 0.0;
}

} // namespace difusa
