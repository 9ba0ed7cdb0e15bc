#include <difusa/radiosity/system.h>

#include <difusa/algebra/factors.h>
#include <difusa/core/parallel.h>
#include <difusa/core/text.h>
#include <difusa/lighting/glossy_light.h>
#include <difusa/radiosity/exact_correction.h>
#include <difusa/radiosity/reflected_transport.h>
#include <difusa/radiosity/response.h>
#include <difusa/scene/sky_parts.h>
#include <difusa/scene/sound_scene.h>
#include <difusa/transport/analytic_transport.h>
#include <difusa/transport/glossy_transport.h>

#include <algorithm>
#include <cmath>

namespace difusa {

namespace {

/// One lighting in a call of RadiositySystem::solve.
class Solving {
  public:
    Solving(const RadiositySystem& system, const std::shared_ptr<const Scene>& scene, const LightingOptions& options,
            int channels, const Execution& execution)
        : system_(system), discretisation_(system.discretisation()), transport_(system.transport()), scene_(scene),
          options_(options), execution_(execution), channels_(channels),
          sources_(std::make_shared<DirectLight>(*scene, system.tracer(), options.sets)) {}

    /// Everything before the linear system.
    void prepare() {
        light_surfels();
        check_dark_surfaces();
        direct_light();
    }

    bool is_dark() const {
        return !((soft_.size() > 0 && soft_.maxCoeff() > 0.0) || (sharp_.size() > 0 && sharp_.maxCoeff() > 0.0) ||
                 result_.light.direct.maxCoeff() > 0.0);
    }

    /// Refuses a dark lighting, unless it has emitters.
    void refuse_darkness() const {
        if (!scene_->has_emitters()) {
            throw InputError("no light reaches the front of any face, as far as rays have found: no face emits, no "
                             "point that was looked at sees the sky or a sun, and no other lamp lights one. Give some "
                             "faces an emission (OBJ: Ke in the material), open the mesh, turn faces and lamps towards "
                             "each other (--flip all) or, if openings are small or beams narrow, give more --sites and "
                             "--rays");
        }
        execution_.note(
            "no ray has met any of the faces that emit: they face away from everything, or are too small for "
            "so few --rays");
    }

    /// The right-hand side.
    const Values& g() const { return g_; }
    const Values& reflectance() const { return result_.light.reflectance; }

    /// What another lighting of the same reflectances has found.
    void take_contraction(const Solving& other) {
        result_.spectral_radius = other.result_.spectral_radius;
        result_.spectral_radius_is_bound = other.result_.spectral_radius_is_bound;
    }

    /// Everything after it. `solved`: of these columns.
    Solution finish(SolveSummary solved, std::shared_ptr<const RadiositySystem> owner) {
        result_.solve = std::move(solved);
        result_.h = std::move(result_.solve.h);
        make_field(std::move(owner));
        for (KeptIterate& kept : result_.iterates) {
            kept.smooth = coefficients(kept.smooth);
        }
        balance();
        return std::move(result_);
    }

    /// The solution of all columns of g, which are reflected as those of this lighting.
    SolveSummary solve(Values g) {
        const ReflectedTransport T(discretisation_, transport_, result_.light.reflectance);
        const SolveProblem problem{&T, std::move(g)};
        SolveOptions how = options_.solve;
        if (options_.keep_iterates) {
            how.watch = [this](const Iterate& iterate) { keep(iterate); };
        }
        SolveSummary solved = system_.parts().solver->solve(problem, how, execution_);
        if (!solved.converged()) {
            throw NotConverged("the solver " + solved.sentence() + " (wanted: " + text_of(options_.solve.tolerance) +
                               "). The spectral radius is " + text_of(result_.spectral_radius) + ": " +
                               solved.remedy());
        }
        DIFUSA_REQUIRE(solved.h.rows() == problem.g.rows() && solved.h.cols() == problem.g.cols());
        Values residual;
        const std::vector<double> misses = relative_residual(problem, solved.h, residual, execution_);
        for (Eigen::Index c = 0; c < residual.cols(); ++c) {
            const double miss = misses[static_cast<std::size_t>(c)];
            if (!(miss <= 10.0 * options_.solve.tolerance ||
                  is_rounding(residual.col(c).cwiseAbs().maxCoeff<Eigen::PropagateNaN>(),
                              solved.h.col(c).cwiseAbs().maxCoeff<Eigen::PropagateNaN>()))) {
                throw NotConverged("the solver claims convergence, but its residual is " + text_of(miss) +
                                   ": use another --solver");
            }
        }
        return solved;
    }

