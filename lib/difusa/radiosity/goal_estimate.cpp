#include <difusa/radiosity/goal_estimate.h>

#include <difusa/core/colour.h>
#include <difusa/core/even_sequence.h>
#include <difusa/core/frame.h>
#include <difusa/discretisation/evaluate.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/radiosity/error_points.h>
#include <difusa/radiosity/surfel_transport.h>
#include <difusa/transport/gathered.h>
#include <difusa/transport/glossy_transport.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

namespace difusa {

namespace {

/// Independent repetitions, which tell the variance of their mean, and the 97.5 % quantile of Student's t for it.
constexpr std::size_t repetitions = 16;
constexpr double t_quantile = 2.1314;

/// Points of direct light for each at which the residual is gathered: they take no rays where nothing is in the way.
constexpr std::size_t direct_points = 4;

constexpr std::size_t adjoint_rays = 4096;     ///< at least, for the first step of the adjoint from places
constexpr std::size_t least_adjoint_rays = 16; ///< from each point where the residual is weighed

/// A ray from x, distributed as the cosine from its normal if u is uniform in the unit square.
Ray diffuse_ray(const Mesh& mesh, const SurfacePoint& x, const std::array<double, 2>& u) {
    const Vec3 direction = cosine_direction(x.normal, u[0], 2.0 * std::numbers::pi * u[1]);
    const SurfacePoint from = inset(mesh, x);
    const Vec3& face = mesh.normals[from.face];
    // What a shading normal has below the face is above the smooth surface (Sight::lift).
    return {from.position, face.dot(direction) < 0.0 ? mirrored(direction, face) : direction, from.face};
}

/// Uniform over triangles, or each place in turn.
class GoalSampler {
  public:
    GoalSampler(const Mesh& mesh, const Goal& goal) : mesh_(mesh), goal_(goal), triangles_(mesh, goal.triangles) {}

    double area() const { return triangles_.area(); }

    std::vector<SurfacePoint> draw(std::size_t count, RandomStream stream) const {
        std::vector<SurfacePoint> points;
        points.reserve(count);
        if (triangles_.empty()) {
            const std::size_t places = goal_.places.size(), rounds = std::max<std::size_t>(1, count / places);
            for (std::size_t i = 0; i < rounds * places; ++i) {
                points.push_back(goal_.places[i % places]);
            }
            return points;
        }
        const std::array<double, 3> shift{stream.uniform(), stream.uniform(), stream.uniform()};
        for (std::size_t i = 0; i < count; ++i) {
            const std::array<double, 3> u = even_point(i, shift);
            points.push_back(mesh_.shaded(triangles_.at(u[0], u[1], u[2])));
        }
        return points;
    }

  private:
    const Mesh& mesh_;
    const Goal& goal_;
    TriangleSampler triangles_;
};

class GoalEstimation {
  public:
    /// `number`: of the goal, which selects its random streams. `between_surfels` may be null.
    GoalEstimation(const Solution& solution, const Goal& goal, const SurfelTransport* between_surfels,
                   std::size_t samples, std::size_t rays, std::uint64_t seed, std::size_t number,
                   const Execution& execution)
        : solution_(solution), goal_(goal), between_surfels_(between_surfels), field_(*solution.field),
          parts_(field_.parts()), system_(*parts_.system), scene_(*parts_.scene), sampler_(scene_.mesh, goal),
          channels_(field_.channels()), follows_places_(between_surfels != nullptr && !goal.places.empty()),
          rays_(rays), count_(std::max<std::size_t>(1, samples / (2 * repetitions))),
          seed_(RandomStream(seed, "goal", number).bits()), execution_(execution.silent()) {
        if (goal.triangles.empty() && goal.places.empty()) {
            throw UsageError("the goal " + goal.name + " has neither triangles nor places");
        }
    }

