#include <difusa/bake/relight.h>

#include <difusa/bake/cost.h>
#include <difusa/bake/evaluation.h>
#include <difusa/bake/fronts.h>
#include <difusa/bake/scene.h>
#include <difusa/bake/sensing.h>
#include <difusa/bake/steps.h>
#include <difusa/core/error.h>
#include <difusa/core/memory.h>
#include <difusa/core/text.h>
#include <difusa/io/same_file.h>
#include <difusa/rays/unfolded_visibility.h>
#include <difusa/transport/pairwise.h>
#include <difusa/transport/recast.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

namespace difusa {

namespace {

/// The options, with those that the transport depends on from there.
BakeOptions complete_options(BakeOptions options, const BakeOptions& saved) {
    options.basis = saved.basis;
    options.sampler = saved.sampler;
    options.transport = saved.transport;
    options.directions = saved.directions;
    options.analytic = saved.analytic;
    options.kernel = saved.kernel;
    options.projection = saved.projection;
    options.flip = saved.flip;
    options.quality = saved.quality;
    options.spacing = saved.spacing;
    options.sites = 0;
    options.adaptive = saved.adaptive;
    options.neighbours = saved.neighbours;
    options.rays = saved.rays;
    options.mirror_depth = saved.mirror_depth;
    options.gloss = false;  // a transport with gloss is not saved
    options.target.reset(); // sites and rays are what they are
    options.seed = saved.seed;
    options.reflectance = options.reflectance ? options.reflectance : saved.reflectance;
    options.every_surface = true;
    return options;
}

/// Throws UsageError if the sun leaves a symmetry plane of the surface.
void check_symmetry(const std::vector<SunStep>& steps, const std::vector<Repetition::Plane>& planes) {
    for (std::size_t i = 0; i < planes.size(); ++i) {
        for (const SunStep& step : steps) {
            if (std::abs(planes[i].normal.dot(step.sun.towards)) > 1e-5 * planes[i].normal.norm()) {
                throw UsageError("--sun-path: the sun is not in symmetry plane " + std::to_string(i + 1) + " at " +
                                 text_of(step.hours) +
                                 " h, and a part of a scene stands for the whole only in light that is symmetric, too: "
                                 "bake and save the whole scene, without \"symmetry\"");
            }
        }
    }
}

/// One call of `relight`.
class Relighting {
  public:
    /// `path`: null without one.
    Relighting(const Registry& registry, const SavedTransport& saved, const RelightOptions& how, const SunPath* path,
               BakeResult& result, Choices& choices, const Execution& execution)
        : registry_(registry), saved_(saved), how_(how), path_(path), result_(result), choices_(choices),
          execution_(execution) {
        if (!how.moves.empty() && saved.form_factors) {
            throw UsageError("--move: pairwise transport connects all sites by form factors, which a motion changes: "
                             "bake the moved scene, or with --transport gather");
        }
        result.options.sites = saved.options.sites;
        result.light_factors = how.factors;
        const auto turns_off = [](const LightFactors& factors) {
            return std::any_of(factors.begin(), factors.end(), [](const auto& each) { return each.second == 0.0; });
        };
        turned_off_ = turns_off(how.change.scale) || turns_off(how.factors);
        choices.may_be_dark = path != nullptr || !how.evaluate || turned_off_; // the sun may be behind a wall
        result.transport_file = saved.file.string();
        BakeOptions& all = result.requested; // in case it is saved again
        all.sky = all.sky ? all.sky : saved.options.sky;
        all.suns.insert(all.suns.begin(), saved.options.suns.begin(), saved.options.suns.end());
        all.point_lights.insert(all.point_lights.begin(), saved.options.point_lights.begin(),
                                saved.options.point_lights.end());
    }

    /// The lights of the bake and the changes to them.
    SceneChange change() {
        return [this](Scene& scene) {
            if (is_thermal(scene) && (!how_.change.is_empty() || path_ != nullptr)) {
                throw UsageError(result_.file +
                                 ": is a thermal scene, which has no lights and colours to change: change "
                                 "temperatures in its file, and relight it");
            }
            add_chosen_lights(scene, saved_.options);
            if (!is_thermal(scene) && !has_light(scene)) { // as the bake did; its sky may be replaced
                const bool replaced = result_.options.sky.has_value();
                assume_sky(result_, scene, replaced ? Execution{1} : execution_);
                result_.sky_assumed = !replaced;
            }
            const bool lit = has_light(scene);
            refuse_scaled_sky(scene);
            change_light(how_.change, scene);
            if (path_ != nullptr) {
                SunPath path = *path_;
                path.photometric = result_.photometric_lights;
                steps_ = sun_steps(path, result_.up);
                check_symmetry(steps_, scene.mesh.repetition.planes);
                moving_ = scene.suns.size();
                scene.suns.push_back(steps_.front().sun);
            }
            const BakeOptions& options = result_.options;
            const bool others = options.sky || !options.suns.empty() || !options.point_lights.empty();
            result_.turned_off = lit && !others && !has_light(scene);
        };
    }