    /// Rejects an equation whose series of bounces does not converge (T has a spectral radius of 1 or more): a solver
    /// may still return numbers, but they are meaningless.
    void check_contraction(const Contraction& found) {
        result_.spectral_radius = found.radius;
        result_.spectral_radius_is_bound = found.is_bound;
        if (!found.dies_out()) {
            throw BouncesDoNotDieOut(divergence());
        }
    }

  private:
    std::size_t set_count() const { return options_.sets.count(); }
    Eigen::Index columns() const { return static_cast<Eigen::Index>(set_count()) * channels_; }

    /// The last of those with the same number of relaxations counts.
    void keep(const Iterate& iterate) {
        if (!result_.iterates.empty() && result_.iterates.back().relaxations == iterate.relaxations) {
            result_.iterates.pop_back();
        }
        result_.iterates.push_back({iterate.relaxations, iterate.entries, iterate.residual, iterate.h});
    }

    void light_surfels() {
        execution_.phase("light surface");
        result_.area_lights = sources_->area_light_count();
        result_.light =
            light_on_surfels(*scene_, *discretisation_.surfels, *sources_, channels_, system_.parts().seed, execution_);
        execution_.count("segments", result_.light.segments);
        if (sources_->any() || result_.light.uneven_emission.rows() > 0) {
            bright_ = std::make_shared<BrightSurfels>(*scene_, system_.tracer(), *discretisation_.surfels, *sources_,
                                                      result_.light);
            if (!sources_->any() && !bright_->samples_emission()) {
                bright_.reset();
            }
        }
    }

    /// Refuses lights that reach surfaces without sites (SiteSet::dark): their light would be lost.
    void check_dark_surfaces() const {
        const SiteSet& sites = *discretisation_.sites;
        const Scene& own = *system_.parts().scene;
        if (sites.dark.empty() || scene_.get() == &own) {
            return;
        }
        bool lit = scene_->has_sky() && !own.has_sky();
        std::vector<Surfels::Piece> pieces;
        const Surfels& surfels = *discretisation_.surfels;
        for (Index s = 0; s < surfels.size() && !lit; ++s) {
            if ((result_.light.direct.row(s).array() != 0.0).any() ||
                (result_.light.emission.row(s).array() != 0.0).any()) {
                surfels.pieces(s, pieces);
                lit = sites.is_dark(scene_->mesh.region[pieces.front().triangle]);
            }
        }
        if (lit) {
            throw UsageError("light may reach surfaces that the lights of the first bake did not, and that have no "
                             "sites for this reason: make the system with BakeOptions::every_surface");
        }
    }

