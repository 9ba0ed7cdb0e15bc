#include <difusa/radiosity/goal_gradient.h>

#include <difusa/core/colour.h>
#include <difusa/core/error.h>
#include <difusa/radiosity/response.h>
#include <difusa/scene/sky_parts.h>
#include <difusa/transport/gathered.h>

#include <algorithm>
#include <utility>

namespace difusa {

namespace {

/// What a goal is of the quantities that it is linear in.
struct GoalWeights {
    Values surfel_irradiance; ///< s: #surfels by 1, no rows for places
    Values surfel_radiosity;  ///< a: #surfels by #channels
    Values sky;               ///< y: #parts of the sky by #channels
    Values sharp;             ///< 1 by #sets #channels: mean of the sharp light at the places
};

class Differentiation {
  public:
    Differentiation(const Solution& solution, std::size_t rays, std::uint64_t seed, const SolveOptions& solve,
                    const Execution& execution)
        : solution_(solution), parts_(solution.field->parts()), system_(*parts_.system), scene_(*parts_.scene),
          discretisation_(system_.discretisation()), channels_(parts_.channels), rays_(rays), seed_(seed),
          solve_(solve), execution_(execution) {
        if (parts_.direct_in_basis || solution.first_bounce == FirstBounce::live || scene_.thermal) {
            throw UsageError(scene_.thermal ? "gradients are those of light: a thermal scene has none"
                                            : "gradients are those of the operator: they need --direct exact and "
                                              "--first-bounce operator");
        }
        if (scene_.mesh.glossy.any()) {
            throw UsageError("gradients are not computed over glossy materials: make the system without them");
        }
    }

    std::vector<GoalGradient> run(std::span<const Goal> goals) {
        discretisation_.averages->apply(discretisation_.projection->coefficients(sum(solution_.h), execution_), U_,
                                        execution_);
        discretisation_.averages->apply(discretisation_.evaluation->coefficients(sum(solution_.h), execution_),
                                        U_evaluated_, execution_);
        incident_ = U_ + sum(solution_.light.direct);
        sky_ = scene_.has_sky() ? sky_radiosity(scene_, channels_) : Values(Values::Zero(SkyParts::count, channels_));
        materials_on_surfels();
        std::vector<GoalWeights> weights;
        Values g(static_cast<Eigen::Index>(discretisation_.points.size()),
                 static_cast<Eigen::Index>(goals.size()) * channels_);
        for (std::size_t k = 0; k < goals.size(); ++k) {
            weights.push_back(weights_of(goals[k]));
            g.middleCols(static_cast<Eigen::Index>(k) * channels_, channels_) = source_of(weights.back());
        }
        const Values l = solve_transpose_for(system_, rho(), g, solve_, execution_);
        std::vector<GoalGradient> gradients;
        for (std::size_t k = 0; k < goals.size(); ++k) {
            gradients.push_back(
                gradient(weights[k], l.middleCols(static_cast<Eigen::Index>(k) * channels_, channels_)));
            gradients.back().name = goals[k].name;
        }
        return gradients;
    }

  private:
    const Values& rho() const { return solution_.light.reflectance; }
    Values sum(const Values& of_sets) const { return sum_of_parts(of_sets, channels_); }

    /// Derivatives of the surfels' reflectance and emission by those of each material: what they are if this material
    /// alone has them, and has 1.
    void materials_on_surfels() {
        Scene dark = scene_;
        dark.suns.clear();
        dark.point_lights.clear();
        dark.dome = nullptr;
        dark.sky = Rgb::Zero();
        for (Material& material : dark.materials) {
            material.emission = Rgb::Zero();
            material.reflectance = Rgb::Zero();
        }
        const DirectLight no_light(dark, system_.tracer());
        for (std::size_t m = 0; m < scene_.materials.size(); ++m) {
            Scene one = dark;
            for (std::size_t other = 0; other < one.materials.size(); ++other) {
                one.materials[other].vertex_colours = one.materials[other].vertex_colours && other == m;
            }
            one.materials[m].reflectance = one.materials[m].emission = Rgb::Ones();
            SurfelLight light = light_on_surfels(one, *discretisation_.surfels, no_light, channels_,
                                                 system_.parts().seed, execution_.silent());
            of_material_.emplace_back(std::move(light.reflectance), std::move(light.all_emission));
        }
    }

    GoalWeights weights_of(const Goal& goal) const {
        const Surfels& surfels = *discretisation_.surfels;
        const auto count = static_cast<Eigen::Index>(surfels.size());
        GoalWeights weights;
        weights.surfel_radiosity = Values::Zero(count, channels_);
        weights.sky = Values::Zero(SkyParts::count, channels_);
        weights.sharp = Values::Zero(1, solution_.light.direct.cols());
        if (goal.triangles.empty()) {
            add_places(goal, weights);
            return weights;
        }
        double area = 0.0;
        for (const Index t : goal.triangles) {
            area += scene_.mesh.areas[t];
        }
        const std::vector<double> share = goal_shares(goal, area, scene_.mesh, surfels);
        weights.surfel_irradiance = Eigen::Map<const Eigen::VectorXd>(share.data(), count);
        return weights;
    }

