#include <difusa/study/mirror_study.h>

#include <difusa/core/error.h>
#include <difusa/discretisation/discretisation.h>
#include <difusa/discretisation/sampler.h>
#include <difusa/import/shapes.h>
#include <difusa/rays/flat_polygon.h>
#include <difusa/rays/lambert.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>

namespace difusa {

namespace {

enum MirrorMaterial : Index { emitter_material, receiver_material, mirror_material, wall_material };

MirrorSituation empty_situation(const std::string& name, double to_mirror, double from_mirror) {
    MirrorSituation situation;
    situation.name = name;
    situation.to_mirror = to_mirror;
    situation.from_mirror = from_mirror;
    situation.scene.materials.resize(4);
    const char* const names[] = {"emitter", "receiver", "mirror", "wall"}; // NOLINT: of the materials
    for (Index m = 0; m < 4; ++m) {
        situation.scene.materials[m].name = names[m];
        situation.scene.materials[m].reflectance = Rgb::Zero();
    }
    situation.scene.materials[emitter_material].emission = Rgb::Ones();
    situation.scene.materials[receiver_material].reflectance = Rgb::Constant(0.5);
    situation.scene.materials[mirror_material].mirror = Rgb::Ones();
    return situation;
}

/// Adds the rectangle with corner a whose front is u × v.
MirrorSituation::Rectangle add_to(MirrorSituation& situation, MirrorMaterial material, const Vec3& a, const Vec3& u,
                                  const Vec3& v) {
    Mesh& mesh = situation.scene.mesh;
    if (mesh.triangles.empty()) {
        mesh = rectangle(a, u, v);
        std::fill(mesh.material.begin(), mesh.material.end(), Index{material});
    } else {
        add(mesh, rectangle(a, u, v), material);
    }
    return {a, a + u, a + u + v, a + v};
}

Vec3 reflected_in(const MirrorSituation::Rectangle& mirror, const Vec3& p) {
    const Vec3 n = (mirror[1] - mirror[0]).cross(mirror[3] - mirror[0]).normalized();
    return p - 2.0 * n.dot(p - mirror[0]) * n;
}

/// Of a rectangle in the first `count` mirrors, seen in the first of them.
MirrorSituation::Rectangle image_of(MirrorSituation::Rectangle shape,
                                    const std::vector<MirrorSituation::Rectangle>& mirrors, std::size_t count) {
    for (std::size_t k = count; k > 0; --k) {
        for (Vec3& corner : shape) {
            corner = reflected_in(mirrors[k - 1], corner);
        }
        std::swap(shape[1], shape[3]); // what was counterclockwise is clockwise in a mirror
    }
    return shape;
}

/// What of a polygon is seen from x through a window.
FlatPolygon through(const FlatPolygon& polygon, const MirrorSituation::Rectangle& window, const Vec3& x) {
    FlatPolygon seen = polygon;
    const Vec3 middle = 0.5 * (window[0] + window[2]) - x;
    for (std::size_t k = 0; k < 4; ++k) {
        const Vec3 side = (window[k] - x).cross(window[(k + 1) % 4] - x);
        const double inside = side.dot(middle) > 0.0 ? 1.0 : -1.0;
        seen = seen.above({inside * side, inside * side.dot(x)}, 0.0);
    }
    return seen;
}

const char* name_of(MirrorPaths paths) {
    return paths == MirrorPaths::gathered ? "gathered" : paths == MirrorPaths::shot ? "shot" : "printed";
}

} // namespace

double MirrorSituation::exact(const SurfacePoint& x) const {
    FlatPolygon seen(image_of(emitter, mirrors, mirrors.size()));
    for (std::size_t k = 0; k < mirrors.size(); ++k) {
        seen = through(seen, image_of(mirrors[k], mirrors, k), x.position);
    }
    double sum = 0.0;
    for (std::size_t k = 2; k < seen.size(); ++k) {
        sum += lambert_form_factor(x.position, x.normal, seen[0], seen[k - 1], seen[k]);
    }
    return sum;
}

MirrorSituation single_mirror(double to_mirror, double from_mirror) {
    MirrorSituation situation = empty_situation("single", to_mirror, from_mirror);
    const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY();
    situation.emitter = add_to(situation, emitter_material, Vec3::Zero(), x, y);
    add_to(situation, receiver_material, Vec3(2.0, 0.0, to_mirror - from_mirror), x, y);
    situation.mirrors.push_back(add_to(situation, mirror_material, Vec3(0.5, -0.25, to_mirror), 1.5 * y, 2.0 * x));
    settle_mirrors(situation.scene, 32);
    return situation;
}

MirrorSituation double_mirror(double distance) {
    DIFUSA_REQUIRE(distance >= 1.0);
    MirrorSituation situation = empty_situation("double", distance, distance);
    const Vec3 y = Vec3::UnitY(), z = Vec3::UnitZ(), slope(1.0, 0.0, 1.0), across = 1.5 * y;
    situation.emitter = add_to(situation, emitter_material, Vec3(1.0 - distance, 0.0, 0.0), y, z);
    add_to(situation, receiver_material, Vec3(2.0 + distance, 0.0, 2.0), z, y);
    situation.mirrors.push_back(add_to(situation, mirror_material, Vec3(1.0, -0.25, 2.0), across, slope));
    situation.mirrors.push_back(add_to(situation, mirror_material, Vec3(1.0, -0.25, 0.0), slope, across));
    add_to(situation, wall_material, Vec3(1.0, -0.25, 1.0), across, z);
    add_to(situation, wall_material, Vec3(2.0, -0.25, 1.0), z, across);
    settle_mirrors(situation.scene, 32);
    return situation;
}

MirrorTrial try_mirrors(const Registry& registry, const MirrorSituation& situation, double spacing,
                        const MirrorPathOptions& paths, std::uint64_t seed, const Execution& execution) {
    const Mesh& mesh = situation.scene.mesh;
    const auto engine = registry.create<Visibility>("cgal");
    engine->build(mesh);
    const auto sites = std::make_shared<SiteSet>(
        make_site_set(mesh,
                      registry.create<Sampler>("poisson-disk")
                          ->sample(mesh, nullptr, spacing, 1'000'000, RandomStream(seed, "sites"), execution),
                      spacing, 10, execution));
    const Discretisation discretisation =
        discretise(mesh, sites, registry.create<Basis>("normalized-radial"), {}, false, seed, execution);
    const auto kernel = registry.create<Kernel>("disc");
    const MirroredFactors factors = mirrored_factors(Tracer(mesh, *engine), discretisation, *kernel, paths, execution);

    MirrorTrial trial{situation.name, situation.to_mirror, situation.from_mirror, paths, sites->size()};
    trial.patches = mirror_patches(mesh, paths.granularity * spacing, execution).size();
    trial.rays = static_cast<double>(factors.rays) / static_cast<double>(sites->size());
    double sum = 0.0, exact_sum = 0.0, squares = 0.0, exact_squares = 0.0;
    std::size_t count = 0;
    for (std::size_t j = 0; j < sites->size(); ++j) {
        const SurfacePoint& x = sites->points[j];
        if (mesh.material[x.face] == receiver_material) {
            // The elements of the emitter sum to 1 on it, and reach nowhere else.
            const SparseRows::Row& row = factors.rows[j];
            double value = 0.0;
            for (std::size_t k = 0; k < row.column.size(); ++k) {
                value += row.value[k] * situation.scene.emission(sites->points[row.column[k]])[0];
            }
            const double exact = situation.exact(x);
            sum += value;
            exact_sum += exact;
            squares += (value - exact) * (value - exact);
            exact_squares += exact * exact;
            trial.largest = std::max(trial.largest, std::abs(value - exact));
            ++count;
        }
    }
    const double scale = std::sqrt(exact_squares / static_cast<double>(count));
    trial.mean = sum / exact_sum;
    trial.rms = std::sqrt(squares / exact_squares);
    trial.largest /= scale;
    return trial;
}

std::vector<MirrorTrial> mirror_study(const Registry& registry, double spacing, std::uint64_t seed,
                                      const Execution& execution, const std::function<void(const MirrorTrial&)>& tell) {
    std::vector<MirrorSituation> situations;
    for (const auto& [to, from] :
         {std::pair(1.0, 1.0), std::pair(2.0, 2.0), std::pair(4.0, 4.0), std::pair(2.0, 1.0), std::pair(1.0, 2.0)}) {
        situations.push_back(single_mirror(to, from));
    }
    for (const double distance : {1.0, 2.0, 4.0}) {
        situations.push_back(double_mirror(distance));
    }
    std::vector<MirrorTrial> trials;
    for (const MirrorSituation& situation : situations) {
        for (const MirrorPaths paths : {MirrorPaths::printed, MirrorPaths::shot, MirrorPaths::gathered}) {
            for (const auto& [granularity, adaptive] :
                 {std::pair(4.0, false), std::pair(2.0, false), std::pair(1.0, false), std::pair(0.5, false),
                  std::pair(1.0, true)}) {
                trials.push_back(
                    try_mirrors(registry, situation, spacing, {paths, granularity, adaptive}, seed, execution));
                tell(trials.back());
            }
        }
    }
    return trials;
}

std::string mirror_header() {
    return "| mirrors | emitter to mirror | mirror to receiver | paths | granularity | patches | rays per site | mean "
           "| "
           "rms error | largest error |\n|---|---|---|---|---|---|---|---|---|---|\n";
}

std::string mirror_row(const MirrorTrial& trial) {
    char row[256];
    std::snprintf(row, sizeof row, "| %s | %g | %g | %s | %g%s | %zu | %.0f | %.3f | %.1f %% | %.1f %% |\n",
                  trial.situation.c_str(), trial.to_mirror, trial.from_mirror, name_of(trial.paths.paths),
                  trial.paths.granularity, trial.paths.adaptive ? ", adaptive" : "", trial.patches, trial.rays,
                  trial.mean, 100.0 * trial.rms, 100.0 * trial.largest);
    return row;
}

} // namespace difusa