    /// The light arriving before any reflection (`soft_`, `sharp_`), and the first bounce of the latter.
    void direct_light() {
        execution_.phase("direct light");
        if (sources_->images() != nullptr && !sources_->images()->is_complete()) {
            execution_.note("images of lamps and suns are followed over at most " +
                            std::to_string(sources_->images()->followed()) +
                            " mirrors in a row: there would be too many of longer chains, and their light is left "
                            "out");
        }
        if (const std::size_t depth = sources_->depth_of_images(); depth > 0) {
            execution_.note("lamps light the scene from up to " + std::to_string(depth) +
                            " periods, or reflections in parallel symmetry planes in a row, away" +
                            (depth == scene_->mesh.mirrors.most ? " (--mirror-depth)" : ""));
        }
        Values sky = Values::Zero(SkyParts::count, columns());
        if (scene_->has_sky()) {
            sky.middleCols(static_cast<Eigen::Index>(options_.sets.sky) * channels_, channels_) =
                sky_radiosity(*scene_, channels_);
        }
        const bool in_basis = options_.direct_in_basis;
        // Glossy surfaces and exact form factors are not among the rows that bright surfels supplement.
        const bool emission_too = !in_basis && bright_ && bright_->samples_emission() && samples_bright() &&
                                  glossy_part(*transport_.W) == nullptr;
        const Values bright = from_bright_surfels(emission_too);
        transport_.gather(emission_too ? Values(result_.light.emission - result_.light.uneven_emission)
                                       : result_.light.emission,
                          sky, soft_, execution_);
        if (emission_too) {
            soft_ += bright.rightCols(columns());
        }
        transport_.gather(Values::Zero(static_cast<Eigen::Index>(transport_.surfels), channels_),
                          scene_->has_sky() ? sky_radiosity(*scene_, channels_) : Values(), from_sky_, execution_);
        DirectLight::Effort effort;
        const std::size_t count = in_basis ? discretisation_.points.size() : discretisation_.sites->size();
        sharp_ = sources_->irradiance(std::span(discretisation_.points).first(count), channels_, options_.shadow_rays,
                                      system_.parts().seed, "direct light", execution_, effort);
        execution_.count("segments", effort.segments);
        execution_.count("unobstructed points", effort.clear);
        g_ = soft_;
        if (in_basis) {
            g_ += sharp_;
        } else if (bright.rows() > 0) {
            g_ += bright.leftCols(columns());
        }
        if (const GlossyTransport* const glossy = glossy_part(*transport_.W); glossy != nullptr && sources_->any()) {
            g_ += first_glossy_bounce(*glossy);
        }
    }

    /// What glossy surfaces pass on of the light of suns, point lights and area lights.
    Values first_glossy_bounce(const GlossyTransport& glossy) {
        const GlossyLight light = glossy_light_on_surfels(
            *scene_, *discretisation_.surfels, glossy.rays().surfels(), glossy.harmonics(),
            [&](Index number) -> const LobeHarmonics& { return glossy.lobe(number); }, *sources_, channels_,
            system_.parts().seed, execution_);
        execution_.count("segments", light.segments);
        from_lights_ = glossy.from_surfels(light.from_outside, execution_);
        return glossy.from_surfels(light.all, execution_);
    }

    /// Whether samples on bright surfels supplement the rays of the operator, because these surfels are few.
    bool samples_bright() const {
        return options_.first_bounce == FirstBounce::live && RowReader(plain_part(*transport_.W)).any() && bright_ &&
               bright_->places(1) > 0;
    }

    /// D (rho ∘ H), with samples on bright surfels where these are few, unless the options leave it at the operator;
    /// then, if wanted, the light of emitters with a texture or pattern in as many columns. No rows: there is neither.
    Values from_bright_surfels(bool emission_too) {
        if (options_.direct_in_basis || (!sources_->any() && !emission_too)) {
            return {};
        }
        Values reflected = result_.light.first_bounce(), h;
        if (emission_too) {
            reflected.conservativeResize(Eigen::NoChange, 2 * columns());
            reflected.rightCols(columns()) = result_.light.uneven_emission;
        }
        const bool live = samples_bright();
        result_.first_bounce = live ? FirstBounce::live : FirstBounce::operator_only;
        if (!live) {
            transport_.gather(reflected, {}, h, execution_);
            return h;
        }
        const RowReader rows(plain_part(*transport_.W));
        const std::vector<SurfacePoint>& points = discretisation_.points;
        const std::size_t rays = transport_.rays / std::max<std::size_t>(1, points.size());
        h.resize(static_cast<Eigen::Index>(points.size()), reflected.cols());
        std::vector<std::size_t> cast(points.size(), 0);
        parallel_for(points.size(), 16, execution_, [&](std::size_t begin, std::size_t end, unsigned) {
            BrightSurfels::Worker worker;
            std::vector<Index> bins;
            std::vector<double> weights;
            for (std::size_t j = begin; j < end; ++j) {
                rows.row(j, bins, weights);
                RandomStream stream(system_.parts().seed, "first bounce", j);
                h.row(static_cast<Eigen::Index>(j)) =
                    bright_->gather(points[j], bins, weights, rays, reflected, stream, worker);
            }
            cast[begin] = worker.light.cast;
        });
        for (const std::size_t each : cast) {
            execution_.count("segments", each);
        }
        if (const std::shared_ptr<const ChannelRows> in_mirrors = part_in_mirrors(*transport_.W)) {
            Values from_mirrors;
            in_mirrors->apply(transport_.on_bins(reflected, {}, execution_), from_mirrors, execution_);
            h += from_mirrors;
        }
        return h;
    }

