// Visibility `embree`: Intel Embree, single precision, several times faster than `cgal`. What single precision cannot
// decide is decided in double: the mesh is centred and scaled to unit size before it is rounded, rays start a little
// behind their origin, and every face met near the origin is accepted or refused by the double-precision height of the
// origin over the face's plane. A wall thinner than single precision therefore still blocks.
#include <difusa/core/error.h>
#include <difusa/plugin/plugin.h>
#include <difusa/visibility/brute_force.h>
#include <difusa/visibility/visibility.h>

#include <embree3/rtcore.h>

#include <cmath>
#include <memory>
#include <optional>
#include <string>

namespace {

using difusa::Index;
using difusa::Mesh;
using difusa::Vec3;

/// How far behind its origin a ray starts, in units of the scaled scene: above the rounding of single precision.
constexpr double setback = 0x1p-18;

/// What the filter needs to know of the query at hand.
struct Query {
    RTCIntersectContext context;
    const Mesh* mesh;
    const difusa::OwnPlane* own_plane;
    Index own_face;
    Index far_face; ///< of a segment's end, else none
    bool segment;
    Vec3 origin;
    Vec3 direction; ///< unscaled; for a segment the whole way
    double rise;    ///< |n_own · direction|
    double far_rise;
    double doubtful; ///< in units of t: closer to an end than this, single precision does not decide
};

/// t of the face's plane along the query's ray in double precision.
double plane_t(const Query& query, Index face) {
    const Vec3& n = query.mesh->normals[face];
    return n.dot(query.mesh->corner(face, 0) - query.origin) / n.dot(query.direction);
}

/// True if the face does not count for this query.
bool refused(const Query& query, Index face, double t_single) {
    if (face == query.own_face || face == query.far_face) {
        return true;
    }
    const bool near_start = t_single < query.doubtful;
    const bool near_end = query.segment && t_single > 1.0 - query.doubtful;
    if (!near_start && !near_end) {
        return false;
    }
    const double t = plane_t(query, face);
    if (near_start && (!(t >= 0.0) || query.own_plane->exempts(query.own_face, face, t * query.rise))) {
        return true;
    }
    return query.segment &&
           (!(t > 0.0 && t < 1.0) || query.own_plane->exempts(query.far_face, face, (1.0 - t) * query.far_rise));
}

void filter(const RTCFilterFunctionNArguments* arguments) {
    if (arguments->valid[0] == 0) {
        return;
    }
    const auto& query = *reinterpret_cast<const Query*>(arguments->context);
    const double back = query.doubtful * 0.5; // the ray's own t counts from behind the origin
    const auto t = static_cast<double>(RTCRayN_tfar(arguments->ray, arguments->N, 0)) - back;
    const Index face = RTCHitN_primID(arguments->hit, arguments->N, 0);
    if (refused(query, face, t)) {
        arguments->valid[0] = 0;
    }
}

class EmbreeVisibility final : public difusa::Visibility {
  public:
    explicit EmbreeVisibility(const difusa::Parameters& /*parameters*/)
        : device_(rtcNewDevice("threads=1,set_affinity=0"), rtcReleaseDevice) {
        if (!device_) {
            throw difusa::ResourceError("Embree cannot be started (error " +
                                        std::to_string(rtcGetDeviceError(nullptr)) + "); use --visibility cgal");
        }
    }