    GoalEstimate run() {
        result_.name = goal_.name;
        result_.area = sampler_.area();
        result_.places = goal_.triangles.empty() ? goal_.places.size() : 0;
        share_surfels();
        find_adjoint();
        draw_sources();
        Values own(repetitions, channels_), corrected(repetitions, channels_);
        for (std::size_t k = 0; k < repetitions; ++k) {
            const auto row = static_cast<Eigen::Index>(k);
            own.row(row) = field_mean(k);
            corrected.row(row) = own.row(row) + residual_mean(k) + met_mean(k) + carried_mean(k);
        }
        const Eigen::RowVectorXd mean = corrected.colwise().mean();
        const Eigen::RowVectorXd reach =
            t_quantile *
            ((corrected.rowwise() - mean).colwise().squaredNorm() / (repetitions * (repetitions - 1.0))).cwiseSqrt();
        result_.field = rgb_of(own.colwise().mean());
        result_.mean = rgb_of(mean);
        result_.low = rgb_of(mean - reach);
        result_.high = rgb_of(mean + reach);
        return std::move(result_);
    }

  private:
    Rgb rgb_of(const Eigen::RowVectorXd& row) const {
        return channels_ == 1 ? Rgb(Rgb::Constant(row[0])) : Rgb(row.transpose().array());
    }
    Values sum(const Values& H) const { return sum_of_parts(H, channels_); }
    RandomStream stream(const std::string& purpose, std::size_t k) const { return {seed_, purpose, k}; }
    static std::string named(const std::string& purpose, std::size_t k) { return purpose + " " + std::to_string(k); }

    /// Of an area: how much of it is on each surfel, and the mean of the light there, which the solution knows.
    void share_surfels() {
        if (goal_.triangles.empty()) {
            return;
        }
        const Discretisation& discretisation = system_.discretisation();
        discretisation.averages->apply(sum(parts_.smooth), known_, execution_);
        if (!parts_.direct_in_basis) {
            known_ += sum(solution_.light.direct);
        }
        share_ = goal_shares(goal_, result_.area, scene_.mesh, *discretisation.surfels);
        mean_known_ = Eigen::RowVectorXd::Zero(channels_);
        for (std::size_t s = 0; s < share_.size(); ++s) {
            mean_known_ += share_[s] * known_.row(static_cast<Eigen::Index>(s));
        }
    }

    /// The radiosity of the goal as a lamp; per surfel.
    Values lamp() const {
        const Surfels& surfels = *system_.discretisation().surfels;
        Values d(static_cast<Eigen::Index>(surfels.size()), channels_);
        for (Index s = 0; s < surfels.size(); ++s) {
            d.row(s).setConstant(surfels.area(s) > 0.0 ? share_[s] / surfels.area(s) : 0.0);
        }
        return d;
    }

    /// The irradiance from the places as lamps of the power 1 together, by reciprocity; per surfel.
    Values light_of_places() {
        const Surfels& surfels = *system_.discretisation().surfels;
        const std::size_t rays = std::max(rays_, (adjoint_rays + goal_.places.size() - 1) / goal_.places.size());
        const LightTransport sight =
            gathered(system_.tracer(), goal_.places, surfels, system_.fresh_directions(), rays, seed_, execution_);
        result_.rays += sight.rays;
        const auto n = static_cast<Eigen::Index>(goal_.places.size());
        Values shares;
        sight.W->apply_transpose(Values::Constant(n, channels_, 1.0 / static_cast<double>(n)), shares, execution_);
        if (const GlossyTransport* const glossy = glossy_part(*system_.transport().W)) {
            glossy->add_seen(*sight.glossy, Values::Constant(n, channels_, 1.0 / static_cast<double>(n)), shares,
                             execution_);
        }
        Values light(static_cast<Eigen::Index>(surfels.size()), channels_);
        for (Index s = 0; s < surfels.size(); ++s) {
            light.row(s) = surfels.area(s) > 0.0 ? Values(shares.row(s) / surfels.area(s))
                                                 : Values(Values::Zero(1, channels_)); // reflects nothing
        }
        return light;
    }