    /// A factor on a sky that another one replaces would have no effect.
    void refuse_scaled_sky(const Scene& scene) const {
        const LightSets sets = light_groups(scene);
        for (const auto& [name, factor] : how_.change.scale) {
            bool sky_alone = name == sets.names[sets.sky] && scene.has_sky();
            for (const std::vector<Index>& others : {sets.material, sets.sun, sets.point}) {
                sky_alone = sky_alone && std::find(others.begin(), others.end(), sets.sky) == others.end();
            }
            if (result_.options.sky && sky_alone) {
                throw UsageError("--scale " + name + ": --sky replaces the sky that it would scale: give one of them");
            }
        }
    }

    /// `visit`: of the steps of the path.
    void run(const SunStepVisit& visit) {
        solve();
        if (!how_.evaluate) {
            return;
        }
        if (path_ == nullptr && turned_off_ && result_.solution.irradiance.isZero(0.0)) {
            execution_.note(result_.turned_off
                                ? "all lights are turned off: nothing is lit"
                                : "the lights that are left do not reach the front of any face: nothing is lit");
        }
        estimate_error_of(result_, execution_);
        evaluate_solution(result_, execution_);
        if (path_ != nullptr) {
            visit(steps_.front(), result_);
            light_further_steps(visit);
        }
    }

  private:
    void solve() {
        restore_surface();
        check_sites();
        Placed placed = move_objects();
        if (!before_) { // else the operator is another one
            placed.contraction = saved_.contraction;
            placed.elements = saved_.elements;
        }
        open_if_seen_from_outside(result_);
        execution_.phase("build ray tree");
        choices_.engine = built_over(result_.scene->mesh, choices_.engine);
        if (result_.options.when_visible) {
            result_.options.when_visible(*result_.scene, *choices_.engine, result_.camera, result_.up);
        }
        result_.sites = placed.sites;
        BakeOptions& options = result_.options;
        if (options.output_spacing == 0.0) {
            options.output_spacing = options.output_in_spacings * options.spacing;
        }
        check_request(result_, execution_);
        const DirectLight lights(*result_.scene, Tracer(result_.scene->mesh, *choices_.engine));
        result_.estimate = estimate_cost(result_, choices_, lights, placed.sites->size(), execution_);
        solve_placed(
            result_, choices_, placed,
            [this](const Discretisation& discretisation, const Execution& execution) {
                return transport_of(discretisation, execution);
            },
            execution_);
        const std::string because = result_.recast ? "the transport was loaded, and they cannot meet what has moved"
                                                   : "the transport was loaded";
        const std::size_t kept = result_.recast ? result_.recast->kept : saved_.gathered.rays;
        if (kept > 0) {
            execution_.save({"rays from the sites", because, "rays", static_cast<double>(kept)});
        }
    }

    /// All steps but the first, a block at a time.
    void light_further_steps(const SunStepVisit& visit) {
        execution_.phase("further times");
        const Scene first = *result_.scene;
        const LightingOptions options = lighting_options(result_, choices_);
        const std::size_t block = steps_of_block(options.sets.count());
        for (std::size_t begin = 1; begin < steps_.size(); begin += block) {
            const std::size_t end = std::min(steps_.size(), begin + block);
            Journal journal; // what is noted of the first step need not be said of the others
            const Execution own = execution_.with(execution_.progress, &journal);
            std::vector<std::shared_ptr<Scene>> scenes;
            for (std::size_t i = begin; i < end; ++i) {
                scenes.push_back(std::make_shared<Scene>(first));
                scenes.back()->suns[moving_] = steps_[i].sun;
            }
            std::vector<Solution> solutions = result_.system->solve(
                std::vector<std::shared_ptr<const Scene>>(scenes.begin(), scenes.end()), options, own);
            for (std::size_t i = begin; i < end; ++i) {
                result_.scene = std::move(scenes[i - begin]);
                result_.solution = std::move(solutions[i - begin]);
                result_.error.reset();
                result_.goal_estimates.clear();
                estimate_error_of(result_, own);
                evaluate_anew(result_, own);
                visit(steps_[i], result_);
            }
            execution_.count("segments", journal.count_of("segments"));
        }
    }

    /// How many scenes and columns may be in memory at once.
    std::size_t steps_of_block(std::size_t sets) const {
        constexpr double vectors = 64.0; // of each column: a Krylov space, and more
        const Mesh& mesh = result_.scene->mesh;
        const double columns = static_cast<double>(sets) * static_cast<double>(result_.channels);
        const auto points = static_cast<double>(result_.system->transport().points());
        const auto surfels = static_cast<double>(result_.system->transport().surfels);
        const double bytes = sizeof(double) * columns * (vectors * points + 8.0 * surfels) +
                             400.0 * static_cast<double>(mesh.triangles.size());
        return static_cast<std::size_t>(
            std::clamp(0.25 * static_cast<double>(execution_.memory_left()) / bytes, 1.0, 16.0));
    }

