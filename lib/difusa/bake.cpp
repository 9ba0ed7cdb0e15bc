#include <difusa/bake.h>

#include <difusa/algebra/spectral_radius.h>
#include <difusa/core/memory.h>
#include <difusa/core/parallel.h>
#include <difusa/core/random.h>
#include <difusa/core/text.h>
#include <difusa/discretisation/basis.h>
#include <difusa/discretisation/element_integrals.h>
#include <difusa/discretisation/evaluate.h>
#include <difusa/discretisation/projection.h>
#include <difusa/discretisation/sampler.h>
#include <difusa/import/scene_file.h>
#include <difusa/lighting/dark_regions.h>
#include <difusa/lighting/direct_light.h>
#include <difusa/mesh/nearest_surface.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/plugin/choice.h>
#include <difusa/plugin/visibility_choice.h>
#include <difusa/radiosity/transport_operator.h>
#include <difusa/rays/direction_pool.h>
#include <difusa/rays/directions.h>
#include <difusa/rays/visibility.h>
#include <difusa/repair/texture_coordinates.h>
#include <difusa/transport/gather.h>
#include <difusa/transport/kernel.h>
#include <difusa/transport/pairwise.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

namespace difusa {

namespace {

constexpr std::size_t default_sites = 5000;
constexpr double pooled_directions = 32.0; ///< sets of directions in a DirectionPool
constexpr std::size_t lamp_samples = 64;   ///< shadow rays of a round
constexpr std::size_t most_sites = std::size_t{1} << 30U;
/// A spectral radius that is not below 1 by more than rounding counts as 1.
constexpr double contraction = 1.0 - 1e-9;

/// The choices of a bake as objects.
struct Tools {
    std::shared_ptr<Basis> basis;
    std::shared_ptr<Sampler> sampler;
    std::shared_ptr<Visibility> visibility;
    std::shared_ptr<Directions> directions;
    std::shared_ptr<Kernel> kernel; ///< null unless pairwise
    std::shared_ptr<Solver> solver;
    ProjectionChoice projection;
    bool pairwise = false;
    bool neighbour_areas = false;
};

Tools make_tools(const Registry& registry, const BakeOptions& options, BakeResult& result) {
    Tools tools;
    const auto make = [&]<class T>(std::shared_ptr<T>& tool, const std::string& choice) {
        tool = registry.create<T>(choice);
        result.plugins.emplace_back(kind_of<T>(), registry.describe(kind_of<T>(), choice));
    };
    const Choice transport =
        parse_choice("transport", options.transport,
                     {{"gather", {}},
                      {"pairwise",
                       {{"areas",
                         ParameterSpec::Type::word,
                         "integral",
                         "effective areas: integrals of the elements (T 5.3), or from the neighbours (T 5.5)",
                         0,
                         0,
                         {"integral", "neighbours"}}}}});
    tools.pairwise = transport.name == "pairwise";
    tools.neighbour_areas = tools.pairwise && transport.parameters.word("areas") == "neighbours";
    result.plugins.emplace_back("transport", transport.text());

    std::string projection;
    tools.projection = parse_projection(options.projection, projection);
    result.plugins.emplace_back("projection", projection);
    if (tools.pairwise &&
        (tools.projection.kind == ProjectionKind::least_squares || tools.projection.kind == ProjectionKind::galerkin)) {
        throw UsageError("--projection " + options.projection +
                         ": needs light at more points than the sites, which pairwise transport does not compute; use "
                         "--transport gather, or another projection");
    }
    result.options.direct = parse_choice("direct", options.direct, {{"exact", {}}, {"interpolated", {}}}).name;
    const bool sites_carry_all = tools.pairwise || result.options.direct == "interpolated";
    const std::string bounce =
        options.first_bounce.empty()
            ? (sites_carry_all ? "interpolated" : "gathered")
            : parse_choice("first-bounce", options.first_bounce, {{"gathered", {}}, {"interpolated", {}}}).name;
    if (tools.pairwise && bounce == "gathered") {
        throw UsageError("--first-bounce gathered: pairwise transport casts no rays whose hits could be lit; use "
                         "--transport gather, or --first-bounce interpolated");
    }
    if (result.options.direct == "interpolated" && bounce == "gathered") {
        throw UsageError("--first-bounce gathered: with --direct interpolated the sites carry the light of suns and "
                         "lamps; leave one of the two out");
    }
    result.options.first_bounce = bounce;

    make(tools.sampler, options.sampler);
    make(tools.basis, options.basis);
    make(tools.visibility, result.options.visibility = choose_visibility(registry, options.visibility, result.notes));
    make(tools.directions, options.directions);
    make(tools.solver, options.solver);
    if (tools.pairwise) {
        make(tools.kernel, options.kernel);
    }
    return tools;
}

bool is_unit(const Vec3& v) {
    return std::abs(v.norm() - 1.0) < 1e-6;
}

bool is_light(const Rgb& c) {
    return ((c >= 0.0) && (c < 1e300)).all(); // false for NaN
}

bool is_sound(const Sun& sun) {
    return is_unit(sun.towards) && is_light(sun.irradiance);
}

bool is_sound(const PointLight& light) {
    return light.position.allFinite() && is_unit(light.direction) && is_light(light.intensity) &&
           light.cos_outer >= -1.0 && light.cos_outer <= light.cos_inner && light.cos_inner <= 1.0;
}

void check_options(const BakeOptions& options) {
    const auto refuse = [](const std::string& option, const std::string& why) {
        throw UsageError(option + ": " + why);
    };
    if (options.spacing < 0.0 || !std::isfinite(options.spacing)) {
        refuse("--spacing", "must be a positive length");
    }
    if (options.spacing > 0.0 && options.sites > 0) {
        refuse("--sites", "give either --spacing or --sites, not both");
    }
    if (options.neighbours < 1 || options.neighbours > 1000) {
        refuse("--neighbours", "must be from 1 to 1000");
    }
    if (options.rays < 1 || options.rays > (std::size_t{1} << 24U)) {
        refuse("--rays", "must be from 1 to 16777216");
    }
    if (options.error_points && *options.error_points != 0 &&
        (*options.error_points < 16 || *options.error_points > (std::size_t{1} << 24U))) {
        refuse("--error-points", "must be 0, for no estimate, or from 16 to 16777216");
    }
    if (options.correction < 0 || options.correction > 100) {
        refuse("--correction", "must be from 0 to 100");
    }
    if (options.final_gather > (std::size_t{1} << 24U)) {
        refuse("--final-gather", "must be at most 16777216");
    }
    for (const Sun& sun : options.suns) {
        if (!is_sound(sun)) {
            refuse("--sun", "needs a direction, and an irradiance that is not negative");
        }
    }
    for (const PointLight& light : options.point_lights) {
        if (!is_sound(light)) {
            refuse("--point-light", "needs a place, and an intensity that is not negative");
        }
    }
    if (!(options.solve.tolerance > 0.0) || options.solve.tolerance >= 1.0) {
        refuse("--tolerance", "must be above 0 and below 1");
    }
    if (options.solve.max_iterations < 0) {
        refuse("--max-iterations", "must not be negative");
    }
    if (options.reflectance && !((*options.reflectance >= 0.0) && (*options.reflectance <= 1.0)).all()) {
        refuse("--reflectance", "must be from 0 to 1");
    }
    if (options.sky && !is_light(*options.sky)) {
        refuse("--sky", "must not be negative");
    }
    if (options.output_spacing < 0.0 || !std::isfinite(options.output_spacing)) {
        refuse("--output-spacing", "must be a positive length");
    }
}

/// Refuses a scene made by a program that reading a file would not have let pass.
void check_scene(const Scene& scene, const std::string& name) {
    const auto refuse = [&](const std::string& why) { throw InputError(name + ": " + why); };
    const Mesh& mesh = scene.mesh;
    if (mesh.triangles.empty() || mesh.normals.size() != mesh.triangles.size() ||
        mesh.material.size() != mesh.triangles.size()) {
        refuse("the mesh is empty, not derived (Mesh::derive), or has no material for each triangle");
    }
    for (const Index material : mesh.material) {
        if (material >= scene.materials.size()) {
            refuse("a triangle has the material " + std::to_string(material) + " of " +
                   std::to_string(scene.materials.size()));
        }
        if (is_textured(scene.materials[material]) && mesh.corner_texture.size() != mesh.triangles.size()) {
            refuse("the material " + scene.materials[material].name +
                   " has a texture, and the mesh no texture coordinates for each triangle");
        }
        if (scene.materials[material].vertex_colours && mesh.corner_reflectance.size() != mesh.triangles.size()) {
            refuse("the material " + scene.materials[material].name +
                   " is that of the vertices' colours, and the mesh has none for each triangle");
        }
    }
    if (!is_light(scene.sky)) {
        refuse("the sky's irradiance is negative or not finite");
    }
    for (const Material& material : scene.materials) {
        if (!((material.reflectance >= 0.0) && (material.reflectance <= 1.0)).all() || !is_light(material.emission)) {
            refuse("the material " + material.name +
                   " has a reflectance outside [0,1], or an emission that is negative "
                   "or not finite");
        }
        if (material.reflectance_texture &&
            !(material.reflectance_texture->brightest() * material.reflectance <= 1.0).all()) {
            refuse("the material " + material.name + " has a texture that makes its reflectance exceed 1");
        }
    }
    for (const Sun& sun : scene.suns) {
        if (!is_sound(sun)) {
            refuse("a sun has a direction that is not of unit length, or an irradiance that is negative or not finite");
        }
    }
    for (const PointLight& light : scene.point_lights) {
        if (!is_sound(light)) {
            refuse(
                "a point light has a place that is not finite, an axis that is not of unit length, an intensity that "
                "is negative or not finite, or an inner cone wider than the outer one");
        }
    }
}

/// The row without the columns that are marked.
SparseRows::Row without(const SparseRows::Row& row, const std::vector<char>& marked) {
    SparseRows::Row rest;
    for (std::size_t k = 0; k < row.column.size(); ++k) {
        if (marked[row.column[k]] == 0) {
            rest.column.push_back(row.column[k]);
            rest.value.push_back(row.value[k]);
        }
    }
    return rest;
}

/// The light of one group, or of all.
struct Part {
    LightGroup group;
    std::shared_ptr<const DirectLight> direct;
    std::shared_ptr<const FirstBounce> bounce;
    Values soft;  ///< #points by #channels, W/m²: from the sky and emitters that are no lamps
    Values sharp; ///< from suns, point lights and lamps
};

/// Runs the steps of a bake on one result, and times them.
class Bake {
  public:
    Bake(const Registry& registry, const BakeOptions& options, const Execution& execution)
        : registry_(registry), execution_(execution) {
        check_options(options);
        result_.options = options;
        result_.threads = execution.threads;
        tools_ = make_tools(registry, options, result_);
    }

