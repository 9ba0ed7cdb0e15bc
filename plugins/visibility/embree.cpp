// Visibility `embree`: Intel Embree builds the tree and traverses it, several times faster than `cgal`. Embree computes
// in single precision, so it only selects the triangles that a ray may hit; each of them is tested here in double
// precision, by the same arithmetic as in the other engines. The hits are those of `cgal`, to the last bit.
//
// This requires that no box is missed due to rounding. The mesh is centred and scaled to unit diameter before it is
// rounded, rays from far outside start where they enter a cube around it, and boxes are widened by more than all
// roundings together.
#include "embree_api.h"

#include <difusa/core/error.h>
#include <difusa/plugin/plugin.h>
#include <difusa/rays/brute_force.h>
#include <difusa/rays/visibility.h>
#include <difusa/rays/watertight.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace {

using difusa::Hit;
using difusa::Index;
using difusa::Mesh;
using difusa::OwnPlane;
using difusa::Ray;
using difusa::Segment;
using difusa::Vec3;
using difusa::WatertightRay;
using difusa::embree::Context;

/// How far boxes are widened on all sides, in diameters. Inside the cube [-1, 1]³ around the mesh, a point of a ray at
/// most 2√3 long is displaced by no more than 2^-25 (rounding of the origin) + 2√3 2^-25 (of the direction), the
/// corners of a box by 2^-25: together less than 2^-22. Embree's own arithmetic (RTC_SCENE_FLAG_ROBUST) misses no box
/// that the rounded ray hits. The triangle test rounds by less than the remainder up to a distance of 2^25 diameters.
constexpr float margin = 0x1p-21F;

/// Data for each triangle test.
struct Surface {
    const Mesh* mesh;
    OwnPlane own_plane;
    std::vector<std::array<Vec3, 3>> corners; ///< #T, each stored contiguously: fetching them is most of a test's time
    Vec3 centre;
    double scale; ///< Embree sees a point p of the mesh as (p - centre) scale

    explicit Surface(const Mesh& m)
        : mesh(&m), own_plane(m), corners(m.triangles.size()), centre(0.5 * m.low + 0.5 * m.high),
          scale(1.0 / m.diameter()) {
        for (Index f = 0; f < corners.size(); ++f) {
            corners[f] = {m.corner(f, 0), m.corner(f, 1), m.corner(f, 2)};
        }
    }

    double rise(Index face, const Vec3& direction) const {
        return face == difusa::none ? 0.0 : std::abs(mesh->normals[face].dot(direction));
    }
};

/// A ray in Embree's form: its direction has unit length, `tfar` is in diameters, measured from `skipped`.
struct ScaledRay {
    RTCRay ray{};
    double speed = 0.0;   ///< diameters per unit of t
    double skipped = 0.0; ///< t at which it enters the cube [-1, 1]³
    bool misses = true;   ///< misses the cube, has no direction, or a number in it is not finite

    ScaledRay(const Surface& surface, const Vec3& origin, const Vec3& direction) {
        double length = direction.norm();
        if (!(length > 1e-140 && length < 1e140)) { // squares may be out of range
            length = direction.stableNorm();
        }
        speed = length * surface.scale;
        if (!(length > 0.0 && std::isfinite(speed))) {
            return;
        }
        const Vec3 d = direction / length;
        Vec3 o = (origin - surface.centre) * surface.scale;
        if (!o.allFinite()) { // Embree would end the process
            return;
        }
        if (!(o.cwiseAbs().maxCoeff() <= 1.0)) {
            double enter = 0.0, leave = std::numeric_limits<double>::infinity();
            for (int axis = 0; axis < 3; ++axis) {
                if (d[axis] == 0.0) {
                    leave = std::abs(o[axis]) <= 1.0 ? leave : -1.0;
                    continue;
                }
                const double side = std::copysign(1.0, d[axis]);
                enter = std::max(enter, (-side - o[axis]) / d[axis]);
                leave = std::min(leave, (side - o[axis]) / d[axis]);
            }
            if (!(enter <= leave)) {
                return;
            }
            o += enter * d;
            skipped = enter / speed;
        }
        misses = false;
        ray.org_x = static_cast<float>(o[0]);
        ray.org_y = static_cast<float>(o[1]);
        ray.org_z = static_cast<float>(o[2]);
        ray.dir_x = static_cast<float>(d[0]);
        ray.dir_y = static_cast<float>(d[1]);
        ray.dir_z = static_cast<float>(d[2]);
        ray.tfar = 4.0F; // no path through the cube is longer
        ray.mask = 0xffffffffU;
    }

