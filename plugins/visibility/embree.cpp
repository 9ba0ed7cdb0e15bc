// Visibility `embree`: Intel Embree, single precision, several times faster than `cgal`. What single precision cannot
// decide is decided in double: the mesh is centred and scaled to unit size before it is rounded, rays start a little
// behind their origin, and every face met near the origin is accepted or refused by the double-precision height of the
// origin over the face's plane. A wall thinner than single precision therefore still blocks. Where the back of a face
// is met, a front within single precision of it is looked for and preferred if it is nearer in double precision: of the
// two sheets of a thin wall the nearer one counts. A ray that starts beside an edge of its face and may meet the
// neighbour closer than single precision tells is tested against the faces around in double precision.
#include <difusa/core/error.h>
#include <difusa/plugin/plugin.h>
#include <difusa/rays/brute_force.h>
#include <difusa/rays/visibility.h>
#include <difusa/rays/watertight.h>

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

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
    bool fronts;     ///< instead of stopping at a hit, note the nearest front
    double front_t;  ///< of the front noted, by its plane
    Index front_face;
    float front_u, front_v;
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
    auto& query = *reinterpret_cast<Query*>(arguments->context);
    const double back = query.doubtful * 0.5; // the ray's own t counts from behind the origin
    const auto t = static_cast<double>(RTCRayN_tfar(arguments->ray, arguments->N, 0)) - back;
    const Index face = RTCHitN_primID(arguments->hit, arguments->N, 0);
    if (refused(query, face, t)) {
        arguments->valid[0] = 0;
    } else if (query.fronts) {
        arguments->valid[0] = 0;
        const double exact_t = plane_t(query, face);
        if (query.mesh->normals[face].dot(query.direction) < 0.0 && exact_t < query.front_t) {
            query.front_t = exact_t;
            query.front_face = face;
            query.front_u = RTCHitN_u(arguments->hit, arguments->N, 0);
            query.front_v = RTCHitN_v(arguments->hit, arguments->N, 0);
        }
    }
}