    // 1. Read and diagnose; 2. scene: materials and light.
    void read(const std::filesystem::path& file) {
        start("read");
        result_.file = file.string();
        const PolygonSoup soup = read_scene(registry_, file);
        result_.notes.insert(result_.notes.end(), soup.notes.begin(), soup.notes.end());
        start("diagnose");
        DiagnosedMesh diagnosed = diagnose(soup);
        result_.diagnosis = std::move(diagnosed.diagnosis);
        if (execution_.progress != nullptr) {
            for (const std::string& what : result_.notes) {
                execution_.progress->remark(what);
            }
            for (const Finding& finding : result_.diagnosis.findings) {
                if (finding.repaired) {
                    execution_.progress->remark(finding.message());
                }
            }
        }
        result_.scene = std::make_shared<Scene>();
        Scene& scene = *result_.scene;
        scene.mesh = std::move(diagnosed.mesh);
        scene.materials = soup.materials;
        scene.suns = soup.lights.suns;
        scene.point_lights = soup.lights.points;
        scene.sky = soup.lights.sky.value_or(Rgb::Zero());
        scene.dome = soup.lights.dome;
        result_.camera = soup.camera;
        if (soup.default_reflectance && !result_.options.reflectance) {
            result_.options.reflectance = soup.default_reflectance;
        }
        const auto default_material = static_cast<Index>(soup.materials.size());
        const bool used = std::find(scene.mesh.material.begin(), scene.mesh.material.end(), default_material) !=
                          scene.mesh.material.end();
        if (used) {
            Material material;
            material.name = soup.faces_are_painted() ? "vertex colours" : "default";
            material.reflectance = result_.options.reflectance.value_or(material.reflectance);
            result_.options.reflectance = material.reflectance;
            material.vertex_colours = soup.faces_are_painted();
            scene.materials.push_back(material);
            if (!material.vertex_colours) {
                note("faces without a colour have the reflectance " + list(material.reflectance) + " (--reflectance)");
            }
        }
        light();
    }