    /// What the surfels send back and forth if the goal is a lamp: `sent_`, of which D sent_ is z, besides the light of
    /// places, `from_places_`. Of places that paths are followed from, z is without the light that comes to a surfel
    /// directly or after one reflection: `met_mean` has these. `expected_`, which only says where to measure, is z as
    /// the basis represents it, then without the former only.
    void find_adjoint() {
        const Values& rho = solution_.light.reflectance;
        from_places_ = Values::Zero(rho.rows(), channels_);
        Values b;
        if (goal_.triangles.empty()) {
            from_places_ = light_of_places();
            b = rho.cwiseProduct(from_places_);
        } else {
            b = lamp();
        }
        SolveOptions solve;
        solve.tolerance = 1e-3;
        solve.max_iterations = 100;
        solve.confirm = false;
        const Values z = system_.respond(rho, b, solve, execution_);
        adjoint_ = system_.discretisation().evaluation->coefficients(z, execution_);
        Values means;
        system_.discretisation().averages->apply(adjoint_, means, execution_);
        expected_ = means;
        if (!follows_places_) {
            expected_ += from_places_;
        }
        if (between_surfels_ != nullptr) {
            sent_ = rho.cwiseProduct(between_surfels_->respond(rho, b, std::move(means), solve.tolerance, execution_));
            if (!follows_places_) {
                sent_ += b;
            }
        }
    }

    /// Points where the goal's error comes from: half of them in proportion to rho z, half to its product with the
    /// deviation of what is approximated there.
    void draw_sources() {
        const Surfels& surfels = *system_.discretisation().surfels;
        const Values weight = expected_.cwiseAbs().cwiseProduct(solution_.light.reflectance);
        const ErrorSources sources = error_sources(solution_, execution_);
        const Values deviation = (sources.variation + sources.noise / static_cast<double>(rays_)).cwiseSqrt();
        std::vector<double> density(surfels.size());
        double all = 0.0, deviating = 0.0;
        const auto both = [&](Index s) {
            return std::array<double, 2>{weight.row(s).sum() * surfels.area(s),
                                         weight.row(s).dot(deviation.row(s)) * surfels.area(s)};
        };
        for (Index s = 0; s < surfels.size(); ++s) {
            all += both(s)[0];
            deviating += both(s)[1];
        }
        for (Index s = 0; s < surfels.size() && all > 0.0; ++s) {
            density[s] = both(s)[0] / all + (deviating > 0.0 ? both(s)[1] / deviating : 0.0);
        }
        RandomStream own = stream("goal sources", 0);
        sources_ = draw_surfel_points(surfels, density, count_, static_cast<Index>(repetitions), own);
        if (between_surfels_ == nullptr) {
            adjoint_there_ = evaluate(*system_.discretisation().basis, adjoint_, sources_.place, execution_);
            return;
        }
        // With rays of their own, so that their noise is independent of that of the residual.
        const LightTransport sight =
            gathered(system_.tracer(), sources_.place, surfels, system_.fresh_directions(),
                     std::max(least_adjoint_rays, rays_ / 4), stream("goal adjoint", 0).bits(), execution_);
        result_.rays += sight.rays;
        sight.gather(sent_, {}, adjoint_there_, execution_);
    }

    /// h(x; h~) - h~(x), all sets together; adds up the rays.
    Values residual(std::span<const SurfacePoint> x, const std::string& purpose) {
        const Irradiance own = field_.evaluate_smooth(x, execution_);
        const Irradiance fresh = field_.gather_smooth(x, rays_, seed_, purpose, execution_);
        result_.rays += fresh.rays;
        result_.segments += fresh.segments;
        Values s = sum(fresh.direct + fresh.indirect) - sum(own.direct + own.indirect);
        if (parts_.direct_in_basis) {
            s += sharp(x, purpose);
        }
        return s;
    }

    Values sharp(std::span<const SurfacePoint> x, const std::string& purpose) {
        DirectLight::Effort effort;
        Values light = sum(field_.sharp(x, seed_, purpose, execution_, effort));
        result_.segments += effort.segments;
        return light;
    }

