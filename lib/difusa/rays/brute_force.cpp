#include <difusa/rays/brute_force.h>

#include <difusa/core/error.h>
#include <difusa/rays/watertight.h>

namespace difusa {

void BruteForceVisibility::build(const Mesh& mesh) {
    mesh_ = &mesh;
    own_plane_.emplace(mesh);
}

void BruteForceVisibility::first_hits(std::span<const Ray> rays, std::span<Hit> hits) const {
    DIFUSA_REQUIRE(rays.size() == hits.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Ray& ray = rays[i];
        const WatertightRay watertight(ray.origin, ray.direction);
        const double slack = own_plane_->slack(ray.direction);
        const double rise = ray.face == none ? 0.0 : std::abs(mesh_->normals[ray.face].dot(ray.direction));
        Hit best;
        for (Index f = 0; f < mesh_->triangles.size(); ++f) {
            WatertightRay::Meeting m;
            if (watertight.meets(mesh_->corner(f, 0), mesh_->corner(f, 1), mesh_->corner(f, 2), m) && m.t >= 0.0 &&
                !own_plane_->exempts(ray.face, f, m.t * rise)) {
                const Hit hit{f, m.front, false, m.t, m.u, m.v};
                best = comes_before(hit, best, slack) ? hit : best;
            }
        }
        hits[i] = best;
    }
}

void BruteForceVisibility::occluded(std::span<const Segment> segments, std::span<std::uint8_t> blocked) const {
    DIFUSA_REQUIRE(segments.size() == blocked.size());
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const Ray ray = ray_of(segments[i]);
        const WatertightRay watertight(ray.origin, ray.direction);
        blocked[i] = 0;
        for (Index f = 0; f < mesh_->triangles.size() && blocked[i] == 0; ++f) {
            WatertightRay::Meeting m;
            blocked[i] = watertight.meets(mesh_->corner(f, 0), mesh_->corner(f, 1), mesh_->corner(f, 2), m) &&
                         blocks(segments[i], *mesh_, *own_plane_, f, m.t);
        }
    }
}

} // namespace difusa