    // 1. and 2., for a scene that is there already.
    void adopt(Scene scene, const std::string& name) {
        result_.file = name;
        result_.diagnosis.file_faces = scene.mesh.triangles.size();
        result_.diagnosis.file_points = scene.mesh.points.size();
        check_scene(scene, name);
        result_.scene = std::make_shared<Scene>(std::move(scene));
        light();
    }

    // 3. Visibility; 4. sites and basis.
    void place_sites() {
        const Mesh& mesh = result_.scene->mesh;
        start("build visibility");
        tools_.visibility->build(mesh);
        const Scene& scene = *result_.scene;
        all_ = std::make_shared<DirectLight>(scene, *tools_.visibility);
        if (result_.options.light_groups) {
            for (LightGroup& group : difusa::light_groups(scene)) {
                auto direct = std::make_shared<DirectLight>(*all_, group);
                parts_.push_back({std::move(group), std::move(direct), {}, {}, {}});
            }
        }
        if (parts_.empty()) {
            parts_.push_back({all_lights(scene), all_, {}, {}, {}});
        }
        start("look for dark surfaces");
        const std::vector<char> dark = dark_regions(scene, *all_, *tools_.visibility, result_.options.seed, execution_);
        double lit_area = 0.0;
        std::size_t lost = 0; // triangles whose light goes nowhere
        Index first_lost = none;
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            if (dark[mesh.region[t]] == 0) {
                lit_area += mesh.areas[t];
            } else if ((scene.materials[mesh.material[t]].emission > 0.0).any()) {
                first_lost = lost++ == 0 ? t : first_lost;
            }
        }
        if (lost > 0 && lit_area > 0.0) {
            note(std::to_string(lost) + " emitting triangles light nothing, the first of them of face " +
                 std::to_string(mesh.original_face[first_lost]) + " (material " +
                 scene.materials[mesh.material[first_lost]].name +
                 "): their fronts face away from every surface; turn them over, or make the material double-sided");
        }
        start("place sites");
        const Visibility* rays = tools_.sampler->needs_visibility() ? tools_.visibility.get() : nullptr;
        BakeOptions& options = result_.options;
        // A site takes about 400 bytes while it is being placed and bound.
        const auto limit = std::min(most_sites, available_memory() / 400);
        if (options.spacing == 0.0) {
            options.sites = options.sites == 0 ? default_sites : options.sites;
            if (options.sites > limit) {
                throw ResourceError(std::to_string(options.sites) + " sites are asked for, and memory is there for " +
                                    std::to_string(limit) + ": give fewer --sites");
            }
            // Sites are wanted where there is light; those of the rest will be left out.
            constexpr double most = 50.0; // times the wanted number, on dark surfaces for the most part
            const double more = lit_area > 0.0 && rays == nullptr ? std::min(most, mesh.area / lit_area) : 1.0;
            const double count = std::min(static_cast<double>(limit), more * static_cast<double>(options.sites));
            options.spacing = spacing_for_count(*tools_.sampler, mesh, rays, static_cast<std::size_t>(count),
                                                options.seed, execution_);
        }
        std::vector<SurfacePoint> points =
            tools_.sampler->sample(mesh, rays, options.spacing, limit, RandomStream(options.seed, "sites"), execution_);
        if (lit_area > 0.0) {
            const std::size_t all = points.size();
            std::erase_if(points, [&](const SurfacePoint& x) { return dark[mesh.region[x.face]] != 0; });
            if (points.empty()) {
                throw InputError(result_.file + ": the observer of the sampler " + options.sampler +
                                 " sees nothing but surface that no light reaches: turn it, or use --sampler "
                                 "poisson-disk");
            }
            if (points.size() < all) {
                save("sites",
                     text_of(100.0 * (1.0 - lit_area / mesh.area)) + " % of the surface sees nothing that sends light",
                     "sites", static_cast<double>(all - points.size()));
            }
        }
        result_.sites = std::make_shared<SiteSet>(
            make_site_set(mesh, std::move(points), options.spacing, options.neighbours, execution_));
        if (lit_area > 0.0) {
            result_.sites->dark = dark;
        }
        dark_area_ = lit_area > 0.0 ? mesh.area - lit_area : 0.0;
        if (result_.options.output_spacing == 0.0) {
            result_.options.output_spacing = options.spacing;
        }
        start("bind basis");
        tools_.basis->bind(mesh, *result_.sites);
        look_for_bright_surfaces();
    }

    void look_for_bright_surfaces() {
        const BakeOptions& options = result_.options;
        const bool judged = options.final_gather > 0 || options.error_points.value_or(1) != 0;
        if (!all_->any() || options.direct == "interpolated" || (options.first_bounce != "gathered" && !judged)) {
            return; // nobody asks
        }
        start("look for bright surfaces");
        const double sets = parts_.front().direct == all_ ? 1.0 : 1.0 + static_cast<double>(parts_.size());
        require_memory(sets * FirstBounce::memory(result_.scene->mesh, options.spacing),
                       "the light of small pieces of the surface", "give a larger --spacing");
        const auto of = [&](const std::shared_ptr<const DirectLight>& direct) {
            return std::make_shared<FirstBounce>(*result_.scene, *tools_.visibility, direct, options.spacing,
                                                 options.seed, execution_);
        };
        all_bounce_ = of(all_);
        result_.segments += all_bounce_->segments();
        for (Part& part : parts_) {
            part.bounce = part.direct == all_ ? all_bounce_ : of(part.direct);
            result_.segments += part.direct == all_ ? 0 : part.bounce->segments();
        }
    }