    void build(const Mesh& mesh) override {
        mesh_ = &mesh;
        own_plane_.emplace(mesh);
        centre_ = 0.5 * (mesh.low + mesh.high);
        scale_ = 1.0 / mesh.diameter();
        const RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.points.size()));
        auto* triangles = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), mesh.triangles.size()));
        if (points == nullptr || triangles == nullptr) {
            rtcReleaseGeometry(geometry);
            throw difusa::ResourceError("Embree has no memory for the mesh; use --visibility cgal");
        }
        for (std::size_t p = 0; p < mesh.points.size(); ++p) {
            const Vec3 scaled = (mesh.points[p] - centre_) * scale_;
            for (int axis = 0; axis < 3; ++axis) {
                points[3 * p + static_cast<std::size_t>(axis)] = static_cast<float>(scaled[axis]);
            }
        }
        for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
            for (std::size_t k = 0; k < 3; ++k) {
                triangles[3 * f + k] = mesh.triangles[f][k];
            }
        }
        rtcCommitGeometry(geometry);
        scene_.reset(rtcNewScene(device_.get()));
        rtcSetSceneFlags(scene_.get(),
                         static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
        rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_HIGH);
        rtcAttachGeometry(scene_.get(), geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_.get());
        if (const RTCError error = rtcGetDeviceError(device_.get()); error != RTC_ERROR_NONE) {
            throw difusa::ResourceError("Embree cannot build its tree (error " + std::to_string(error) +
                                        "); use --visibility cgal");
        }
    }

    void first_hits(std::span<const difusa::Ray> rays, std::span<difusa::Hit> hits) const override {
        DIFUSA_REQUIRE(rays.size() == hits.size());
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const difusa::Ray& ray = rays[i];
            const double length = ray.direction.norm() * scale_;
            Query query = make_query(ray.origin, ray.direction, ray.face, difusa::none, length);
            RTCRayHit meeting{};
            meeting.ray = make_ray(query, length, std::numeric_limits<float>::infinity());
            meeting.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            rtcIntersect1(scene_.get(), &query.context, &meeting);
            hits[i] = meeting.hit.geomID == RTC_INVALID_GEOMETRY_ID ? difusa::Hit() : exact(query, meeting);
        }
    }

    void occluded(std::span<const difusa::Segment> segments, std::span<std::uint8_t> blocked) const override {
        DIFUSA_REQUIRE(segments.size() == blocked.size());
        for (std::size_t i = 0; i < segments.size(); ++i) {
            const difusa::Segment& segment = segments[i];
            const Vec3 way = segment.to - segment.from;
            const double length = way.norm() * scale_;
            Query query = make_query(segment.from, way, segment.from_face, segment.to_face, length);
            query.segment = true;
            RTCRay ray = make_ray(query, length, static_cast<float>(1.0 + query.doubtful));
            rtcOccluded1(scene_.get(), &query.context, &ray);
            blocked[i] = ray.tfar < 0.0F ? 1 : 0;
        }
    }

  private:
    Query make_query(const Vec3& origin, const Vec3& direction, Index own_face, Index far_face, double length) const {
        Query query{};
        rtcInitIntersectContext(&query.context);
        query.context.filter = filter;
        query.mesh = mesh_;
        query.own_plane = &*own_plane_;
        query.own_face = own_face;
        query.far_face = far_face;
        query.origin = origin;
        query.direction = direction;
        const auto rise = [&](Index face) {
            return face == difusa::none ? 0.0 : std::abs(mesh_->normals[face].dot(direction));
        };
        query.rise = rise(own_face);
        query.far_rise = rise(far_face);
        query.doubtful = 2.0 * setback / length;
        return query;
    }

    RTCRay make_ray(const Query& query, double length, float far) const {
        const Vec3 direction = query.direction * scale_;
        const Vec3 origin = (query.origin - centre_) * scale_ - direction * (setback / length);
        RTCRay ray{};
        ray.org_x = static_cast<float>(origin[0]);
        ray.org_y = static_cast<float>(origin[1]);
        ray.org_z = static_cast<float>(origin[2]);
        ray.dir_x = static_cast<float>(direction[0]);
        ray.dir_y = static_cast<float>(direction[1]);
        ray.dir_z = static_cast<float>(direction[2]);
        ray.tnear = 0.0F;
        ray.tfar = far;
        ray.mask = 0xffffffffU;
        return ray;
    }

    /// The hit's place on the face, recomputed in double from the face's plane.
    difusa::Hit exact(const Query& query, const RTCRayHit& meeting) const {
        difusa::Hit hit;
        hit.face = meeting.hit.primID;
        const Vec3& n = mesh_->normals[hit.face];
        hit.front = n.dot(query.direction) < 0.0;
        hit.u = static_cast<double>(meeting.hit.u);
        hit.v = static_cast<double>(meeting.hit.v);
        const Vec3 place = (1.0 - hit.u - hit.v) * mesh_->corner(hit.face, 0) + hit.u * mesh_->corner(hit.face, 1) +
                           hit.v * mesh_->corner(hit.face, 2);
        hit.t = std::max(0.0, (place - query.origin).dot(query.direction) / query.direction.squaredNorm());
        return hit;
    }

    struct ReleaseScene {
        void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    };
    const Mesh* mesh_ = nullptr;
    std::optional<difusa::OwnPlane> own_plane_;
    Vec3 centre_ = Vec3::Zero();
    double scale_ = 1.0;
    std::shared_ptr<RTCDeviceTy> device_;
    std::unique_ptr<RTCSceneTy, ReleaseScene> scene_;
};

} // namespace

DIFUSA_PLUGIN(visibility, "embree", EmbreeVisibility, "Intel Embree, single precision where that decides: fast.", {})