    [[noreturn]] void refuse(const std::string& why) const {
        const std::string name = saved_.file.empty() ? "the transport" : saved_.file.string();
        throw InputError(name + ": " + why);
    }

    /// The surface as it was when the transport was saved.
    void restore_surface() {
        Mesh& mesh = result_.scene->mesh;
        const auto is_none = [&](Index t) { return t >= mesh.triangles.size(); };
        bool possible = std::none_of(saved_.turned_over.begin(), saved_.turned_over.end(), is_none);
        if (possible && !saved_.turned_over.empty()) {
            for (const Index t : saved_.turned_over) {
                mesh.turn_over(t);
            }
            mesh.derive();
        }
        const bool is_changed = possible && settle_coplanar_faces(result_, execution_);
        if (is_changed && result_.scene->thermal && !how_.moves.empty()) {
            throw UsageError("--move: faces of " + result_.file +
                             " touch others, and what they cover, which radiates nothing, was left out of the surface: "
                             "where the object was, a hole would remain; bake the moved scene");
        }
        if (!saved_.moved.empty() || !how_.moves.empty()) {
            unmoved_ = std::make_shared<Mesh>(mesh);
        }
        for (const MovedObject& moved : saved_.moved) {
            try {
                move_again(moved, mesh);
            } catch (const InputError&) {
                possible = false;
                break;
            }
        }
        if (!possible || geometry_fingerprint(mesh) != saved_.geometry) {
            refuse("the surface of " + result_.file + " is not the one that this transport was computed for: points, " +
                   "faces, mirrors, symmetry planes and periods have to be the same; bake it again with " +
                   "--save-transport, or name a scene of the same surface, --scene FILE");
        }
        result_.turned_over = saved_.turned_over;
        result_.moved = saved_.moved;
    }

    /// Moves what is to be moved, with its sites.
    Placed move_objects() {
        Scene& scene = *result_.scene;
        Placed placed{std::make_shared<SiteSet>(*saved_.sites), 0.0, {}, unmoved_};
        if (how_.moves.empty()) {
            return placed;
        }
        before_ = std::make_shared<Mesh>(scene.mesh);
        marked_.assign(scene.mesh.triangles.size(), 0);
        for (const ObjectMove& move : how_.moves) {
            result_.moved.push_back(
                move_object(move, result_.up, result_.diagnosis.parts, result_.diagnosis.file_faces, scene));
            const MovedObject& moved = result_.moved.back();
            for (const Index t : moved.triangles) {
                marked_[t] = marked_[t] != 0 || !moved.motion.is_identity() ? 1 : 0;
            }
        }
        note_coplanar_faces(result_, execution_);
        placed.sites->points = moved_points(std::move(placed.sites->points), scene.mesh, marked_);
        return placed;
    }

    /// The sites of a file, however it was made, lie on the surface.
    void check_sites() const {
        const Mesh& mesh = result_.scene->mesh;
        const SiteSet& sites = *saved_.sites;
        const double rounding = 1e-6 * mesh.diameter();
        const double largest = std::max(mesh.diameter(), sites.spacing * (1.0 + 0x1p-10));
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const SurfacePoint& site = sites.points[i];
            if (site.face >= mesh.triangles.size() || sites.region[i] != mesh.region[site.face] ||
                !((site.position - mesh.at(site.face, site.u, site.v).position).norm() <= rounding) ||
                !(sites.radius[i] <= largest)) {
                refuse("its site number " + std::to_string(i) + " is not on the surface; bake it again with " +
                       "--save-transport");
            }
        }
    }

    LightTransport transport_of(const Discretisation& discretisation, const Execution& execution) {
        if (before_) {
            return moved_transport(discretisation, execution);
        }
        LightTransport transport = saved_.gathered;
        check_division(discretisation.points, *discretisation.surfels);
        if (saved_.form_factors) {
            transport.W = pairwise_operator(saved_.form_factors, transport.W, discretisation, execution);
        }
        return transport;
    }

    void check_division(std::span<const SurfacePoint> points, const Surfels& surfels) const {
        if (saved_.gathered.surfels != surfels.size() || saved_.gathered.points() != points.size() ||
            discretisation_fingerprint(points, surfels) != saved_.discretisation) {
            refuse("this program divides the surface otherwise than the one that saved the transport; bake it again "
                   "with --save-transport");
        }
    }