/// The device of all engines of the process, as Embree recommends; null if Embree cannot be started. It is never
/// released: releasing the last device lets TBB's workers end in the background, where nobody can wait for them, and a
/// process that ends meanwhile takes their memory from under them.
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
        mesh_ = &mesh;
        own_plane_.emplace(mesh);
        centre_ = 0.5 * (mesh.low + mesh.high);
        scale_ = 1.0 / mesh.diameter();
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
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
        first_face_.assign(mesh.points.size() + 1, 0);
        for (const auto& triangle : mesh.triangles) {
            for (const Index p : triangle) {
                ++first_face_[p + 1];
            }
        }
        std::partial_sum(first_face_.begin(), first_face_.end(), first_face_.begin());
        faces_.resize(first_face_.back());
        std::vector<std::size_t> next(first_face_.begin(), first_face_.end() - 1);
        for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
            for (const Index p : mesh.triangles[f]) {
                faces_[next[p]++] = static_cast<Index>(f);
            }
        }
        rtcCommitGeometry(geometry);
        scene_.reset(rtcNewScene(device_));
        rtcSetSceneFlags(scene_.get(),
                         static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
        rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_HIGH);
        rtcAttachGeometry(scene_.get(), geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_.get());
        if (const RTCError error = rtcGetDeviceError(device_); error != RTC_ERROR_NONE) {
            throw difusa::ResourceError("Embree cannot build its tree (error " + std::to_string(error) +
                                        "); use --visibility cgal");
        }
    }

    void first_hits(std::span<const difusa::Ray> rays, std::span<difusa::Hit> hits) const override {
        DIFUSA_REQUIRE(rays.size() == hits.size());
        Index own_face = difusa::none; // rays come by the hundred from one place
        Vec3 origin = Vec3::Zero();
        double to_edge = 0.0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const difusa::Ray& ray = rays[i];
            const double length = ray.direction.norm() * scale_;
            Query query = make_query(ray.origin, ray.direction, ray.face, difusa::none, length);
            RTCRayHit meeting{};
            meeting.ray = make_ray(query, length, std::numeric_limits<float>::infinity());
            meeting.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            rtcIntersect1(scene_.get(), &query.context, &meeting);
            hits[i] = difusa::Hit();
            if (meeting.hit.geomID != RTC_INVALID_GEOMETRY_ID) {
                hits[i] = exact(query, meeting.hit.primID, meeting.hit.u, meeting.hit.v);
                if (!hits[i].front) {
                    prefer_front(query, length, meeting, hits[i]);
                }
            }
            if (ray.face != difusa::none) {
                if (ray.face != own_face || ray.origin != origin) {
                    own_face = ray.face;
                    origin = ray.origin;
                    to_edge = distance_to_edge(ray.face, ray.origin);
                }
                // Over the nearest edge the ray is no higher than this above its own plane.
                if (to_edge * query.rise * scale_ < setback * length) {
                    look_around(query, ray, hits[i]);
                }
            }
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

    /// The hit's place on the face in double precision: only which face it is was decided in single precision. Beside
    /// an edge double precision may see the ray pass the face by; then Embree's coordinates stand.
    difusa::Hit exact(const Query& query, Index face, float u, float v) const {
        const Vec3 a = mesh_->corner(face, 0), b = mesh_->corner(face, 1), c = mesh_->corner(face, 2);
        difusa::WatertightRay::Meeting m;
        const difusa::WatertightRay watertight(query.origin, query.direction);
        if (watertight.meets(a, b, c, m) && m.t >= 0.0) {
            return {face, m.front, m.t, m.u, m.v};
        }
        difusa::Hit hit;
        hit.face = face;
        hit.front = mesh_->normals[face].dot(query.direction) < 0.0;
        hit.u = static_cast<double>(u);
        hit.v = static_cast<double>(v);
        const Vec3 place = (1.0 - hit.u - hit.v) * a + hit.u * b + hit.v * c;
        hit.t = std::max(0.0, (place - query.origin).dot(query.direction) / query.direction.squaredNorm());
        return hit;
    }

    /// Puts a front in the place of the back `hit` if one lies before it, or in its plane as far as rounding tells,
    /// and single precision cannot tell them apart.
    void prefer_front(Query& query, double length, const RTCRayHit& meeting, difusa::Hit& hit) const {
        const double incidence = std::abs(mesh_->normals[hit.face].dot(query.direction));
        const double cosine = std::max(incidence * scale_ / length, 0x1p-8);
        RTCRay ray = meeting.ray;
        const auto window = static_cast<float>(query.doubtful / cosine);
        ray.tnear = std::max(0.0F, meeting.ray.tfar - window);
        ray.tfar = meeting.ray.tfar + window;
        query.fronts = true;
        const double back_t = plane_t(query, hit.face);
        query.front_t = back_t + mesh_->magnitude() * 0x1p-44 / incidence;
        query.front_face = difusa::none;
        rtcOccluded1(scene_.get(), &query.context, &ray);
        query.fronts = false;
        if (query.front_face != difusa::none) {
            hit = exact(query, query.front_face, query.front_u, query.front_v);
        }
    }

    /// The least distance of a point of a face to the face's border.
    double distance_to_edge(Index face, const Vec3& x) const {
        double least = std::numeric_limits<double>::infinity();
        for (int k = 0; k < 3; ++k) {
            const Vec3 a = mesh_->corner(face, k), edge = mesh_->corner(face, (k + 1) % 3) - a;
            least = std::min(least, edge.cross(x - a).norm() / edge.norm());
        }
        return least;
    }

    /// Tests the faces around the ray's own in double precision; `hit` becomes the nearest one met, if it is nearer.
    void look_around(const Query& query, const difusa::Ray& ray, difusa::Hit& hit) const {
        const difusa::WatertightRay watertight(ray.origin, ray.direction);
        difusa::Hit nearest;
        for (const Index p : mesh_->triangles[ray.face]) {
            for (std::size_t i = first_face_[p]; i < first_face_[p + 1]; ++i) {
                const Index f = faces_[i];
                difusa::WatertightRay::Meeting m;
                if (watertight.meets(mesh_->corner(f, 0), mesh_->corner(f, 1), mesh_->corner(f, 2), m) && m.t >= 0.0 &&
                    !own_plane_->exempts(ray.face, f, m.t * query.rise)) {
                    const difusa::Hit met{f, m.front, m.t, m.u, m.v};
                    nearest = difusa::comes_before(met, nearest, own_plane_->slack(ray.direction)) ? met : nearest;
                }
            }
        }
        if (nearest.face != difusa::none && nearest.t <= hit.t) {
            hit = nearest;
        }
    }

    struct ReleaseScene {
        void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    };
    const Mesh* mesh_ = nullptr;
    std::optional<difusa::OwnPlane> own_plane_;
    Vec3 centre_ = Vec3::Zero();
    double scale_ = 1.0;
    std::vector<std::size_t> first_face_; ///< #P + 1: the faces around point p are faces_[first_face_[p]] ...
    std::vector<Index> faces_;
    RTCDevice device_;
    std::unique_ptr<RTCSceneTy, ReleaseScene> scene_;
};

} // namespace

DIFUSA_PLUGIN(visibility, "embree", EmbreeVisibility, "Intel Embree, single precision where that decides: fast.", {})