    /// On an area, what is known of the surfels is a control variate: only the light's variation within them is drawn.
    Eigen::RowVectorXd field_mean(std::size_t k) {
        const std::vector<SurfacePoint> x = sampler_.draw(direct_points * count_, stream("goal field", k));
        const Irradiance own = field_.evaluate_smooth(x, execution_);
        Values H = sum(own.direct + own.indirect);
        if (!parts_.direct_in_basis) {
            H += sharp(x, named("goal field", k));
        }
        if (goal_.triangles.empty()) {
            return H.colwise().mean();
        }
        const Surfels& surfels = *system_.discretisation().surfels;
        for (std::size_t i = 0; i < x.size(); ++i) {
            H.row(static_cast<Eigen::Index>(i)) -= known_.row(surfels.at(x[i].face, x[i].u, x[i].v));
        }
        return mean_known_ + H.colwise().mean();
    }

    Eigen::RowVectorXd residual_mean(std::size_t k) {
        return residual(sampler_.draw(count_, stream("goal residual", k)), named("goal residual", k)).colwise().mean();
    }

    /// Where light comes from: a surface point, and what its radiosity counts with.
    struct Met {
        SurfacePoint place;
        Rgb weight;
    };

    /// Appends what a ray from x meets: a surface, and others in mirrors.
    void add_met(const SurfacePoint& x, const std::array<double, 2>& u, const Rgb& factor, ChosenRays& sight,
                 std::vector<Met>& met) {
        const auto add = [&](const Hit& hit, double share, const Rgb& colour) {
            met.push_back({scene_.mesh.shaded(scene_.mesh.at(hit.face, hit.u, hit.v)), share * factor * colour});
        };
        const Ray ray = diffuse_ray(scene_.mesh, x, u);
        const double one = 1.0;
        sight.look({&ray, 1}, {&one, 1});
        ++result_.rays;
        sight.for_each([&](const Hit& hit, double share) { add(hit, share, Rgb::Ones()); }, [](const Vec3&, double) {});
        sight.for_each_in_mirrors(
            add, [](const Vec3&, double, const Rgb&) {}, [](double, const Rgb&, bool) {});
    }

    /// K rho s + K rho K rho s at the places, by paths over one and two surface points: exact however the light varies
    /// near the places, as it does in corners.
    Eigen::RowVectorXd met_mean(std::size_t k) {
        Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(channels_);
        if (!follows_places_) {
            return sum;
        }
        const std::size_t places = goal_.places.size(), rays = std::max<std::size_t>(1, count_ / places);
        RandomStream own = stream("goal paths", k);
        ChosenRays sight(system_.tracer());
        std::vector<Met> met;
        for (const SurfacePoint& place : goal_.places) {
            const std::array<double, 2> shift{own.uniform(), own.uniform()};
            for (std::size_t r = 0; r < rays; ++r) {
                add_met(place, even_point(r, shift), Rgb::Constant(1.0 / static_cast<double>(places * rays)), sight,
                        met);
            }
        }
        for (std::size_t i = 0, first = met.size(); i < first; ++i) {
            const Met from = met[i];
            add_met(from.place, {own.uniform(), own.uniform()}, from.weight * scene_.reflectance(from.place), sight,
                    met);
        }
        std::vector<SurfacePoint> x;
        for (const Met& each : met) {
            x.push_back(each.place);
        }
        if (!x.empty()) {
            const Values s = residual(x, named("goal met", k));
            for (std::size_t i = 0; i < x.size(); ++i) {
                const Rgb factor = met[i].weight * scene_.reflectance(x[i]);
                sum += factor.head(channels_).matrix().transpose().cwiseProduct(s.row(static_cast<Eigen::Index>(i)));
            }
        }
        return sum;
    }