    /// tfar for hits up to t, rounded up.
    float up_to(double t) const {
        const double far = (t - skipped) * speed;
        return far < 4.0 ? static_cast<float>(std::max(far, 0.0)) + 2 * margin : 4.0F;
    }
};

/// The search for a ray's first hit. Embree passes `context` to the callback.
struct FirstHit {
    struct Handle {
        Context context;
        FirstHit* search;
    };
    const Surface& surface;
    const Ray& ray;
    ScaledRay scaled;
    WatertightRay watertight;
    double rise, slack;
    Hit hit;

    FirstHit(const Surface& s, const Ray& r)
        : surface(s), ray(r), scaled(s, r.origin, r.direction), watertight(r.origin, r.direction),
          rise(s.rise(r.face, r.direction)), slack(s.own_plane.slack(r.direction)) {}

    void run(RTCScene scene) {
        if (!scaled.misses) {
            Handle handle{{}, this};
            difusa::embree::initialise(handle.context);
            RTCRayHit query;
            query.ray = scaled.ray;
            query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            difusa::embree::first_hit(scene, handle.context, query);
        }
    }

    /// Tests triangle f; true if it is the first hit so far.
    bool meets(Index f) {
        const auto& [a, b, c] = surface.corners[f];
        WatertightRay::Meeting m;
        if (f == ray.face || !watertight.meets(a, b, c, m) || !(m.t >= 0.0 && m.t <= hit.t + slack) ||
            surface.own_plane.exempts(ray.face, f, m.t * rise)) {
            return false;
        }
        const Hit met{f, m.front, false, m.t, m.u, m.v};
        if (!difusa::comes_before(met, hit, slack)) {
            return false;
        }
        hit = met;
        return true;
    }

    static void callback(const RTCIntersectFunctionNArguments* arguments) {
        FirstHit& search = *reinterpret_cast<Handle*>(arguments->context)->search;
        if (search.meets(arguments->primID)) {
            auto& query = *reinterpret_cast<RTCRayHit*>(arguments->rayhit); // of rtcIntersect1: one ray
            query.ray.tfar = search.scaled.up_to(search.hit.t + search.slack);
            query.hit.geomID = arguments->geomID;
        }
    }
};

/// The search for anything that blocks a segment.
struct AnyBlocker {
    struct Handle {
        Context context;
        const AnyBlocker* search;
    };
    const Surface& surface;
    const Segment& segment;
    ScaledRay scaled;
    WatertightRay watertight;

    AnyBlocker(const Surface& s, const Segment& g)
        : surface(s), segment(g), scaled(s, g.from, g.to - g.from), watertight(g.from, g.to - g.from) {}

    bool run(RTCScene scene) const {
        if (scaled.misses) {
            return false;
        }
        Handle handle{{}, this};
        difusa::embree::initialise(handle.context);
        RTCRay query = scaled.ray;
        query.tfar = scaled.up_to(1.0);
        difusa::embree::any_hit(scene, handle.context, query);
        return query.tfar < 0.0F;
    }

    bool meets(Index f) const {
        const auto& [a, b, c] = surface.corners[f];
        WatertightRay::Meeting m;
        return f != segment.from_face && f != segment.to_face && watertight.meets(a, b, c, m) &&
               difusa::blocks(segment, *surface.mesh, surface.own_plane, f, m.t);
    }

