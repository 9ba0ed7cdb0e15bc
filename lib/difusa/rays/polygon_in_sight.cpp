#include <difusa/rays/polygon_in_sight.h>

namespace difusa {

PolygonInSight::Extent PolygonInSight::look(const Shafts& shafts, const SurfacePoint& x, std::span<const Vec3> polygon,
                                            const Plane& plane, const Limits& limits) {
    if (!shafts.find_blockers(x, polygon, plane.normal, limits.blockers, blockers_)) {
        blockers_.clear();
        return Extent::unknown;
    }
    if (blockers_.empty()) {
        return Extent::whole;
    }
    const Mesh& mesh = shafts.mesh();
    const double rounding = shafts.rounding();
    const Vec3& own = mesh.face_normal(x);
    const Plane above{own, own.dot(x.position)};
    visible_.set(FlatPolygon(polygon));
    for (const Index face : blockers_) {
        const FlatPolygon blocker = FlatPolygon(mesh.corners(face)).above(plane, rounding).above(above, rounding);
        const Vec3& n = mesh.normals[face];
        visible_.hide(x.position, blocker, {n, n.dot(mesh.corner(face, 0))}, rounding);
        if (visible_.empty()) {
            break;
        }
        if (visible_.count() > limits.parts) {
            return Extent::unknown;
        }
    }
    return Extent::pieces;
}

} // namespace difusa