    /// What the transport will take: memory from the overlap of the elements at random surface points.
    void estimate() {
        BakeEstimate& estimate = result_.estimate;
        const Mesh& mesh = result_.scene->mesh;
        RandomStream stream(result_.options.seed, "estimate");
        BasisRow row;
        std::size_t elements = 0;
        constexpr std::size_t probes = 512;
        for (std::size_t i = 0; i < probes; ++i) {
            const SurfacePoint& site = result_.sites->points[stream.below(result_.sites->size())];
            const double u = stream.uniform();
            tools_.basis->evaluate(mesh.at(site.face, u, (1.0 - u) * stream.uniform()), row);
            elements += row.element.size();
        }
        estimate.elements_per_ray = static_cast<double>(elements) / static_cast<double>(probes);
        const std::size_t sites = result_.sites->size();
        const std::size_t points = projection_points_of(sites);
        const auto n = static_cast<double>(sites);
        const auto rays = static_cast<double>(result_.options.rays);
        const double entry = sizeof(Index) + sizeof(double);
        estimate.rays = points * result_.options.rays;
        if (tools_.pairwise) {
            estimate.segments = sites * (sites - 1) / 2;
            // Lists of who sees whom, then the matrix.
            estimate.transport_bytes = n * n * (entry + sizeof(Index));
        } else {
            estimate.transport_bytes =
                static_cast<double>(points) * std::min(n, rays * estimate.elements_per_ray) * entry;
        }
        expected_segments_ = estimate.segments;
        for (const Part& part : parts_) {
            estimate.segments += points * part.direct->most_rays_per_point(lamp_samples);
            expected_segments_ += points * part.direct->rays_per_point(lamp_samples);
            if (result_.options.first_bounce == "gathered") {
                const std::size_t rays_each = part.direct->rays_per_point(1);
                const std::size_t places = points * (part.bounce ? part.bounce->places(result_.options.rays) : 0);
                const std::size_t more = estimate.rays * rays_each + places * (1 + rays_each);
                estimate.segments += more;
                expected_segments_ += more;
            }
        }
        // Directions are pooled; each thread holds the rays, hits and rows of one site.
        const double scratch = rays * (pooled_directions * 4.0 * sizeof(double) +
                                       execution_.threads * (sizeof(Ray) + sizeof(Hit) + sizeof(SurfacePoint) +
                                                             sizeof(BasisRow) + estimate.elements_per_ray * entry));
        require_memory(estimate.transport_bytes + scratch,
                       "transport between " + std::to_string(result_.sites->size()) + " sites",
                       tools_.pairwise ? "give a larger --spacing, or use --transport gather"
                                       : "give a larger --spacing, or fewer --rays");
    }

    /// Casts the rays of a few sites to see how long all rays and segments would take.
    void time_transport() {
        start("time a sample of rays");
        const SiteSet& sites = *result_.sites;
        const DirectionPool pool(*tools_.directions, std::min<std::size_t>(result_.options.rays, 1024),
                                 result_.options.seed);
        const std::size_t sample = std::min<std::size_t>(sites.size(), 64);
        std::vector<Ray> rays(pool.count());
        std::vector<Hit> hits(pool.count());
        const auto begin = std::chrono::steady_clock::now();
        for (std::size_t i = 0; i < sample; ++i) {
            const std::size_t j = i * sites.size() / sample;
            pool.rays(sites.points[j], j, rays);
            tools_.visibility->first_hits(rays, hits);
        }
        const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
        const double each = took.count() / static_cast<double>(sample * pool.count() * execution_.threads) * 1.25;
        BakeEstimate& estimate = result_.estimate;
        estimate.seconds = each * static_cast<double>(estimate.rays + expected_segments_);
        const auto gathered_twice = [&](std::size_t points, std::size_t half) {
            const std::size_t lights = all_->rays_per_point(1);
            const std::size_t places = all_bounce_ ? all_bounce_->places(half) : 0;
            estimate.further_rays += 2 * points * half;
            estimate.further_seconds +=
                each * 2.0 * static_cast<double>(points) *
                static_cast<double>(half * (1 + lights) + places * (1 + lights) + all_->rays_per_point(lamp_samples));
        };
        gathered_twice(error_points(), std::max<std::size_t>(1, result_.options.rays / 2));
        if (result_.options.final_gather > 0) {
            const Mesh& mesh = result_.scene->mesh;
            gathered_twice(refine(mesh, result_.options.output_spacing, result_.options.crease_angle,
                                  available_memory() / 500, execution_)
                               .vertices.size(),
                           (result_.options.final_gather + 1) / 2);
        }
    }

    // 5. Transport operator: geometry only.
    void transport() {
        const BakeOptions& options = result_.options;
        const Scene& scene = *result_.scene;
        const SiteSet& sites = *result_.sites;
        start("integrate elements");
        integrals_ = element_integrals(scene, *tools_.basis, options.spacing, execution_);
        const double uncovered = integrals_.uncovered - dark_area_;
        if (uncovered > 1e-3 * scene.mesh.area) {
            note("no element of the basis lives on " + text_of(100.0 * uncovered / scene.mesh.area) +
                 " % of the surface: light is lost there; give the basis a larger width, or more sites");
        }
        if (!tools_.neighbour_areas) {
            result_.sites->area = integrals_.area;
        }
        start("project");
        points_ = projection_points(tools_.projection, scene.mesh, sites, options.seed);
        result_.projection_points = points_.size();
        projection_ =
            std::make_unique<Projection>(*tools_.basis, sites, tools_.projection, points_, integrals_.area, execution_);
        result_.condition = projection_->condition();
        check_constants();
        start("transport");
        if (tools_.pairwise) {
            transport_ = pairwise(scene, sites, integrals_, *tools_.visibility, *tools_.kernel, execution_);
            for (std::size_t j = 0; j < sites.size(); ++j) {
                transport_.L.row(j) =
                    without(transport_.L.row(j), all_->lamp_materials()); // which light the sites apart
            }
            start("sky"); // and, for the energy balance, what escapes
            gather_sky(scene, points_, *tools_.visibility, *tools_.directions, options.rays, options.seed, execution_,
                       transport_);
        } else {
            Sources sources{all_->lamp_materials(), {}, result_.channels};
            for (const Part& part : parts_) {
                if (options.first_bounce == "gathered" && all_->any()) {
                    sources.bounce.push_back(part.bounce.get());
                }
            }
            transport_ = gather(scene, points_, *tools_.basis, *tools_.visibility, *tools_.directions, options.rays,
                                options.seed, execution_, sources);
        }
        result_.lamps = all_->lamp_count();
        result_.nonzeros = transport_.S.nonzeros();
        result_.rays = transport_.rays;
        const auto count = static_cast<double>(points_.size());
        for (std::size_t j = 0; j < points_.size(); ++j) {
            result_.largest_row_sum = std::max(result_.largest_row_sum, transport_.S.row_sum(j));
            result_.mean_back += transport_.back.empty() ? 0.0 : transport_.back[j] / count;
        }
        if (result_.mean_back > 0.1) {
            note(text_of(std::round(100.0 * result_.mean_back)) +
                 " % of the light paths end on the backs of faces, which neither receive nor send light: if the "
                 "result is too dark, turn those faces over in the modelling program");
        }
    }