    static void callback(const RTCOccludedFunctionNArguments* arguments) {
        if (reinterpret_cast<Handle*>(arguments->context)->search->meets(arguments->primID)) {
            reinterpret_cast<RTCRay*>(arguments->ray)->tfar = -std::numeric_limits<float>::infinity();
        }
    }
};

/// The widened box of a triangle.
void bounds(const RTCBoundsFunctionArguments* arguments) {
    const auto& surface = *static_cast<const Surface*>(arguments->geometryUserPtr);
    const auto& [a, b, c] = surface.corners[arguments->primID];
    const Vec3 low = (a.cwiseMin(b).cwiseMin(c) - surface.centre) * surface.scale;
    const Vec3 high = (a.cwiseMax(b).cwiseMax(c) - surface.centre) * surface.scale;
    RTCBounds& box = *arguments->bounds_o;
    box.lower_x = static_cast<float>(low[0]) - margin;
    box.lower_y = static_cast<float>(low[1]) - margin;
    box.lower_z = static_cast<float>(low[2]) - margin;
    box.upper_x = static_cast<float>(high[0]) + margin;
    box.upper_y = static_cast<float>(high[1]) + margin;
    box.upper_z = static_cast<float>(high[2]) + margin;
}

/// The device of all engines of the process, as Embree recommends; null if Embree cannot be started. It is never
/// released: releasing the last device lets TBB's workers end in the background, where nobody can wait for them, and a
/// process that ends meanwhile unmaps the memory they use.
RTCDevice the_device() {
    static auto* const device = rtcNewDevice("threads=1,set_affinity=0");
    return device;
}

class EmbreeVisibility final : public difusa::Visibility {
  public:
    explicit EmbreeVisibility(const difusa::Parameters& /*parameters*/) : device_(the_device()) {
        if (device_ == nullptr) {
            throw difusa::ResourceError("Embree cannot be started (error " +
                                        std::to_string(rtcGetDeviceError(nullptr)) + "); use --visibility cgal");
        }
    }

    void build(const Mesh& mesh) override {
        surface_.emplace(mesh);
        if (!(surface_->scale > 0.0 && std::isfinite(surface_->scale))) {
            throw difusa::InputError("the mesh is too " + std::string(surface_->scale > 0.0 ? "small" : "large") +
                                     " for double precision: use another unit for its coordinates");
        }
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(mesh.triangles.size()));
        rtcSetGeometryUserData(geometry, &*surface_);
        rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
        rtcSetGeometryIntersectFunction(geometry, FirstHit::callback);
        rtcSetGeometryOccludedFunction(geometry, AnyBlocker::callback);
        rtcCommitGeometry(geometry);
        scene_.reset(rtcNewScene(device_));
        rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_HIGH);
        rtcAttachGeometry(scene_.get(), geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_.get());
        if (const RTCError error = rtcGetDeviceError(device_); error != RTC_ERROR_NONE) {
            throw difusa::ResourceError("Embree cannot build its tree (error " + std::to_string(error) +
                                        "); use --visibility cgal");
        }
    }

    void first_hits(std::span<const Ray> rays, std::span<Hit> hits) const override {
        DIFUSA_REQUIRE(rays.size() == hits.size());
        for (std::size_t i = 0; i < rays.size(); ++i) {
            FirstHit search(*surface_, rays[i]);
            search.run(scene_.get());
            hits[i] = search.hit;
        }
    }

    void occluded(std::span<const Segment> segments, std::span<std::uint8_t> blocked) const override {
        DIFUSA_REQUIRE(segments.size() == blocked.size());
        for (std::size_t i = 0; i < segments.size(); ++i) {
            blocked[i] = AnyBlocker(*surface_, segments[i]).run(scene_.get()) ? 1 : 0;
        }
    }

  private:
    struct ReleaseScene {
        void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    };
    std::optional<Surface> surface_;
    RTCDevice device_;
    std::unique_ptr<RTCSceneTy, ReleaseScene> scene_;
};

} // namespace

DIFUSA_PLUGIN(visibility, "embree", EmbreeVisibility,
              "Intel Embree's tree, triangles tested in double precision: same hits, several times as fast.", {})
