// What do the visibility engines cost beside Embree alone? For each scene: processor time of a first hit and of a
// segment with each engine, and their ratio to a bare loop of rtcIntersect1 and rtcOccluded1 on the same rays, over
// Embree's own single-precision triangles and with nothing done about what they meet; and the time to build.
//
//     visibility_bench [MESH...]      (without any: the room with balls of 240,000 triangles)
//
// Rays start at Poisson-disk sites as those of `gather` do, segments join sites that face each other. Prints Markdown.
// All kinds of runs take turns, and the shortest times are given, because other work may load the machine.
#include "setting.h"

#include <difusa/rays/direction_pool.h>
#include <difusa/rays/directions.h>
#include <difusa/rays/visibility.h>

#include <visibility/embree_api.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <functional>
#include <limits>

namespace {

using namespace difusa;

constexpr std::size_t triangles = 240'000, site_count = 3'000, rays_a_site = 256, repetitions = 5;

double processor_time() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Embree over the mesh as it is, centred and scaled.
class BareEmbree {
  public:
    explicit BareEmbree(const Mesh& mesh)
        : centre_(0.5 * (mesh.low + mesh.high)), scale_(1.0 / mesh.diameter()),
          device_(rtcNewDevice("threads=1,set_affinity=0")), scene_(rtcNewScene(device_)) {
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.points.size()));
        for (const Vec3& p : mesh.points) {
            for (int axis = 0; axis < 3; ++axis) {
                *points++ = static_cast<float>((p[axis] - centre_[axis]) * scale_);
            }
        }
        auto* corners = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), mesh.triangles.size()));
        for (const auto& triangle : mesh.triangles) {
            corners = std::copy(triangle.begin(), triangle.end(), corners);
        }
        rtcCommitGeometry(geometry);
        rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_);
        embree::initialise(context_);
    }
    BareEmbree(const BareEmbree&) = delete;
    BareEmbree& operator=(const BareEmbree&) = delete;
    ~BareEmbree() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }

    void first_hits(std::span<const Ray> rays) {
        for (const Ray& ray : rays) {
            RTCRayHit query{};
            query.ray = make_ray(ray.origin, ray.direction, std::numeric_limits<float>::infinity());
            query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            embree::first_hit(scene_, context_, query);
            met_ += query.hit.geomID != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
        }
    }
    void occluded(std::span<const Segment> segments) {
        for (const Segment& segment : segments) {
            RTCRay query = make_ray(segment.from, (segment.to - segment.from) * scale_, 1.0F - clearance);
            embree::any_hit(scene_, context_, query);
            met_ += query.tfar < 0.0F ? 1 : 0;
        }
    }
    std::size_t met() const { return met_; }

  private:
    static constexpr float clearance = 0x1p-17F; ///< of the face a ray starts on

    RTCRay make_ray(const Vec3& from, const Vec3& direction, float far) const {
        const Vec3 origin = (from - centre_) * scale_;
        RTCRay ray{};
        ray.org_x = static_cast<float>(origin[0]);
        ray.org_y = static_cast<float>(origin[1]);
        ray.org_z = static_cast<float>(origin[2]);
        ray.dir_x = static_cast<float>(direction[0]);
        ray.dir_y = static_cast<float>(direction[1]);
        ray.dir_z = static_cast<float>(direction[2]);
        ray.tnear = clearance;
        ray.tfar = far;
        ray.mask = 0xffffffffU;
        return ray;
    }
    Vec3 centre_;
    double scale_;
    RTCDevice device_;
    RTCScene scene_;
    embree::Context context_{};
    std::size_t met_ = 0;
};

struct Engine {
    std::string name;
    double build = 0.0;
    std::function<void(std::size_t)> first_hits, occluded; ///< of a site
    double ray = std::numeric_limits<double>::infinity(), segment = ray;
};

void compare(const Registry& registry, const std::string& file) {
    const Scene scene = bench::make_scene(registry, file, triangles);
    const SiteSet sites = bench::make_sites(registry, scene, site_count, {});
    const DirectionPool pool(*registry.create<Directions>("low-discrepancy"), rays_a_site, bench::seed);
    const std::size_t batch = pool.count();
    std::vector<Ray> rays(sites.size() * batch);
    std::vector<Segment> segments;
    std::vector<std::size_t> first_segment{0};
    std::size_t facing = 0;
    for (std::size_t j = 0; j < sites.size(); ++j) {
        pool.rays(sites.points[j], j, std::span(rays).subspan(j * batch, batch));
        const SurfacePoint& x = sites.points[j];
        for (std::size_t k = 0; k < sites.size(); ++k) {
            const SurfacePoint& y = sites.points[k];
            const Vec3 way = y.position - x.position;
            if (x.normal.dot(way) > 0.0 && y.normal.dot(way) < 0.0 && ++facing % 8 == 0) {
                segments.push_back({x.position, y.position, x.face, y.face});
            }
        }
        first_segment.push_back(segments.size());
    }
    std::vector<Engine> engines;
    const auto rays_of = [&](std::size_t j) { return std::span(rays).subspan(j * batch, batch); };
    const auto segments_of = [&](std::size_t j) {
        return std::span(segments).subspan(first_segment[j], first_segment[j + 1] - first_segment[j]);
    };
    double before = processor_time();
    BareEmbree bare(scene.mesh);
    engines.push_back({"Embree alone", processor_time() - before, [&](std::size_t j) { bare.first_hits(rays_of(j)); },
                       [&](std::size_t j) { bare.occluded(segments_of(j)); }});
    std::vector<Hit> hits(batch);
    std::vector<std::uint8_t> blocked(sites.size());
    for (const std::string& name : registry.names("visibility")) {
        const auto engine = registry.create<Visibility>(name);
        before = processor_time();
        engine->build(scene.mesh);
        engines.push_back({name, processor_time() - before,
                           [&, engine](std::size_t j) { engine->first_hits(rays_of(j), hits); },
                           [&, engine](std::size_t j) {
                               engine->occluded(segments_of(j), std::span(blocked).first(segments_of(j).size()));
                           }});
    }
    const auto time = [&](const std::function<void(std::size_t)>& work, std::size_t count) {
        const double start = processor_time();
        for (std::size_t j = 0; j < sites.size(); ++j) {
            work(j);
        }
        return 1e6 * (processor_time() - start) / static_cast<double>(count);
    };
    for (std::size_t i = 0; i < repetitions; ++i) {
        for (Engine& engine : engines) {
            engine.ray = std::min(engine.ray, time(engine.first_hits, rays.size()));
            engine.segment = std::min(engine.segment, time(engine.occluded, segments.size()));
        }
    }
    std::printf("%s, %zu triangles, %zu rays, %zu segments\n\n"
                "| engine | build, s | first hit, us | ratio | segment, us | ratio |\n|---|---|---|---|---|---|\n",
                file.empty() ? "room with balls" : file.c_str(), scene.mesh.triangles.size(), rays.size(),
                segments.size());
    for (const Engine& engine : engines) {
        std::printf("| %s | %.2f | %.3f | %.2f | %.3f | %.2f |\n", engine.name.c_str(), engine.build, engine.ray,
                    engine.ray / engines[0].ray, engine.segment, engine.segment / engines[0].segment);
    }
    std::printf("\n");
}

} // namespace

int main(int argc, char** argv) {
    try {
        const Registry registry = Registry::load();
        for (int i = 1; i < std::max(argc, 2); ++i) {
            compare(registry, i < argc ? argv[i] : "");
        }
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        return static_cast<int>(ExitCode::internal);
    }
}