    // 6. Direct light; 7. solve for what suns and lamps do not light directly.
    void solve() {
        start("direct light");
        const Scene& scene = *result_.scene;
        const SiteSet& sites = *result_.sites;
        const auto n = static_cast<Eigen::Index>(sites.size());
        DirectLight::Effort effort;
        Values soft = Values::Zero(static_cast<Eigen::Index>(points_.size()), result_.channels), sharp = soft;
        for (Part& part : parts_) {
            part.soft = direct_irradiance(scene, part.group, transport_, result_.channels, execution_);
            part.sharp = part.direct->irradiance(points_, result_.channels, lamp_samples, result_.options.seed, "lamps",
                                                 execution_, effort);
            soft += part.soft;
            sharp += part.sharp;
        }
        result_.segments += transport_.segments + effort.segments;
        clear_ += effort.clear;
        const bool in_basis = result_.options.direct == "interpolated";
        const double brightest = (soft + sharp).maxCoeff();
        if (!(brightest > 0.0) && !scene.has_emitters()) {
            throw InputError(result_.file + ": no light reaches the front of any face: the sky is shut out, no sun "
                                            "shines in and nothing emits. Give some faces an emission (OBJ: Ke in the "
                                            "material), open the mesh, or turn its faces towards the light");
        }
        if (!(brightest > 0.0)) {
            note("the faces that emit light no other surface: they face away from everything");
        }
        const Values rho = reflectances();
        const TransportOperator K(transport_.S, *projection_);
        start("check convergence");
        check_contraction(K, rho);
        start("solve");
        // One set of channels for each part, beside each other.
        const auto c = static_cast<Eigen::Index>(result_.channels), count = static_cast<Eigen::Index>(parts_.size());
        Values source(rho.rows(), count * c);
        for (Eigen::Index g = 0; g < count; ++g) {
            const Part& part = parts_[static_cast<std::size_t>(g)];
            Values own = in_basis ? Values(part.soft + part.sharp) : part.soft;
            if (!transport_.bounce.empty()) {
                own += transport_.bounce[static_cast<std::size_t>(g)];
            } else if (part.direct->any() && !in_basis) {
                Values reflected;
                K.apply(rho.cwiseProduct(part.sharp), reflected, execution_);
                own += reflected;
            }
            source.middleCols(g * c, c) = own;
        }
        const SolveProblem problem{&K, rho.replicate(1, count), source};
        result_.solve = tools_.solver->solve(problem, result_.options.solve, execution_);
        if (!result_.solve.converged()) {
            throw NotConverged("the solver " + result_.options.solver + " " + result_.solve.sentence() +
                               " (wanted: " + text_of(result_.options.solve.tolerance) + "). The spectral radius is " +
                               text_of(result_.spectral_radius) +
                               ": allow more --max-iterations, a larger --tolerance, or another --solver");
        }
        DIFUSA_REQUIRE(result_.solve.h.rows() == rho.rows() && result_.solve.h.cols() == count * c);
        Values residual;
        for (const double miss : relative_residual(problem, result_.solve.h, residual, execution_)) {
            if (!(miss <= 10.0 * result_.options.solve.tolerance)) {
                throw NotConverged("the solver " + result_.options.solver + " says it converged, but its residual is " +
                                   text_of(miss) + ": use another --solver");
            }
        }
        const Values all = std::move(result_.solve.h);
        Values h = Values::Zero(rho.rows(), c);
        for (Eigen::Index g = 0; g < count; ++g) {
            h += all.middleCols(g * c, c);
        }
        result_.rho = rho.topRows(n);
        const Values lit = in_basis ? h : Values(h + sharp);
        result_.irradiance = lit.topRows(n);
        result_.irradiance_direct = (soft + sharp).topRows(n);
        const std::unique_ptr<Projection> correction = evaluation();
        const auto coefficients = [&](const Values& values) {
            return correction ? limited(*tools_.basis, sites, values, correction->coefficients(values), execution_)
                              : projection_->coefficients(values);
        };
        const auto field = [&](const Part& part, Values soft_coefficients, Values smooth) {
            return std::make_shared<Field>(FieldParts{result_.scene, result_.sites, tools_.basis, tools_.visibility,
                                                      tools_.directions, part.direct, in_basis ? nullptr : part.bounce,
                                                      part.group, std::move(soft_coefficients), std::move(smooth),
                                                      lamp_samples, in_basis});
        };
        Values soft_coefficients = Values::Zero(n, c), smooth = soft_coefficients;
        for (Eigen::Index g = 0; g < count; ++g) {
            const Part& part = parts_[static_cast<std::size_t>(g)];
            const Values part_soft = coefficients(in_basis ? Values(part.soft + part.sharp) : part.soft);
            const Values part_smooth = coefficients(all.middleCols(g * c, c));
            soft_coefficients += part_soft;
            smooth += part_smooth;
            if (result_.options.light_groups) {
                result_.solution.groups.push_back(field(part, part_soft, part_smooth));
            }
        }
        result_.field = field({all_lights(scene), all_, all_bounce_, {}, {}}, soft_coefficients, smooth);
        result_.solution.field = result_.field;
        balance(rho, lit);
    }

    /// How the field's coefficients come from the values at the sites, if not as those of the equation.
    std::unique_ptr<Projection> evaluation() const {
        if (!projection_->is_identity() || result_.options.correction == 0) {
            return nullptr;
        }
        ProjectionChoice choice;
        choice.kind = ProjectionKind::corrected;
        choice.sweeps = result_.options.correction;
        return std::make_unique<Projection>(*tools_.basis, *result_.sites, choice, result_.sites->points,
                                            integrals_.area, execution_);
    }

    std::size_t error_points() const {
        return result_.options.error_points.value_or(std::clamp<std::size_t>(result_.sites->size() / 8, 128, 4096));
    }