    std::string divergence() const {
        const double row_sum = transport_.largest_row_sum(execution_);
        const std::string what = "the discretised light transport does not converge: its spectral radius is " +
                                 text_of(result_.spectral_radius) + " (must be below 1; largest row sum of the " +
                                 "transport " + text_of(row_sum) + ", largest reflectance " +
                                 text_of(result_.light.reflectance.maxCoeff()) + "). ";
        const bool absorbs = (result_.light.reflectance.colwise().minCoeff().array() < 1.0).all() ||
                             discretisation_.sites->mean(transport_.sky) > 1e-9;
        if (absorbs && (!discretisation_.projection->is_mean() || !discretisation_.basis->sums_to_one())) {
            return what + "The basis is not a partition of unity: use --basis normalized-radial or shepard, or give "
                          "this one a smaller width";
        }
        if (row_sum > 1.0 + 1e-9 && !part_in_mirrors(*transport_.W)) {
            return what +
                   "Pairwise transport overestimates the exchange between near surfaces: use --transport gather, or "
                   "pairwise:areas=integral with --kernel disc, or a reflectance below 1";
        }
        if (scene_->thermal) {
            return what + "Part of the surface exchanges heat neither with a fixed temperature nor with the "
                          "surroundings, so that its temperature is not determined: fix some temperature there";
        }
        return what + "A closed scene that absorbs nothing has no steady state: give it a reflectance below 1";
    }

    /// Coefficients of the field to evaluate, from values at the points.
    Values coefficients(const Values& values) const {
        const Values own = discretisation_.evaluation->coefficients(values, execution_);
        if (!options_.limit || discretisation_.evaluation == discretisation_.projection) {
            return own;
        }
        return limited_parts(*discretisation_.basis, *discretisation_.sites, values, own, channels_, execution_,
                             scene_->thermal.has_value());
    }

    void make_field(std::shared_ptr<const RadiositySystem> owner) {
        const auto n = static_cast<Eigen::Index>(discretisation_.sites->size());
        const bool in_basis = options_.direct_in_basis;
        result_.direct = soft_.topRows(n) + sharp_.topRows(n);
        result_.irradiance = in_basis ? Values(result_.h.topRows(n)) : Values(result_.h.topRows(n) + sharp_);
        FieldParts parts;
        parts.system = std::move(owner);
        parts.scene = scene_;
        parts.direct = sources_;
        parts.bright = in_basis ? nullptr : bright_;
        parts.soft_direct = coefficients(in_basis ? Values(soft_ + sharp_) : soft_);
        parts.smooth = coefficients(result_.h);
        if (dynamic_cast<const AnalyticTransport*>(transport_.W.get()) != nullptr) {
            Values means;
            discretisation_.averages->apply(parts.smooth, means, execution_);
            parts.sent = std::make_shared<const Values>(
                light_sent(result_.light, means, parts.bright && parts.bright->places(1) == 0,
                           !parts.bright || !parts.bright->samples_emission(), channels_));
        }
        parts.channels = channels_;
        parts.shadow_rays = options_.shadow_rays;
        parts.direct_in_basis = in_basis;
        result_.field = std::make_shared<Field>(std::move(parts));
    }