    void add_places(const Goal& goal, GoalWeights& weights) const {
        if (goal.places.empty()) {
            throw UsageError("goal \"" + goal.name + "\": has neither faces nor places");
        }
        const auto n = static_cast<Eigen::Index>(goal.places.size());
        const std::size_t each = std::max<std::size_t>(1, rays_ / goal.places.size());
        const LightTransport sight =
            gathered(system_.tracer(), goal.places, *discretisation_.surfels, system_.fresh_directions(), each,
                     RandomStream(seed_, "places of gradients").bits(), execution_);
        Values shares;
        sight.W->apply_transpose(Values::Constant(n, channels_, 1.0 / static_cast<double>(n)), shares, execution_);
        weights.surfel_radiosity = shares.topRows(weights.surfel_radiosity.rows());
        weights.sky = shares.bottomRows(weights.sky.rows());
        DirectLight::Effort effort;
        weights.sharp =
            solution_.field->sharp(goal.places, seed_, "places of gradients", execution_, effort).colwise().mean();
    }

    /// Π'ᵀ Pᵀ s + Πᵀ Pᵀ (rho ∘ a).
    Values source_of(const GoalWeights& weights) const {
        Values means, evaluated;
        discretisation_.averages->apply_transpose(rho().cwiseProduct(weights.surfel_radiosity), means, execution_);
        Values source = discretisation_.projection->transposed(means);
        if (weights.surfel_irradiance.rows() > 0) {
            discretisation_.averages->apply_transpose(weights.surfel_irradiance, evaluated, execution_);
            source += discretisation_.evaluation->transposed(evaluated).replicate(1, channels_);
        }
        return source;
    }

    GoalGradient gradient(const GoalWeights& weights, const Values& l) const {
        const Eigen::Index surfels = U_.rows();
        Values back;
        system_.transport().W->apply_transpose(l, back, execution_);
        const Values q = weights.surfel_radiosity + back.topRows(surfels);
        Values by_direct = rho().cwiseProduct(q);
        const Values by_sky = weights.sky + back.bottomRows(back.rows() - surfels);
        const Values b = sum(solution_.light.emission) + rho().cwiseProduct(incident_);
        Eigen::RowVectorXd value = weights.surfel_radiosity.cwiseProduct(b).colwise().sum() +
                                   weights.sky.cwiseProduct(sky_).colwise().sum() + sum(weights.sharp).row(0);
        if (weights.surfel_irradiance.rows() > 0) {
            const Values s = weights.surfel_irradiance.replicate(1, channels_);
            by_direct += s;
            value += s.cwiseProduct(U_evaluated_ + sum(solution_.light.direct)).colwise().sum();
        }
        GoalGradient result;
        result.value = rgb(value);
        result.of_surfels = q;
        groups(weights, q, by_direct, by_sky, result);
        result.emission.resize(static_cast<Eigen::Index>(of_material_.size()), 3);
        result.reflectance.resize(result.emission.rows(), 3);
        for (std::size_t m = 0; m < of_material_.size(); ++m) {
            const auto row = static_cast<Eigen::Index>(m);
            const auto& [reflectance, emission] = of_material_[m];
            result.emission.row(row) = rgb(q.cwiseProduct(emission).colwise().sum()).matrix().transpose();
            result.reflectance.row(row) =
                rgb(q.cwiseProduct(incident_).cwiseProduct(reflectance).colwise().sum()).matrix().transpose();
        }
        return result;
    }

    void groups(const GoalWeights& weights, const Values& q, const Values& by_direct, const Values& by_sky,
                GoalGradient& result) const {
        const LightSets& sets = solution_.field->sets();
        result.groups.resize(static_cast<Eigen::Index>(sets.count()), 3);
        for (Index set = 0; set < sets.count(); ++set) {
            const Eigen::Index first = static_cast<Eigen::Index>(set) * channels_;
            Eigen::RowVectorXd own =
                q.cwiseProduct(solution_.light.emission.middleCols(first, channels_)).colwise().sum() +
                by_direct.cwiseProduct(solution_.light.direct.middleCols(first, channels_)).colwise().sum() +
                weights.sharp.row(0).segment(first, channels_);
            if (set == sets.sky && scene_.has_sky()) {
                own += by_sky.cwiseProduct(sky_).colwise().sum();
            }
            result.groups.row(static_cast<Eigen::Index>(set)) = rgb(own).matrix().transpose();
        }
    }

    Rgb rgb(const Eigen::RowVectorXd& of_channels) const {
        return of_channels.size() == 1 ? Rgb(Rgb::Constant(of_channels[0])) : Rgb(of_channels.transpose().array());
    }

    const Solution& solution_;
    const FieldParts& parts_;
    const RadiositySystem& system_;
    const Scene& scene_;
    const Discretisation& discretisation_;
    const int channels_;
    const std::size_t rays_;
    const std::uint64_t seed_;
    const SolveOptions& solve_;
    const Execution& execution_;
    Values U_, U_evaluated_; ///< #surfels by #channels, all sets together
    Values incident_;        ///< H + U
    Values sky_;
    std::vector<std::pair<Values, Values>> of_material_; ///< reflectance and emission, #surfels by #channels
};

} // namespace

std::vector<GoalGradient> goal_gradients(const Solution& solution, std::span<const Goal> goals, std::size_t rays,
                                         std::uint64_t seed, const SolveOptions& solve, const Execution& execution) {
    return Differentiation(solution, rays, seed, solve, execution).run(goals);
}

} // namespace difusa