    /// At the points of the projection. A site stands for its whole element, so where a texture makes the reflectance
    /// change within elements their means are taken, unless the basis is fitted to further points.
    Values reflectances() const {
        const Scene& scene = *result_.scene;
        if (integrals_.reflectance.rows() == static_cast<Eigen::Index>(points_.size())) {
            return integrals_.reflectance.leftCols(result_.channels);
        }
        Values rho(static_cast<Eigen::Index>(points_.size()), result_.channels);
        for (Eigen::Index j = 0; j < rho.rows(); ++j) {
            const SurfacePoint& x = points_[static_cast<std::size_t>(j)];
            rho.row(j) = scene.reflectance(x).head(result_.channels).matrix().transpose();
        }
        return rho;
    }

    // 8. Judge: how far is this from the solution?
    void judge() {
        const std::size_t points = error_points();
        result_.options.error_points = points;
        if (points == 0) {
            return;
        }
        start("estimate error");
        result_.error = estimate_error(*result_.field, points, std::max<std::size_t>(1, result_.options.rays / 2),
                                       result_.options.seed, execution_);
        bound_evaluated_ = result_.error->bound_largest;
        if (!(result_.error->largest_reflectance < 1.0)) {
            note("some surface absorbs nothing (reflectance 1): the residual is measured, but no bound of the error "
                 "follows from it");
        }
    }

    // 9. Evaluate on the refined mesh.
    void evaluate_output() {
        start("refine output");
        const Scene& scene = *result_.scene;
        const BakeOptions& options = result_.options;
        // A triangle of the output with its share of vertices and arrays takes about 500 bytes.
        result_.mesh =
            refine(scene.mesh, options.output_spacing, options.crease_angle, available_memory() / 500, execution_);
        start("evaluate");
        const std::vector<SurfacePoint>& vertices = result_.mesh.vertices;
        result_.output = values_at(vertices, "output");
        if (options.final_gather > 0 && result_.error) {
            judge_gathered(result_.output.noise);
        }
        if (result_.error) {
            result_.residual = spread_residual(*result_.error, *tools_.basis, vertices, execution_);
            // What arrives may be wrong by the largest error anywhere, of which the point reflects rho; where rho is 0,
            // nothing, even if there is no bound.
            const Eigen::ArrayXd rho = result_.output.rho.rowwise().maxCoeff().array();
            const Eigen::ArrayXd reflected = (rho > 0.0).select(rho * bound_evaluated_, 0.0);
            result_.error_bound =
                (reflected + (options.final_gather == 0 ? result_.residual : noise_).array()).matrix();
        }
        if (options.face_centres) {
            std::vector<SurfacePoint> centres;
            for (std::size_t f = 0; f < result_.mesh.triangles.size(); ++f) {
                centres.push_back(centre_of(f));
            }
            result_.centres = values_at(centres, "centres");
        }
        if (!options.at.empty()) {
            evaluate_listed();
        }
        list_savings();
    }

    /// Of a triangle of the output; with the mean of its corners' normals.
    SurfacePoint centre_of(std::size_t f) const {
        const Mesh& mesh = result_.scene->mesh;
        const Index face = result_.mesh.face[f];
        Vec3 position = Vec3::Zero(), normal = Vec3::Zero();
        for (const Index v : result_.mesh.triangles[f]) {
            position += result_.mesh.vertices[v].position / 3.0;
            normal += result_.mesh.vertices[v].normal;
        }
        const std::array<double, 3> weight =
            nearest_on_triangle(position, mesh.corner(face, 0), mesh.corner(face, 1), mesh.corner(face, 2));
        SurfacePoint centre = mesh.at(face, weight[1], weight[2]);
        centre.normal = normal.norm() > 0.5 ? Vec3(normal.normalized()) : centre.normal;
        return centre;
    }

    PointValues values_at(const std::vector<SurfacePoint>& x, const std::string& purpose) {
        PointValues values =
            result_.solution.at(x, result_.options.final_gather, result_.options.seed, purpose, execution_);
        result_.output_rays += values.rays;
        result_.output_segments += values.segments;
        clear_ += values.clear;
        return values;
    }

    /// The nearest surface points to a user's list of places.
    void evaluate_listed() {
        const Mesh& mesh = result_.scene->mesh;
        const BakeOptions& options = result_.options;
        const NearestSurface surface(mesh.points, mesh.triangles);
        std::size_t far = 0;
        for (std::size_t i = 0; i < options.at.size(); ++i) {
            const ListedPoint& wanted = options.at[i];
            const Vec3& p = wanted.position;
            // Without a normal, any: of a direction and its opposite every triangle faces one or the other.
            NearestSurface::Place place;
            for (const Vec3& n : wanted.normal ? std::vector<Vec3>{*wanted.normal}
                                               : std::vector<Vec3>{Vec3(0.36, 0.48, 0.8), Vec3(-0.36, -0.48, -0.8)}) {
                const NearestSurface::Place found = surface.nearest({p, n, p + n * options.spacing});
                if (found.triangle != none && (place.triangle == none || found.distance < place.distance)) {
                    place = found;
                }
            }
            if (place.triangle == none) {
                throw InputError("--at: no surface faces the way of the normal of place " + std::to_string(i) +
                                 " (counting from 0): turn the normal, or leave it out");
            }
            result_.listed.push_back(mesh.at(place.triangle, place.weight[1], place.weight[2]));
            result_.listed_distance.push_back(place.distance);
            far += place.distance > options.spacing ? 1 : 0;
        }
        if (far > 0) {
            note(
                std::to_string(far) + " of the " + std::to_string(options.at.size()) +
                " places of --at are farther from the surface than the spacing of the sites: what is told is the light "
                "at the nearest surface point");
        }
        result_.listed_values = values_at(result_.listed, "listed");
    }