    /// <rho z, s> from the points of group k; of places, without the parts of z that `met_mean` weighs.
    Eigen::RowVectorXd carried_mean(std::size_t k) {
        Eigen::RowVectorXd product = Eigen::RowVectorXd::Zero(channels_);
        std::vector<SurfacePoint> x;
        std::vector<std::size_t> number;
        for (std::size_t p = 0; p < sources_.size(); ++p) {
            if (sources_.group[p] == k) {
                x.push_back(sources_.place[p]);
                number.push_back(p);
            }
        }
        if (x.empty()) { // nothing is reflected
            return product;
        }
        const Values s = residual(x, named("goal sources", k));
        for (std::size_t i = 0; i < x.size(); ++i) {
            const std::size_t p = number[i];
            const auto row = static_cast<Eigen::Index>(i);
            const Eigen::RowVectorXd rho = scene_.reflectance(x[i]).head(channels_).matrix().transpose();
            Eigen::RowVectorXd z = adjoint_there_.row(static_cast<Eigen::Index>(p));
            if (!follows_places_) {
                z += from_places_.row(static_cast<Eigen::Index>(sources_.surfel[p]));
            }
            // The weights are those of a mean over all repetitions.
            product += repetitions * sources_.weight[p] * rho.cwiseProduct(z).cwiseProduct(s.row(row));
        }
        return product;
    }

    const Solution& solution_;
    const Goal& goal_;
    const SurfelTransport* between_surfels_;
    const Field& field_;
    const FieldParts& parts_;
    const RadiositySystem& system_;
    const Scene& scene_;
    GoalSampler sampler_;
    int channels_;
    bool follows_places_;      ///< the first two bounces from the goal are those of paths
    std::size_t rays_, count_; ///< a gather; points of a repetition
    std::uint64_t seed_;
    Execution execution_;
    std::vector<double> share_;     ///< #surfels: of the goal's area
    Values known_;                  ///< #surfels by #channels: mean irradiance
    Eigen::RowVectorXd mean_known_; ///< over the goal
    Values from_places_, sent_;     ///< #surfels by #channels
    Values adjoint_;                ///< #S by #channels: coefficients of z, without the light of places
    Values expected_;               ///< #surfels by #channels: means of z
    Values adjoint_there_;          ///< #sources by #channels: z, without the light of places
    SurfelPoints sources_;
    GoalEstimate result_;
};

/// From each surfel: in all about as many as from the sites.
std::size_t rays_between_surfels(const RadiositySystem& system) {
    constexpr std::size_t least = 8, most = 64;
    const std::size_t surfels = std::max<std::size_t>(1, system.discretisation().surfels->size());
    return std::clamp(system.transport().rays / surfels, least, most);
}

} // namespace

std::vector<double> goal_shares(const Goal& goal, double area, const Mesh& mesh, const Surfels& surfels) {
    std::vector<char> inside(mesh.triangles.size(), 0);
    for (const Index t : goal.triangles) {
        inside[t] = 1;
    }
    std::vector<double> share(surfels.size(), 0.0);
    std::vector<Surfels::Piece> pieces;
    for (Index s = 0; s < surfels.size(); ++s) {
        surfels.pieces(s, pieces);
        for (const Surfels::Piece& piece : pieces) {
            share[s] += inside[piece.triangle] != 0 ? piece.area / area : 0.0;
        }
    }
    return share;
}

std::vector<GoalEstimate> estimate_goals(const Solution& solution, std::span<const Goal> goals, std::size_t samples,
                                         std::size_t rays, std::uint64_t seed, const Execution& execution) {
    std::vector<GoalEstimate> estimates;
    std::optional<SurfelTransport> between_surfels;
    const RadiositySystem& system = *solution.field->parts().system;
    if (!goals.empty() && glossy_part(*system.transport().W) == nullptr) {
        between_surfels.emplace(system, rays_between_surfels(system), RandomStream(seed, "goal surfels").bits(),
                                execution.silent());
    }
    for (std::size_t i = 0; i < goals.size(); ++i) {
        GoalEstimation estimation(solution, goals[i], between_surfels ? &*between_surfels : nullptr, samples, rays,
                                  seed, i, execution);
        estimates.push_back(estimation.run());
    }
    if (between_surfels) {
        estimates.front().rays += between_surfels->rays();
    }
    return estimates;
}

} // namespace difusa