    /// Casts the rays again that may meet what has moved.
    LightTransport moved_transport(const Discretisation& discretisation, const Execution& execution) {
        execution.phase("transport");
        const auto engine = built_over(*before_, registry_.create<Visibility>(choices_.visibility));
        std::vector<SurfacePoint> points = moved_points(discretisation.points, *before_, marked_);
        std::copy(saved_.sites->points.begin(), saved_.sites->points.end(), points.begin());
        const Surfels surfels(*before_, discretisation.surfels->edge(), execution);
        check_division(points, surfels);
        result_.recast.emplace();
        LightTransport transport = recast(
            saved_.gathered, {Tracer(*before_, *engine), points, surfels},
            {Tracer(result_.scene->mesh, *choices_.engine), discretisation.points, *discretisation.surfels}, marked_,
            *choices_.directions, result_.options.rays, result_.options.seed, *result_.recast, execution);
        execution.count("rays", result_.recast->cast);
        return transport;
    }

    const Registry& registry_;
    const SavedTransport& saved_;
    const RelightOptions& how_;
    const SunPath* path_;
    std::shared_ptr<const Mesh> unmoved_; ///< as in the file; null: nothing was ever moved
    std::shared_ptr<const Mesh> before_;  ///< as in the transport; null: nothing is moved now
    std::vector<char> marked_;            ///< #T: 1 where something is
    bool turned_off_ = false;             ///< some lights
    std::vector<SunStep> steps_;
    std::size_t moving_ = 0; ///< number of the sun of the path in the scene
    BakeResult& result_;
    Choices& choices_;
    const Execution& execution_;
};

void read_scene_of(const SavedTransport& saved, const std::filesystem::path& file, const Registry& registry,
                   BakeResult& result, const SceneChange& change, const Execution& execution) {
    refuse_to_overwrite({saved.file}, result.options.outputs);
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored)) {
        throw InputError(file.string() + ": cannot be found" +
                         (file == saved.scene ? "; the transport was saved for this scene: name the file where it is "
                                                "now, --scene FILE"
                                              : " (--scene)"));
    }
    read_into(result, registry, file, execution, change);
    if (file == saved.scene && content_fingerprint(result.files) != saved.scene_content) {
        execution.note(file.string() + (result.files.size() > 1 ? ", or a file that it names," : "") +
                       " has changed since the transport was saved: materials and lights are those of now");
    }
}

BakeResult relit_file(const Registry& registry, const SavedTransport& saved, const RelightOptions& options,
                      const SunPath* path, const SunStepVisit& visit, const Execution& execution) {
    const BakeOptions complete = complete_options(options.bake, saved.options);
    return run_steps(registry, complete, execution, [&](BakeResult& result, Choices& choices, const Execution& own) {
        Relighting relighting(registry, saved, options, path, result, choices, own);
        read_scene_of(saved, options.scene.value_or(saved.scene), registry, result, relighting.change(), own);
        relighting.run(visit);
    });
}

BakeResult relit_scene(const Registry& registry, const SavedTransport& saved, Scene scene, const std::string& name,
                       const RelightOptions& options, const SunPath* path, const SunStepVisit& visit,
                       const Execution& execution) {
    const BakeOptions complete = complete_options(options.bake, saved.options);
    return run_steps(registry, complete, execution, [&](BakeResult& result, Choices& choices, const Execution& own) {
        Relighting relighting(registry, saved, options, path, result, choices, own);
        adopt_into(result, std::move(scene), name, own, relighting.change());
        relighting.run(visit);
    });
}

} // namespace

BakeOptions relight_defaults(const SavedTransport& saved) {
    BakeOptions options;
    options.solver = saved.options.solver;
    options.solve = saved.options.solve;
    options.stop = saved.options.stop;
    options.direct = saved.options.direct;
    options.shadow_rays = saved.options.shadow_rays;
    options.visibility = saved.options.visibility;
    return options;
}

BakeResult relight(const Registry& registry, const SavedTransport& saved, const RelightOptions& options,
                   const Execution& execution) {
    return relit_file(registry, saved, options, nullptr, {}, execution);
}

BakeResult relight(const Registry& registry, const SavedTransport& saved, Scene scene, const std::string& name,
                   const RelightOptions& options, const Execution& execution) {
    return relit_scene(registry, saved, std::move(scene), name, options, nullptr, {}, execution);
}

BakeResult relight_sun_path(const Registry& registry, const SavedTransport& saved, const RelightOptions& options,
                            const SunPath& path, const SunStepVisit& visit, const Execution& execution) {
    return relit_file(registry, saved, options, &path, visit, execution);
}

BakeResult relight_sun_path(const Registry& registry, const SavedTransport& saved, Scene scene, const std::string& name,
                            const RelightOptions& options, const SunPath& path, const SunStepVisit& visit,
                            const Execution& execution) {
    return relit_scene(registry, saved, std::move(scene), name, options, &path, visit, execution);
}

} // namespace difusa