    /// What this scene did not need.
    void list_savings() {
        const Scene& scene = *result_.scene;
        const auto points = static_cast<double>(points_.size());
        const auto rays = static_cast<double>(result_.rays);
        if (result_.channels == 1) {
            save("two of three channels", "all reflectances and lights are grey", "unknowns",
                 2.0 * points * static_cast<double>(parts_.size()));
        }
        if (!all_->any()) {
            save("direct light by shadow rays",
                 scene.has_emitters() ? "there is no sun and no point light, and the faces that emit are too large, or "
                                        "emit too unevenly, for lamps"
                                      : "there is no sun, no point light and no lamp",
                 "rays", result_.options.first_bounce == "gathered" ? rays : points);
        }
        if (all_bounce_ && result_.options.first_bounce == "gathered" &&
            all_bounce_->bright_share() > FirstBounce::broad) {
            save("samples on bright surfaces",
                 text_of(100.0 * all_bounce_->bright_share()) + " % of the surface reflects most of the direct light",
                 "rays", points * static_cast<double>(result_.options.rays));
        }
        if (!scene.has_sky()) {
            save("sky", "it is dark", "values", points);
        }
        if (scene.mesh.convex && tools_.pairwise) {
            save("shadow rays between sites", "the room is convex and empty", "rays", 0.5 * points * (points - 1.0));
        }
        if (clear_ > 0) {
            save("shadow rays to lamps where nothing can come between", "all of the lamp is seen there", "rays",
                 static_cast<double>(clear_ * lamp_samples));
        }
        if (scene.mesh.convex && all_->lamp_count() > 0 && result_.options.first_bounce == "gathered") {
            save("shadow rays of reflected lamps", "the room is convex and empty", "rays", rays);
        }
    }

    /// One reflection leaves at most rho_max of the error; the noise of the rays comes on top.
    void judge_gathered(const Values& noise) {
        ErrorEstimate& error = *result_.error;
        const double rho = error.largest_reflectance;
        // The difference of two halves may vanish by chance: the root mean square around a vertex does not.
        ErrorEstimate measured;
        measured.place = result_.mesh.vertices;
        for (Eigen::Index v = 0; v < noise.rows(); ++v) {
            measured.squared.push_back(noise.row(v).squaredNorm());
        }
        noise_ = spread_residual(measured, *tools_.basis, result_.mesh.vertices, execution_);
        error.noise = std::sqrt(noise.rowwise().squaredNorm().mean());
        error.factor *= rho;
        error.bound_rms = rho * error.bound_rms + error.noise;
        error.bound_largest = rho * error.bound_largest + noise.rowwise().norm().maxCoeff();
    }

    BakeResult finish() {
        stop();
        return std::move(result_);
    }

  private:
    void start(const char* phase) {
        stop();
        execution_.phase(phase);
        phase_ = phase;
        began_ = std::chrono::steady_clock::now();
    }

    void stop() {
        if (!phase_.empty()) {
            const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began_;
            result_.seconds.emplace_back(phase_, took.count());
            phase_.clear();
        }
    }

    void save(const std::string& what, const std::string& because, const std::string& unit, double amount) {
        result_.savings.push_back({what, because, unit, amount});
    }

    void note(const std::string& what) {
        result_.notes.push_back(what);
        if (execution_.progress != nullptr) {
            execution_.progress->remark(what);
        }
    }

    static std::string list(const Rgb& c) { return text_of(c[0]) + "," + text_of(c[1]) + "," + text_of(c[2]); }

    void light() {
        Scene& scene = *result_.scene;
        if (result_.options.sky) { // in place of the scene's, with the suns taken out of that
            std::erase_if(scene.suns, [](const Sun& sun) { return sun.of_sky; });
        }
        scene.suns.insert(scene.suns.end(), result_.options.suns.begin(), result_.options.suns.end());
        scene.point_lights.insert(scene.point_lights.end(), result_.options.point_lights.begin(),
                                  result_.options.point_lights.end());
        const bool sunny = std::any_of(scene.suns.begin(), scene.suns.end(),
                                       [](const Sun& sun) { return (sun.irradiance > 0.0).any(); }) ||
                           std::any_of(scene.point_lights.begin(), scene.point_lights.end(),
                                       [](const PointLight& light) { return (light.intensity > 0.0).any(); });
        if (result_.options.sky) { // in place of the scene's
            scene.sky = *result_.options.sky;
            scene.dome = nullptr;
        } else if (!scene.has_emitters() && !sunny && !scene.has_sky()) {
            scene.sky = Rgb::Ones();
            note("nothing emits light: a uniform sky of irradiance 1 W/m^2 is assumed (--sky)");
        }
        result_.options.sky = scene.sky;
        if (!scene.has_sky() && !scene.has_emitters() && !sunny) {
            throw InputError(result_.file + ": the scene has no light: give it a sky (--sky 1), a sun (--sun 0,0,1,1), "
                                            "or some faces an emission (OBJ: Ke in the material)");
        }
        result_.channels = scene.is_grey() ? 1 : 3;
    }

    /// How well a solved basis represents the function 1 between its sites, at random surface points: a basis that
    /// cannot do that will not do better on light.
    void check_constants() {
        if (projection_->is_identity()) {
            return;
        }
        const Mesh& mesh = result_.scene->mesh;
        RandomStream stream(result_.options.seed, "constants");
        std::vector<SurfacePoint> points;
        for (int i = 0; i < 4096; ++i) {
            const SurfacePoint& site = result_.sites->points[stream.below(result_.sites->size())];
            const double u = stream.uniform(), v = stream.uniform();
            points.push_back(uniform_point(mesh, site.face, u, v));
        }
        const Values ones = Values::Ones(static_cast<Eigen::Index>(points_.size()), 1);
        const Values values = evaluate(*tools_.basis, projection_->coefficients(ones), points, execution_);
        result_.constant_error = std::sqrt((values.array() - 1.0).square().mean());
        const std::string miss = text_of(100.0 * result_.constant_error) + " % (rms)";
        if (!(result_.constant_error < 0.25)) {
            throw NotConverged("the basis " + result_.options.basis + " misses a constant by " + miss +
                               " between its sites: its coefficients swing. Give it another width, or use "
                               "--basis normalized-radial or shepard");
        }
        if (result_.constant_error > 0.01) {
            note("the basis misses a constant by " + miss + " between its sites: expect errors of that size");
        }
    }