    void balance() {
        Values irradiance;
        discretisation_.averages->apply(
            discretisation_.projection->coefficients(sum_of_parts(result_.h, channels_), execution_), irradiance,
            execution_);
        if (!options_.direct_in_basis) {
            irradiance += sum_of_parts(result_.light.direct, channels_);
        }
        result_.energy = energy_balance(*scene_, system_.tracer(), system_.parts().seed, discretisation_, transport_,
                                        result_.light, irradiance, from_sky_, from_lights_, execution_);
        const double lost = result_.energy.imbalance.abs().maxCoeff();
        if (lost > 0.1) {
            execution_.note(text_of(std::round(100.0 * lost)) +
                            (scene_->thermal ? " % of the heat" : " % of the light") +
                            " is lost or created between the sites: use a smaller --spacing, and more "
                            "--rays");
        }
    }

    const RadiositySystem& system_;
    const Discretisation& discretisation_;
    const LightTransport& transport_;
    std::shared_ptr<const Scene> scene_;
    const LightingOptions& options_;
    const Execution& execution_;
    int channels_;
    std::shared_ptr<const DirectLight> sources_;
    std::shared_ptr<const BrightSurfels> bright_;
    Values soft_;        ///< #points: from emitters that are not area lights, and the sky
    Values sharp_;       ///< #S, or #points if represented in the basis: from suns, point lights and area lights
    Values from_sky_;    ///< #points by #channels
    Values from_lights_; ///< likewise, from suns and point lights after glossy reflections; no rows: there are none
    Values g_;
    Solution result_;
};

/// What became of some of the columns. The numbers of iterations and entries are those of all.
SolveSummary columns_of(const SolveSummary& all, Eigen::Index first, Eigen::Index count) {
    SolveSummary part;
    part.reason = all.reason;
    part.iterations = all.iterations;
    part.change = all.change;
    part.to_rounding = all.to_rounding;
    part.entries_touched = all.entries_touched;
    part.residual_history.assign(all.residual_history.begin() + first, all.residual_history.begin() + first + count);
    for (const std::vector<double>& history : part.residual_history) {
        part.residual = std::max(part.residual, history.back());
    }
    part.h = all.h.middleCols(first, count);
    return part;
}

} // namespace

std::shared_ptr<const Field> Solution::field_of(const KeptIterate& iterate) const {
    FieldParts parts = field->parts();
    parts.smooth = iterate.smooth;
    parts.sent = nullptr; // that of the solution
    return std::make_shared<Field>(std::move(parts));
}

Solution RadiositySystem::solve(const std::shared_ptr<const Scene>& scene, const LightingOptions& options,
                                const Execution& execution) const {
    return std::move(solve(std::span(&scene, 1), options, execution).front());
}

std::vector<Solution> RadiositySystem::solve(std::span<const std::shared_ptr<const Scene>> scenes,
                                             const LightingOptions& options, const Execution& execution) const {
    if (options.keep_iterates && scenes.size() > 1) {
        throw UsageError("the iterates of one scene can be kept, not of several that are solved for together");
    }
    if (scenes.empty()) {
        return {};
    }
    std::vector<LightingOptions> complete; // for each
    for (const std::shared_ptr<const Scene>& scene : scenes) {
        if (scene == nullptr) {
            throw UsageError("there is no scene to be lit: the pointer is null");
        }
        check_scene(*scene);
        complete.push_back(options);
        LightSets& sets = complete.back().sets;
        sets = sets.count() == 0 ? all_lights(*scene) : sets;
        if (sets.material.size() != scene->materials.size() || sets.sun.size() != scene->suns.size() ||
            sets.point.size() != scene->point_lights.size()) {
            throw UsageError("the sets of lights are those of another scene");
        }
    }
    std::vector<Solving> each;
    std::vector<Eigen::Index> first{0}; // column
    each.reserve(scenes.size());
    const bool grey = std::all_of(scenes.begin(), scenes.end(), [](const auto& scene) { return scene->is_grey(); });
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        each.emplace_back(*this, scenes[i], complete[i], grey ? 1 : 3, execution);
        each.back().prepare();
        first.push_back(first.back() + each.back().g().cols());
        if (each[i].reflectance() != each[0].reflectance()) {
            throw UsageError("scenes that are lit together must have the same reflectances");
        }
    }
    if (!options.may_be_dark &&
        std::all_of(each.begin(), each.end(), [](const Solving& one) { return one.is_dark(); })) {
        each.front().refuse_darkness();
    }
    execution.phase("check convergence");
    each.front().check_contraction(contraction_with(each.front().reflectance(), execution));
    execution.phase("solve");
    std::vector<SolveSummary> solved;
    const Eigen::Index most = columns_at_once(transport());
    for (std::size_t begin = 0, end = 0; begin < each.size(); begin = end) {
        for (end = begin + 1; end < each.size() && first[end + 1] - first[begin] <= most; ++end) {
        }
        Values g(each.front().g().rows(), first[end] - first[begin]);
        for (std::size_t i = begin; i < end; ++i) {
            g.middleCols(first[i] - first[begin], each[i].g().cols()) = each[i].g();
        }
        const SolveSummary together = each.front().solve(std::move(g));
        for (std::size_t i = begin; i < end; ++i) {
            solved.push_back(columns_of(together, first[i] - first[begin], each[i].g().cols()));
        }
    }
    std::vector<Solution> solutions;
    for (std::size_t i = 0; i < each.size(); ++i) {
        each[i].take_contraction(each.front());
        solutions.push_back(each[i].finish(std::move(solved[i]), shared_from_this()));
    }
    return solutions;
}

