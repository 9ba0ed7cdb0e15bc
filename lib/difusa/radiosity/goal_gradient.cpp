#include <difusa/radiosity/goal_gradient.h>

#include <difusa/core/colour.h>
#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/lighting/surfel_light.h>
#include <difusa/radiosity/response.h>
#include <difusa/scene/sky_parts.h>
#include <difusa/transport/gathered.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace difusa {

namespace {

/// What a goal is of the quantities that it is linear in.
struct GoalWeights {
    Values surfel_irradiance; ///< s: #surfels by 1, no rows for places
    Values surfel_radiosity;  ///< a: #surfels by #channels
    Values sky;               ///< y: #parts of the sky by #channels
    Values sharp;             ///< 1 by #sets #channels: mean of the sharp light at the places
};

constexpr std::size_t surfels_of_shares = 256; ///< handled at a time

/// Derivatives of a surfel's reflectance and emission by those of a material that it has.
struct MaterialShare {
    Index surfel = none, material = none;
    Rgb reflectance = Rgb::Zero(), emission = Rgb::Zero();
};

/// Finds them, with the averages that light_on_surfels forms. One surfel at a time.
class MaterialShares {
  public:
    /// `scene`: with reflectances and emissions of 1.
    MaterialShares(const Scene& scene, const Surfels& surfels) : scene_(scene), surfels_(surfels) {}

    /// Appends those of surfel s, by materials.
    void add(Index s, std::vector<MaterialShare>& shares) {
        surfels_.pieces(s, pieces_);
        materials_.clear();
        for (const Surfels::Piece& piece : pieces_) {
            materials_.push_back(scene_.mesh.material[piece.triangle]);
        }
        std::sort(materials_.begin(), materials_.end());
        materials_.erase(std::unique(materials_.begin(), materials_.end()), materials_.end());
        const std::size_t samples = material_samples(scene_, pieces_);
        for (const Index m : materials_) {
            MaterialShare share{s, m};
            for_material_places(surfels_, pieces_, samples, points_,
                                [&](const SurfacePoint& x, double part) { include(x, part, share); });
            shares.push_back(share);
        }
    }

  private:
    void include(const SurfacePoint& x, double part, MaterialShare& share) const {
        if (scene_.mesh.material[x.face] == share.material) {
            share.reflectance += part * scene_.reflectance(x);
            share.emission += part * scene_.emission(x);
        }
    }

    const Scene& scene_;
    const Surfels& surfels_;
    std::vector<Surfels::Piece> pieces_;
    std::vector<SurfacePoint> points_;
    std::vector<Index> materials_; ///< of the pieces
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
        Scene one = scene_;
        for (Material& material : one.materials) {
            material.reflectance = material.emission = Rgb::Ones();
        }
        const Surfels& surfels = *discretisation_.surfels;
        std::vector<std::vector<MaterialShare>> found((surfels.size() + surfels_of_shares - 1) / surfels_of_shares);
        parallel_for(surfels.size(), surfels_of_shares, execution_.silent(),
                     [&](std::size_t begin, std::size_t end, unsigned) {
                         MaterialShares shares(one, surfels);
                         for (std::size_t s = begin; s < end; ++s) {
                             shares.add(static_cast<Index>(s), found[begin / surfels_of_shares]);
                         }
                     });
        for (const std::vector<MaterialShare>& each : found) {
            of_material_.insert(of_material_.end(), each.begin(), each.end());
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
        by_materials(q, result);
        return result;
    }

    void by_materials(const Values& q, GoalGradient& result) const {
        const auto materials = static_cast<Eigen::Index>(scene_.materials.size());
        Values emission = Values::Zero(materials, channels_), reflectance = emission;
        for (const MaterialShare& share : of_material_) {
            const auto row = static_cast<Eigen::Index>(share.material), s = static_cast<Eigen::Index>(share.surfel);
            for (Eigen::Index c = 0; c < channels_; ++c) {
                emission(row, c) += q(s, c) * share.emission[c];
                reflectance(row, c) += q(s, c) * incident_(s, c) * share.reflectance[c];
            }
        }
        result.emission = three_channels(emission);
        result.reflectance = three_channels(reflectance);
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
    std::vector<MaterialShare> of_material_; ///< by surfels
};

} // namespace

std::vector<GoalGradient> goal_gradients(const Solution& solution, std::span<const Goal> goals, std::size_t rays,
                                         std::uint64_t seed, const SolveOptions& solve, const Execution& execution) {
    return Differentiation(solution, rays, seed, solve, execution).run(goals);
}

} // namespace difusa