    /// Refuses an equation whose series of bounces does not converge (K diag(rho) has a spectral radius of 1 or more):
    /// a solver may still return numbers, but they mean nothing.
    void check_contraction(const TransportOperator& K, const Values& rho) {
        if (projection_->is_identity()) { // the norm of S diag(rho) bounds the radius
            const SparseRows& S = transport_.S;
            for (std::size_t j = 0; j < S.rows(); ++j) {
                Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(rho.cols());
                for (std::size_t k = 0; k < S.row(j).column.size(); ++k) {
                    sum += std::abs(S.row(j).value[k]) * rho.row(static_cast<Eigen::Index>(S.row(j).column[k]));
                }
                result_.spectral_radius = std::max(result_.spectral_radius, sum.maxCoeff());
            }
            result_.spectral_radius_is_bound = true;
        }
        if (!projection_->is_identity() || !(result_.spectral_radius < contraction)) {
            result_.spectral_radius = spectral_radius(K, rho, 40, execution_);
            result_.spectral_radius_is_bound = false;
        }
        if (result_.spectral_radius < contraction) {
            return;
        }
        std::string message =
            "the discretised light transport does not converge: its spectral radius is " +
            text_of(result_.spectral_radius) + " (must be below 1; largest row sum of the transport " +
            text_of(result_.largest_row_sum) + ", largest reflectance " + text_of(rho.maxCoeff()) + "). ";
        message += !projection_->is_identity() ? "The basis is not a partition of unity: use --basis "
                                                 "normalized-radial or shepard, or give this one a smaller width"
                   : tools_.pairwise
                       ? "Pairs of sites overestimate what near surfaces exchange: use --transport gather, "
                         "or pairwise:areas=integral with --kernel disc, or a reflectance below 1"
                   : result_.largest_row_sum > 1.0 + 1e-9
                       ? "The basis is not a partition of unity: use --basis normalized-radial or shepard, or give "
                         "this one a smaller width"
                       : "A closed scene that absorbs nothing has no steady state: give some surface a reflectance "
                         "below 1";
        throw NotConverged(message);
    }

    /// rho and H: at the points of the projection.
    void balance(const Values& rho, const Values& H) {
        const Scene& scene = *result_.scene;
        const auto n = static_cast<Eigen::Index>(result_.sites->size());
        Values E(static_cast<Eigen::Index>(scene.materials.size()), result_.channels);
        for (std::size_t m = 0; m < scene.materials.size(); ++m) {
            E.row(static_cast<Eigen::Index>(m)) =
                scene.materials[m].emission.head(result_.channels).matrix().transpose();
        }
        integrals_.share.multiply(E, result_.emission, execution_);
        if (integrals_.uneven[0].rows() > 0) {
            const Values ones = Values::Ones(static_cast<Eigen::Index>(scene.materials.size()), 1);
            Values column;
            for (int c = 0; c < result_.channels; ++c) {
                integrals_.uneven[static_cast<std::size_t>(c)].multiply(ones, column, execution_);
                result_.emission.col(c) += column;
            }
        }
        // A site stands for its whole element; further points for themselves.
        Values emission(rho.rows(), result_.channels), sun;
        emission.topRows(n) = result_.emission;
        for (Eigen::Index j = rho.rows() == n ? n : 0; j < rho.rows(); ++j) {
            emission.row(j) =
                scene.emission(points_[static_cast<std::size_t>(j)]).head(result_.channels).matrix().transpose();
        }
        if (!scene.suns.empty() || !scene.point_lights.empty()) {
            sun.resize(rho.rows(), result_.channels);
            parallel_for(points_.size(), 64, execution_, [&](std::size_t begin, std::size_t end, unsigned) {
                DirectLight::Worker worker;
                for (std::size_t j = begin; j < end; ++j) {
                    sun.row(static_cast<Eigen::Index>(j)) =
                        all_->from_outside(points_[j], worker).head(result_.channels).matrix().transpose();
                }
            });
        }
        result_.energy =
            energy_balance(scene, transport_, projection_->quadrature(integrals_.area), rho, H, emission, sun);
        if (result_.energy.imbalance && result_.energy.imbalance->abs().maxCoeff() > 0.1) {
            note(text_of(std::round(100.0 * result_.energy.imbalance->abs().maxCoeff())) +
                 " % of the light is lost or invented between the sites: give a smaller --spacing, and more --rays");
        }
    }

    std::size_t projection_points_of(std::size_t sites) const {
        const bool more = tools_.projection.kind == ProjectionKind::least_squares ||
                          tools_.projection.kind == ProjectionKind::galerkin;
        return more ? sites + static_cast<std::size_t>((tools_.projection.points - 1.0) * static_cast<double>(sites))
                    : sites;
    }

    const Registry& registry_;
    Execution execution_;
    BakeResult result_;
    Tools tools_;
    ElementIntegrals integrals_;
    Transport transport_;
    std::shared_ptr<const DirectLight> all_;        ///< the sharp light of all groups
    std::shared_ptr<const FirstBounce> all_bounce_; ///< after one reflection; null without such light
    std::vector<Part> parts_;                       ///< the groups if they are to be kept apart, else one of all light
    std::size_t expected_segments_ = 0;             ///< where most penumbrae are narrow
    double dark_area_ = 0.0;                        ///< where no light comes
    std::size_t clear_ = 0;                         ///< points whose lamps nothing could hide
    std::vector<SurfacePoint> points_;              ///< of the projection: the sites first
    std::unique_ptr<Projection> projection_;
    double bound_evaluated_ = 0.0; ///< of the error of the field as its basis gives it, anywhere
    Values noise_;                 ///< #V by 1: of a gathered output, W/m²
    std::string phase_;
    std::chrono::steady_clock::time_point began_;
};

} // namespace

namespace {

/// The steps after the scene is there.
BakeResult finish(Bake& bake) {
    bake.place_sites();
    bake.estimate();
    bake.transport();
    bake.solve();
    bake.judge();
    bake.evaluate_output();
    return bake.finish();
}

} // namespace

BakeResult bake(const Registry& registry, const std::filesystem::path& file, const BakeOptions& options,
                const Execution& execution) {
    Bake bake(registry, options, execution);
    bake.read(file);
    return finish(bake);
}

BakeResult bake(const Registry& registry, Scene scene, const std::string& name, const BakeOptions& options,
                const Execution& execution) {
    Bake bake(registry, options, execution);
    bake.adopt(std::move(scene), name);
    return finish(bake);
}

BakeResult dry_run(const Registry& registry, const std::filesystem::path& file, const BakeOptions& options,
                   const Execution& execution) {
    Bake bake(registry, options, execution);
    bake.read(file);
    bake.place_sites();
    bake.estimate();
    bake.time_transport();
    BakeResult result = bake.finish();
    result.dry_run = true;
    return result;
}

} // namespace difusa