std::optional<Contraction> RadiositySystem::contraction() const {
    const std::lock_guard lock(guard_);
    return contraction_;
}

/// The one that is known, if it is of these reflectances.
Contraction RadiositySystem::contraction_with(const Values& reflectance, const Execution& execution) const {
    const std::uint64_t wanted = reflectance_fingerprint(reflectance);
    if (const std::optional<Contraction> known = contraction(); known && known->reflectance == wanted) {
        return *known;
    }
    Contraction found = contraction_of(parts_.discretisation, parts_.transport, reflectance, execution);
    found.reflectance = wanted;
    const std::lock_guard lock(guard_);
    contraction_ = found;
    return found;
}

void RadiositySystem::check_scene(const Scene& scene) const {
    const Mesh &own = parts_.scene->mesh, &other = scene.mesh;
    if (std::any_of(other.material.begin(), other.material.end(),
                    [&](Index material) { return material >= scene.materials.size(); })) {
        throw UsageError("a triangle has a material that the scene does not have");
    }
    check_materials_and_lights(scene, "the scene");
    const auto same_reflections = [&] {
        const Mirrors &a = own.mirrors, &b = other.mirrors;
        const GlossySurfaces &c = own.glossy, &d = other.glossy;
        const bool same_gloss =
            c.of_face == d.of_face && std::equal(c.kinds.begin(), c.kinds.end(), d.kinds.begin(), d.kinds.end(),
                                                 [&](const GlossySurfaces::Kind& x, const GlossySurfaces::Kind& y) {
                                                     return (x.reflectance == y.reflectance).all() &&
                                                            c.lobes[x.lobe]->shape() == d.lobes[y.lobe]->shape();
                                                 });
        return same_gloss && a.of_face == b.of_face && a.most == b.most &&
               std::equal(a.reflectance.begin(), a.reflectance.end(), b.reflectance.begin(), b.reflectance.end(),
                          [](const Rgb& x, const Rgb& y) { return (x == y).all(); });
    };
    if (&own != &other && (own.points != other.points || own.triangles != other.triangles || !same_reflections())) {
        throw UsageError("the scene's surface is not the one the system was built for");
    }
}

Values RadiositySystem::respond(const Values& reflectance, const Values& b, const SolveOptions& options,
                                const Execution& execution) const {
    Values g;
    transport().gather(b, {}, g, execution);
    const ReflectedTransport T(discretisation(), transport(), reflectance);
    Values reflected;
    T.apply(g, reflected, execution);
    return g + parts_.solver->solve({&T, std::move(reflected)}, options, execution).h;
}

} // namespace difusa
