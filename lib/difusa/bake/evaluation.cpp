#include <difusa/bake/evaluation.h>

#include <difusa/bake/cost.h>
#include <difusa/bake/sensing.h>
#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/mesh/nearest_surface.h>
#include <difusa/mesh/output_mesh.h>
#include <difusa/mesh/triangle_area.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace difusa {

namespace {

/// The centre of an output triangle, with the mean of its corners' normals.
SurfacePoint centre_of(const BakeResult& result, std::size_t f) {
    const Mesh& mesh = result.scene->mesh;
    const Index face = result.mesh.face[f];
    Vec3 position = Vec3::Zero(), normal = Vec3::Zero();
    for (const Index v : result.mesh.triangles[f]) {
        position += result.mesh.vertices[v].position / 3.0;
        normal += result.mesh.vertices[v].normal;
    }
    const std::array<double, 3> weight =
        nearest_on_triangle(position, mesh.corner(face, 0), mesh.corner(face, 1), mesh.corner(face, 2));
    SurfacePoint centre = mesh.at(face, weight[1], weight[2]);
    centre.normal = normal.norm() > 0.5 ? Vec3(normal.normalized()) : centre.normal;
    return centre;
}

PointValues values_at(const BakeResult& result, const std::vector<SurfacePoint>& x, const std::string& purpose,
                      const Execution& execution, const RowVisitor& visit = {}) {
    PointValues values =
        result.field().at(x, result.options.final_gather, result.options.seed, purpose, execution, visit);
    note_gathered(result, values, "output point", execution);
    execution.count("output rays", values.rays);
    execution.count("output segments", values.segments);
    execution.count("unobstructed points", values.clear);
    return values;
}

struct GatherNoise {
    Values around;    ///< #V by 1: root mean square over the triangles at each vertex, W/m²
    double rms = 0.0; ///< over the area, W/m²
};

/// The difference of two halves may vanish at a vertex by chance, but hardly at all around it. `noise`: at vertices.
GatherNoise noise_around(const BakeResult& result, const Values& noise) {
    const auto count = static_cast<Eigen::Index>(result.mesh.vertices.size());
    Values sum = Values::Zero(count, 1), weight = Values::Zero(count, 1);
    double all = 0.0, area = 0.0;
    for (const auto& triangle : result.mesh.triangles) {
        const std::vector<SurfacePoint>& vertices = result.mesh.vertices;
        const double own = 0.5 * twice_vector_area(vertices[triangle[0]].position, vertices[triangle[1]].position,
                                                   vertices[triangle[2]].position)
                                     .norm();
        double squares = 0.0;
        for (const Index v : triangle) {
            squares += own / 3.0 * noise.row(static_cast<Eigen::Index>(v)).squaredNorm();
        }
        all += squares;
        area += own;
        for (const Index v : triangle) {
            sum(static_cast<Eigen::Index>(v), 0) += squares;
            weight(static_cast<Eigen::Index>(v), 0) += own;
        }
    }
    const double least = std::numeric_limits<double>::min();
    return {(sum.array() / weight.array().max(least)).sqrt(), std::sqrt(all / std::max(least, area))};
}

/// The output and its errors, both from one look at the basis.
void evaluate_with_errors(BakeResult& result, const ErrorMap& map, const Execution& execution) {
    const std::vector<SurfacePoint>& vertices = result.mesh.vertices;
    if (result.options.final_gather == 0) {
        ErrorsAt& errors = result.errors.emplace(vertices.size());
        result.output = values_at(result, vertices, "output", execution,
                                  [&](std::size_t i, const BasisRow& row) { map.put(vertices[i], row, i, errors); });
        map.complete(vertices, result.output, errors, execution);
        return;
    }
    result.output = values_at(result, vertices, "output", execution);
    const GatherNoise noise = noise_around(result, result.output.noise),
                      of_irradiance = noise_around(result, result.output.noise_of_irradiance);
    judge_gathered(*result.error, std::sqrt(result.channels) * noise.rms);
    result.errors =
        map.gathered_at(vertices, result.options.final_gather, noise.around, of_irradiance.around, execution);
}

} // namespace

