#include <difusa/render/place_camera.h>

#include <difusa/core/error.h>
#include <difusa/render/camera_rays.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace difusa {

namespace {

constexpr double outside_angle = 0.7, inside_angle = 1.1; ///< 40° and 63°

/// "Right" and "ahead" of an upright observer: along x and y if up is +z, along x and -z if it is +y.
std::pair<Vec3, Vec3> level(const Vec3& up) {
    const Vec3 axis = std::abs(up.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
    const Vec3 right = (axis - axis.dot(up) * up).normalized();
    return {right, up.cross(right)};
}

/// A camera outside, looking in this direction, that just fits the whole bounding box into its picture.
Camera from_outside(const Mesh& mesh, const Vec3& towards, const Vec3& up, double view_angle, double aspect) {
    Camera camera{Vec3::Zero(), towards.normalized(), up, view_angle};
    const Vec3 right = camera.towards.cross(up).normalized(), upwards = right.cross(camera.towards);
    const double half = std::tan(0.5 * view_angle);
    const Vec3 centre = 0.5 * (mesh.low + mesh.high);
    double distance = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 p =
            Vec3((corner & 1) != 0 ? mesh.high.x() : mesh.low.x(), (corner & 2) != 0 ? mesh.high.y() : mesh.low.y(),
                 (corner & 4) != 0 ? mesh.high.z() : mesh.low.z()) -
            centre;
        distance = std::max({distance, std::abs(p.dot(right)) / (half * aspect) - p.dot(camera.towards),
                             std::abs(p.dot(upwards)) / half - p.dot(camera.towards)});
    }
    camera.eye = centre - 1.04 * distance * camera.towards;
    return camera;
}

/// The share of fronts among the hits.
double share_of_fronts(const Camera& camera, const Visibility& visibility, double aspect, bool cull_backs) {
    constexpr std::size_t rows = 24;
    const auto columns = static_cast<std::size_t>(std::max(1.0, std::round(aspect * rows)));
    const CameraRays view(camera, columns, rows);
    std::vector<Ray> rays;
    for (std::size_t row = 0; row < rows; ++row) {
        for (std::size_t column = 0; column < columns; ++column) {
            rays.push_back(
                {view.eye(), view.direction(static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5), none});
        }
    }
    std::vector<Hit> hits(rays.size());
    visibility.first_hits(rays, hits);
    std::size_t met = 0, fronts = 0;
    for (const Hit& hit : hits) {
        met += hit.face != none ? 1 : 0;
        fronts += hit.face != none && (hit.front || cull_backs) ? 1 : 0;
    }
    return met > 0 ? static_cast<double>(fronts) / static_cast<double>(met) : 0.0;
}

/// Candidate views of a scene, preferred ones first.
std::vector<Camera> views(const Mesh& mesh, const Vec3& up, const CameraWishes& wishes, double aspect) {
    const auto [right, ahead] = level(up);
    const double outside = wishes.view_angle.value_or(outside_angle), inside = wishes.view_angle.value_or(inside_angle);
    std::vector<Camera> all;
    for (const auto& [x, y] : {std::pair(-0.45, 0.8), {0.45, 0.8}, {-0.45, -0.8}, {0.45, -0.8}}) {
        all.push_back(from_outside(mesh, x * right + y * ahead - 0.45 * up, up, outside, aspect));
    }
    for (const Vec3& towards : {ahead, Vec3(-ahead), Vec3(-right), right}) {
        all.push_back(from_outside(mesh, towards, up, outside, aspect));
    }
    all.push_back(from_outside(mesh, -up + 0.01 * ahead, up, outside, aspect));
    const Vec3 centre = 0.5 * (mesh.low + mesh.high), half = 0.5 * (mesh.high - mesh.low);
    const auto extent = [&](const Vec3& axis) { return half.dot(axis.cwiseAbs()); };
    for (const auto& [x, y] : {std::pair(-1.0, -1.0), {1.0, -1.0}, {-1.0, 1.0}, {1.0, 1.0}}) {
        const Vec3 corner = x * extent(right) * right + y * extent(ahead) * ahead;
        const Vec3 eye = centre + 0.85 * corner + 0.3 * extent(up) * up;
        all.push_back({eye, (centre - 0.85 * corner - 0.2 * extent(up) * up - eye).normalized(), up, inside});
    }
    return all;
}

Camera best_view(const CameraWishes& wishes, const Mesh& mesh, const Visibility& visibility, double aspect) {
    const Vec3 up = wishes.up ? wishes.up->stableNormalized() : Vec3(Vec3::UnitZ());
    std::vector<Camera> all = views(mesh, up, wishes, aspect);
    std::vector<double> share;
    double best = 0.0;
    for (const Camera& camera : all) {
        share.push_back(share_of_fronts(camera, visibility, aspect, wishes.cull_backs));
        best = std::max(best, share.back());
    }
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (share[i] >= 0.95 * best) {
            return all[i];
        }
    }
    return all.front();
}

} // namespace

Camera place_camera(const CameraWishes& wishes, const std::optional<Camera>& of_scene, const Mesh& mesh,
                    const Visibility& visibility, double aspect) {
    const bool aimed = wishes.look_at || wishes.towards;
    if (wishes.look_at && wishes.towards) {
        throw UsageError("--look-at and --towards both say where the camera looks: give only one of them");
    }
    Camera camera;
    if (!of_scene && !wishes.eye && !aimed) {
        return best_view(wishes, mesh, visibility, aspect);
    }
    if (of_scene) {
        camera = *of_scene;
    } else {
        camera.up = Vec3::UnitZ();
        camera.view_angle = outside_angle;
    }
    camera.view_angle = wishes.view_angle.value_or(camera.view_angle);
    camera.up = wishes.up ? wishes.up->stableNormalized() : camera.up;
    if (!of_scene && !wishes.eye) {
        if (wishes.look_at) {
            throw UsageError("--look-at: needs a viewpoint: give --eye X,Y,Z as well, or only --towards X,Y,Z");
        }
        if (!(wishes.towards->stableNormalized().cross(camera.up).norm() > 1e-6)) {
            throw UsageError("the camera looks along --up: give --up X,Y,Z another direction");
        }
        return from_outside(mesh, wishes.towards->stableNormalized(), camera.up, camera.view_angle, aspect);
    }
    camera.eye = wishes.eye.value_or(camera.eye);
    if (wishes.towards) {
        camera.towards = wishes.towards->stableNormalized();
    } else if (wishes.look_at || !of_scene) {
        const Vec3 way = wishes.look_at.value_or(0.5 * (mesh.low + mesh.high)) - camera.eye;
        if (!(way.stableNorm() > 0.0)) {
            throw UsageError("--eye is the point the camera looks at: give --look-at another point, or use --towards");
        }
        camera.towards = way.stableNormalized();
    }
    if (!(camera.towards.cross(camera.up).norm() > 1e-6)) {
        throw UsageError("the camera looks along --up: give --up X,Y,Z another direction");
    }
    return camera;
}

} // namespace difusa
