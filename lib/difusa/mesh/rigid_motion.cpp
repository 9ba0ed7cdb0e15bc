#include <difusa/mesh/rigid_motion.h>

#include <difusa/core/error.h>

#include <string>

namespace difusa {

namespace {

constexpr double largest_coordinate = 1e75; // of a mesh file

/// Regions move as a whole.
void check_regions(const Mesh& mesh, std::span<const char> marked) {
    std::vector<Index> first(mesh.region_count, none); // triangle of each region
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        Index& known = first[mesh.region[t]];
        known = known == none ? t : known;
        if (marked[known] != marked[t]) {
            const Index moved = marked[t] != 0 ? t : known, stays = marked[t] != 0 ? known : t;
            throw InputError("face " + std::to_string(mesh.original_face[moved]) + " cannot be moved without face " +
                             std::to_string(mesh.original_face[stays]) +
                             ", to which it is joined smoothly: move the whole object");
        }
    }
}

} // namespace

Mesh moved_mesh(const Mesh& mesh, std::span<const char> marked, const RigidMotion& motion) {
    DIFUSA_REQUIRE(marked.size() == mesh.triangles.size() && is_rigid(motion));
    check_regions(mesh, marked);
    Mesh result = mesh;
    if (motion.is_identity()) {
        return result;
    }
    std::vector<char> stays(mesh.points.size(), 0);
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        for (const Index point : mesh.triangles[t]) {
            stays[point] = stays[point] != 0 || marked[t] == 0 ? 1 : 0;
        }
    }
    std::vector<Index> moved(mesh.points.size(), none); // where the moved point is
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (marked[t] == 0) {
            continue;
        }
        for (Index& corner : result.triangles[t]) {
            const Index point = corner;
            if (moved[point] == none) {
                const Vec3 place = motion(mesh.points[point]);
                if (!(place.cwiseAbs().maxCoeff() <= largest_coordinate)) {
                    throw InputError("the motion leads out of the range of coordinates");
                }
                moved[point] = stays[point] != 0 ? static_cast<Index>(result.points.size()) : point;
                if (stays[point] != 0) {
                    result.points.push_back(place);
                } else {
                    result.points[point] = place;
                }
            }
            corner = moved[point];
        }
    }
    result.repetition.walls.clear(); // those of before
    result.derive();
    settle_repetition(result);
    if (result.region != mesh.region) {
        throw InputError("after the motion the surface would fall into other smooth parts than before: bake the moved "
                         "scene");
    }
    return result;
}

std::vector<SurfacePoint> moved_points(std::vector<SurfacePoint> points, const Mesh& mesh,
                                       std::span<const char> marked) {
    for (SurfacePoint& point : points) {
        if (point.face != none && marked[point.face] != 0) {
            point = mesh.shaded(mesh.at(point.face, point.u, point.v));
        }
    }
    return points;
}

} // namespace difusa