void check_output(const BakeResult& result, const Execution& execution) {
    check_refinement(result.scene->mesh, result.options.output_spacing, most_output_triangles(execution));
}

void estimate_error_of(BakeResult& result, const Execution& execution) {
    const std::size_t points = error_points(result.options, result.sites->size());
    result.options.error_points = points;
    if (points == 0) {
        return;
    }
    execution.phase("estimate error");
    const std::optional<ErrorTarget>& target = result.options.target;
    const FurtherRounds further{result.options.error_rounds,
                                target && result.options.goals.empty() ? target->relative : 0.0};
    result.error =
        estimate_error(result.solution, points, error_rays(result.options), result.options.seed, further, execution);
    if (!(result.error->largest_reflectance < 1.0)) {
        execution.note(std::string(result.scene->thermal
                                       ? "some surface absorbs nothing (its net flux is prescribed, or its "
                                         "emissivity is 0)"
                                       : "some surface absorbs nothing (reflectance 1)") +
                       ": the error is estimated, but has no proven bound");
    }
}

void estimate_goals_of(BakeResult& result, const Execution& execution) {
    if (result.goals.empty() || !result.goal_estimates.empty()) {
        return;
    }
    execution.phase("estimate goals");
    const BakeOptions& options = result.options;
    result.goal_estimates = estimate_goals(result.solution, result.goals, options.goal_samples, error_rays(options),
                                           options.seed, execution);
    for (const GoalEstimate& estimate : result.goal_estimates) {
        execution.count("goal rays", estimate.rays);
    }
}

void refine_output(BakeResult& result, const Execution& execution) {
    execution.phase("refine output");
    result.mesh = output_mesh(result, execution);
}

void evaluate_output(BakeResult& result, const Execution& execution) {
    const BakeOptions& options = result.options;
    execution.phase("evaluate");
    std::optional<ErrorMap> map;
    if (result.error) {
        map.emplace(result.solution, *result.error, execution);
        evaluate_with_errors(result, *map, execution);
    } else {
        result.output = values_at(result, result.mesh.vertices, "output", execution);
    }
    if (options.face_centres) {
        std::vector<SurfacePoint> centres;
        for (std::size_t f = 0; f < result.mesh.triangles.size(); ++f) {
            centres.push_back(centre_of(result, f));
        }
        result.centres = values_at(result, centres, "centres", execution);
    }
    read_places(result, map ? &*map : nullptr, execution);
}

void list_savings(const BakeResult& result, const Execution& execution) {
    const Scene& scene = *result.scene;
    const FieldParts& field = result.field().parts();
    const auto points = static_cast<double>(result.system->discretisation().points.size());
    const auto rays = static_cast<double>(result.system->transport().rays);
    if (result.channels == 1) {
        execution.save({"two of three channels", "all reflectances and lights are grey", "unknowns",
                        2.0 * points * static_cast<double>(field.direct->sets().count())});
    }
    if (!field.direct->any()) {
        execution.save({"direct light by shadow rays",
                        scene.has_emitters() ? "there is no sun and no point light, and the emitting faces are too "
                                               "large, or emit too unevenly, for area lights"
                                             : "there is no sun, no point light and no area light",
                        "rays", points});
    }
    if (field.bright && field.bright->bright_share() > BrightSurfels::broad) {
        execution.save({"samples on bright surfaces",
                        text_of(100.0 * field.bright->bright_share()) +
                            " % of the surface reflects most of the light of lamps and suns",
                        "rays", 0.5 * rays});
    }
    if (!scene.has_sky()) {
        execution.save({"sky", "it is dark", "values", points});
    }
    if (scene.mesh.convex && result.options.transport.rfind("pairwise", 0) == 0) {
        execution.save(
            {"shadow rays between sites", "the room is convex and empty", "rays", 0.5 * points * (points - 1.0)});
    }
    if (const std::size_t clear = execution.journal->count_of("unobstructed points"); clear > 0) {
        const std::size_t rays = AreaLights::shadow_batches(field.shadow_rays).all_rays(false);
        execution.save({"shadow rays to area lights with little or nothing in between",
                        "what is in sight of them is known exactly", "rays", static_cast<double>(clear * rays)});
    }
}

} // namespace difusa
