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

/// What the rays of a picture of this many rows meet.
struct Glance {
    Coverage coverage;
    double depth = 0.0; ///< mean distance of what is met
};

Glance look_through(const Camera& camera, const Visibility& visibility, double aspect, std::size_t rows) {
    const auto columns = static_cast<std::size_t>(std::max(1.0, std::round(aspect * static_cast<double>(rows))));
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
    Glance look;
    std::size_t fronts = 0, backs = 0;
    for (const Hit& hit : hits) {
        if (hit.face != none) {
            ++(hit.front ? fronts : backs);
            look.depth += hit.t;
        }
    }
    const auto all = static_cast<double>(rays.size());
    look.coverage = {static_cast<double>(fronts) / all, static_cast<double>(backs) / all};
    look.depth /= static_cast<double>(std::max<std::size_t>(fronts + backs, 1));
    return look;
}

/// The share of fronts among what is met.
double share_of_fronts(const Coverage& coverage, bool cull_backs) {
    const double met = coverage.fronts + coverage.backs;
    return met > 0.0 ? (cull_backs ? met : coverage.fronts) / met : 0.0;
}

constexpr std::size_t coarse_rows = 24, fine_rows = 96;
constexpr double seen_from_outside =
    0.5; ///< share of fronts from the best direction, of a scene to be seen from outside

struct Candidates {
    std::vector<Camera> outside, inside; ///< preferred ones first
};

Candidates candidate_views(const Mesh& mesh, const Vec3& up, const CameraWishes& wishes, double aspect) {
    const auto [right, ahead] = level(up);
    const double outside = wishes.view_angle.value_or(outside_angle), inside = wishes.view_angle.value_or(inside_angle);
    Candidates all;
    for (const auto& [x, y] : {std::pair(-0.45, 0.8), {0.45, 0.8}, {-0.45, -0.8}, {0.45, -0.8}}) {
        all.outside.push_back(from_outside(mesh, x * right + y * ahead - 0.45 * up, up, outside, aspect));
    }
    for (const Vec3& towards : {ahead, Vec3(-ahead), Vec3(-right), right}) {
        all.outside.push_back(from_outside(mesh, towards, up, outside, aspect));
    }
    all.outside.push_back(from_outside(mesh, -up + 0.01 * ahead, up, outside, aspect));
    const Vec3 centre = 0.5 * (mesh.low + mesh.high), half = 0.5 * (mesh.high - mesh.low);
    const auto extent = [&](const Vec3& axis) { return half.dot(axis.cwiseAbs()); };
    for (const double in : {0.85, 0.5}) { // of the way to a corner
        for (const auto& [x, y] : {std::pair(-1.0, -1.0), {1.0, -1.0}, {-1.0, 1.0}, {1.0, 1.0}}) {
            const Vec3 corner = x * extent(right) * right + y * extent(ahead) * ahead;
            const Vec3 eye = centre + in * corner + 0.3 * extent(up) * up;
            all.inside.push_back(
                {eye, (centre - 0.85 * corner - 0.2 * extent(up) * up - eye).normalized(), up, inside});
        }
    }
    return all;
}

struct Choice {
    Camera camera;
    double score = 0.0;
};

constexpr double good_enough = 0.75; ///< of the best score, for a view that is preferred

/// The first that is good enough.
Choice best_of(const std::vector<Camera>& all, const std::vector<double>& score) {
    const double best = *std::max_element(score.begin(), score.end());
    std::size_t i = 0;
    while (score[i] < good_enough * best) {
        ++i;
    }
    return {all[i], score[i]};
}

struct BestView {
    Camera camera;
    bool inside = false;
};

BestView best_view(const CameraWishes& wishes, const Vec3& up, const Mesh& mesh, const Visibility& visibility,
                   double aspect) {
    const Candidates all = candidate_views(mesh, up, wishes, aspect);
    std::vector<double> score;
    for (const Camera& camera : all.outside) {
        const Glance look = look_through(camera, visibility, aspect, coarse_rows);
        score.push_back(share_of_fronts(look.coverage, wishes.cull_backs));
    }
    const Choice outside = best_of(all.outside, score);
    if (outside.score >= seen_from_outside) {
        return {outside.camera, false};
    }
    // Inside, most of the picture shows fronts, and not the side of a wardrobe.
    score.clear();
    for (const Camera& camera : all.inside) {
        const Glance look = look_through(camera, visibility, aspect, coarse_rows);
        score.push_back(look.coverage.fronts * std::min(1.0, 4.0 * look.depth / mesh.diameter()));
    }
    const Choice inside = best_of(all.inside, score);
    return inside.score > outside.score ? BestView{inside.camera, true} : BestView{outside.camera, false};
}

/// A camera inside that looks this way, with the scene's centre before it.
Camera across_room(const Vec3& towards, const Vec3& up, const Mesh& mesh, const Visibility& visibility,
                   double view_angle) {
    const Vec3 centre = 0.5 * (mesh.low + mesh.high);
    const Ray back{centre, -towards, none};
    Hit wall;
    visibility.first_hits({&back, 1}, {&wall, 1});
    return {centre - (wall.face == none ? 0.0 : 0.9 * wall.t) * towards, towards, up, view_angle};
}

bool parallel(const Vec3& a, const Vec3& b) {
    return !(a.cross(b).norm() > 1e-6);
}

} // namespace

Coverage coverage_of(const Camera& camera, const Visibility& visibility, double aspect) {
    return look_through(camera, visibility, aspect, fine_rows).coverage;
}

Camera place_camera(const CameraWishes& wishes, const std::optional<Camera>& of_scene, const Vec3& up_of_scene,
                    const Mesh& mesh, const Visibility& visibility, double aspect) {
    if (wishes.look_at && wishes.towards) {
        throw UsageError("--look-at and --towards both say where the camera looks: give only one of them");
    }
    const Vec3 up = wishes.up ? wishes.up->stableNormalized() : of_scene ? of_scene->up : up_of_scene;
    const Vec3 centre = 0.5 * (mesh.low + mesh.high);
    BestView base = of_scene ? BestView{*of_scene, false} : best_view(wishes, up, mesh, visibility, aspect);
    Camera& camera = base.camera;
    camera.up = up;
    camera.view_angle = wishes.view_angle.value_or(camera.view_angle);
    camera.eye = wishes.eye.value_or(camera.eye);
    std::optional<Vec3> target = wishes.look_at;
    if (wishes.eye && !of_scene && !wishes.towards && !target) {
        target = centre;
    }
    if (target) {
        const Vec3 way = *target - camera.eye;
        if (!(way.stableNorm() > 0.0)) {
            throw UsageError("--eye is the point the camera looks at: give --look-at another point, or use --towards");
        }
        camera.towards = way.stableNormalized();
    }
    if (wishes.towards) {
        camera.towards = wishes.towards->stableNormalized();
    }
    if (parallel(camera.towards, camera.up)) {
        if (wishes.up) {
            throw UsageError("the camera looks along --up: give --up X,Y,Z another direction");
        }
        camera.up = level(up).second; // a plan
    }
    if (wishes.towards && !wishes.eye && !of_scene) {
        return base.inside ? across_room(camera.towards, camera.up, mesh, visibility, camera.view_angle)
                           : from_outside(mesh, camera.towards, camera.up, camera.view_angle, aspect);
    }
    return camera;
}

} // namespace difusa
