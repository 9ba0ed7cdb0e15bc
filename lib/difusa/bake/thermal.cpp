#include <difusa/bake/thermal.h>

#include <difusa/algebra/dense.h>
#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/radiosity/error_map.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace difusa {

namespace {

/// The share of the radiation that may leave a surface without surroundings: more is an opening, less a crack.
constexpr double largest_leak = 1e-3;

/// A temperature is undetermined if no more of what a body emits reaches others than this many times what the solver
/// leaves, or ten times what is lost.
constexpr double resolved = 100.0;

/// The mean share of the radiation that leaves the surface.
double sky_share(const SiteSet& sites, const LightTransport& transport, const Execution& execution) {
    if (transport.cut_off.rows() > 0) { // over mirrors, too
        const auto surfels = static_cast<Eigen::Index>(transport.surfels);
        Values share;
        transport.gather(
            Values::Zero(surfels, transport.cut_off.cols()),
            Values::Ones(static_cast<Eigen::Index>(transport.W->columns()) - surfels, transport.cut_off.cols()), share,
            execution);
        return sites.mean(share);
    }
    return sites.mean(transport.sky);
}

bool is_body(const Material& material) {
    return material.thermal && material.thermal->given == Thermal::Given::heat;
}

/// Calls `act(material, surfel, area)` for each material of each surfel.
template <class Act> void for_parts(const Scene& scene, const Surfels& surfels, const Act& act) {
    std::vector<Surfels::Piece> pieces;
    for (Index s = 0; s < surfels.size(); ++s) {
        surfels.pieces(s, pieces);
        double sum = 0.0;
        for (const Surfels::Piece& piece : pieces) {
            sum += piece.area;
        }
        for (const Surfels::Piece& piece : pieces) {
            act(scene.mesh.material[piece.triangle], s, sum > 0.0 ? surfels.area(s) * (piece.area / sum) : 0.0);
        }
    }
}

[[noreturn]] void refuse_draw(const BakeResult& result, Index material, const Vec3& at, double excess) {
    const Thermal& thermal = *result.scene->materials[material].thermal;
    const double arrives =
        thermal.emissivity * std::max(0.0, excess + excess_power(result.scene->thermal->reference, 0.0));
    throw InputError(result.file + ": more heat is drawn from the material " + result.scene->materials[material].name +
                     " than arrives: its net flux is " + text_of(thermal.value) + " W/m^2, but near (" +
                     text_of(at.x()) + ", " + text_of(at.y()) + ", " + text_of(at.z()) + ") it absorbs " +
                     text_of(arrives) + " W/m^2, even at 0 K; draw less");
}

} // namespace

ThermalValues thermal_values(const BakeResult& result, const Values& H, const std::vector<Index>& material,
                             const std::vector<Vec3>& place) {
    const auto count = static_cast<Eigen::Index>(material.size());
    const Values none_yet = Values::Zero(count, 1);
    ThermalValues values{none_yet, none_yet, none_yet, none_yet, none_yet};
    for (Eigen::Index i = 0; i < count; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const std::optional<ThermalState> state = thermal_state(*result.scene, material[k], H(i, 0));
        if (!state) {
            refuse_draw(result, material[k], place[k], H(i, 0));
        }
        values.temperature(i, 0) = state->temperature;
        values.net_flux(i, 0) = state->net_flux;
        values.radiosity(i, 0) = state->radiosity;
        values.irradiation(i, 0) = state->irradiation;
        values.emissivity(i, 0) = state->emissivity;
    }
    return values;
}

namespace {

ThermalValues values_at_vertices(const BakeResult& result) {
    std::vector<Index> material;
    std::vector<Vec3> place;
    for (const SurfacePoint& vertex : result.mesh.vertices) {
        material.push_back(result.scene->mesh.material[vertex.face]);
        place.push_back(vertex.position);
    }
    return thermal_values(result, result.output.H, material, place);
}

ThermalValues values_at_centres(const BakeResult& result) {
    std::vector<Index> material;
    std::vector<Vec3> place;
    for (std::size_t f = 0; f < result.mesh.triangles.size(); ++f) {
        material.push_back(result.scene->mesh.material[result.mesh.face[f]]);
        place.push_back(result.mesh.vertices[result.mesh.triangles[f][0]].position);
    }
    return thermal_values(result, result.centres->H, material, place);
}

/// Sums over the surfels.
void add_surfaces(BakeResult& result, ThermalResult& thermal, const Execution& execution) {
    const Scene& scene = *result.scene;
    const Surfels& surfels = *result.system->discretisation().surfels;
    const Values H = sum_of_parts(surfel_irradiance(result.solution, execution), 1);
    std::vector<ThermalSurface> all(scene.materials.size());
    for (ThermalSurface& surface : all) {
        surface.least_temperature = std::numeric_limits<double>::infinity();
    }
    std::vector<Surfels::Piece> scratch;
    for_parts(scene, surfels, [&](Index m, Index s, double area) {
        const double h = H(static_cast<Eigen::Index>(s), 0);
        const std::optional<ThermalState> state = thermal_state(scene, m, h);
        if (!state) {
            refuse_draw(result, m, surfels.centre(s, scratch).position, h);
        }
        ThermalSurface& surface = all[m];
        surface.material = m;
        surface.area += area;
        surface.least_temperature = std::min(surface.least_temperature, state->temperature);
        surface.largest_temperature = std::max(surface.largest_temperature, state->temperature);
        surface.mean_temperature += area * state->temperature;
        surface.heat += area * state->net_flux;
        surface.radiosity += area * state->radiosity;
        surface.irradiation += area * state->irradiation;
        thermal.exchanged += 0.5 * area * std::abs(state->net_flux);
    });
    for (ThermalSurface& surface : all) {
        if (surface.material == none) {
            continue;
        }
        thermal.heat += surface.heat;
        const double area = std::max(surface.area, std::numeric_limits<double>::min());
        surface.mean_temperature =
            std::clamp(surface.mean_temperature / area, surface.least_temperature, surface.largest_temperature);
        surface.radiosity /= area;
        surface.irradiation /= area;
        thermal.surfaces.push_back(surface);
    }
}

/// The root mean square of the estimated errors of each material, over the surfels.
void add_errors(const BakeResult& result, ThermalResult& thermal, const Execution& execution) {
    const Surfels& surfels = *result.system->discretisation().surfels;
    std::vector<SurfacePoint> centres;
    std::vector<Surfels::Piece> scratch;
    for (Index s = 0; s < surfels.size(); ++s) {
        centres.push_back(surfels.centre(s, scratch));
    }
    const ErrorMap map(result.solution, *result.error, execution);
    ErrorsAt errors = map.at(centres, execution);
    const FieldParts& parts = result.field().parts();
    if (!parts.direct_in_basis && parts.direct->casts_penumbras()) {
        Values variance;
        DirectLight::Effort effort;
        result.field().sharp(centres, result.options.seed, "noise of surfaces", execution, effort, &variance);
        map.add_sharp(centres, variance, errors);
        execution.count("segments", effort.segments);
    }
    const Values& error = errors.error;
    std::vector<double> squares(result.scene->materials.size(), 0.0), areas(squares);
    for_parts(*result.scene, surfels, [&](Index m, Index s, double area) {
        areas[m] += area;
        squares[m] += area * std::pow(error(static_cast<Eigen::Index>(s), 0), 2);
    });
    for (ThermalSurface& surface : thermal.surfaces) {
        const double area = areas[surface.material];
        surface.error = area > 0.0 ? std::sqrt(squares[surface.material] / area) : 0.0;
    }
}

/// Bodies, and the heat that leaves them for each W/m² that black surfaces at each one's temperature would emit more
/// than at the reference; `own`: the heat that leaves them if all are at the reference.
struct Bodies {
    std::vector<Index> material;
    std::vector<double> area;
    Eigen::MatrixXd exchange;
    Eigen::VectorXd own;
};

/// The scene with bodies that emit as if black ones emitted 1 W/m² more than at the reference, each in its own set.
Bodies solve_for_bodies(const BakeResult& result, std::vector<Index> material, LightingOptions options,
                        const Execution& execution) {
    auto scene = std::make_shared<Scene>(*result.scene);
    options.sets = all_lights(*scene);
    options.keep_iterates = false;
    for (const Index m : material) {
        Material& body = scene->materials[m];
        body.emission = Rgb::Constant(body.thermal->emissivity);
        options.sets.material[m] = static_cast<Index>(options.sets.names.size());
        options.sets.names.push_back(body.name);
    }
    const Solution solution = result.system->solve(scene, options, execution);
    const Values H = surfel_irradiance(solution, execution);
    const auto count = static_cast<Eigen::Index>(material.size());
    std::vector<Eigen::Index> number(scene->materials.size(), -1);
    for (Eigen::Index k = 0; k < count; ++k) {
        number[material[static_cast<std::size_t>(k)]] = k;
    }
    Bodies bodies{std::move(material), {}, Eigen::MatrixXd::Zero(count, count), Eigen::VectorXd::Zero(count)};
    bodies.area.resize(bodies.material.size(), 0.0);
    for_parts(*scene, *result.system->discretisation().surfels, [&](Index m, Index s, double area) {
        const Eigen::Index k = number[m];
        if (k >= 0) {
            const double absorbing = area * scene->materials[m].thermal->emissivity;
            bodies.area[static_cast<std::size_t>(k)] += area;
            bodies.own[k] -= absorbing * H(static_cast<Eigen::Index>(s), 0);
            bodies.exchange.row(k) -= absorbing * H.row(static_cast<Eigen::Index>(s)).tail(count);
            bodies.exchange(k, k) += absorbing;
        }
    });
    return bodies;
}

} // namespace

void make_thermal(BakeResult& result, const Execution& execution) {
    const BakeOptions& options = result.options;
    const auto refuse = [&](const std::string& option, const std::string& why) {
        throw UsageError(option + ": " + result.file + " is a thermal scene, " + why);
    };
    if (options.sky || !options.suns.empty() || !options.point_lights.empty()) {
        refuse("--sky, --sun, --point-light",
               "which has no lights: say how warm its \"surroundings\" are in the scene file");
    }
    if (options.light_groups) {
        refuse("--light-groups (and --gradients and --operator-table of relight)",
               "whose temperatures are not sums over its surfaces");
    }
    if (options.units == "photometric") {
        refuse("--units photometric", "whose radiation is infrared");
    }
    if (!options.grids.empty() || !options.goals.empty() || options.sensor != "planar" || options.sensor_rays > 0) {
        refuse("--grid, --goal, --sensor, --sensor-rays",
               "of which the surface alone is evaluated: name places on it, --at");
    }
    if (result.requested.reflectance) {
        refuse("--reflectance", "whose materials have emissivities: give them in the scene file");
    }
    if (options.keep_iterates) {
        refuse("--convergence", "whose temperatures make sense only once it is solved");
    }
    try {
        settle_thermal(*result.scene);
    } catch (const InputError& error) {
        throw InputError(result.file + ": " + error.what());
    }
    result.channels = 1;
    result.photometric = false;
    if (result.scene->thermal->surroundings) {
        return;
    }
    execution.note("no surroundings are given: the surface has to be closed; what little is lost counts as exchanged "
                   "with " +
                   text_of(result.scene->thermal->reference) + " K, the mean of the fixed temperatures");
}

void check_places(const BakeResult& result) {
    if (result.scene->thermal && !result.sensors.empty()) {
        throw UsageError("--at: " + result.file +
                         " is a thermal scene, of which the surface alone is evaluated: omit the normals of places off "
                         "the surface, or move them to it, --snap");
    }
}

void check_surroundings(const BakeResult& result, const SiteSet& sites, const LightTransport& transport,
                        const Execution& execution) {
    const double sky = sky_share(sites, transport, execution);
    const auto percent = [](double share) { return text_of(std::round(1e5 * share) / 1e3) + " %"; };
    if (result.scene->thermal->surroundings) {
        if (result.mean_back > largest_leak) {
            execution.note(percent(result.mean_back) +
                           " of the radiation ends on the backs of faces, which count as black surfaces as warm as "
                           "the surroundings; make sheets double-sided, and turn over what is inside out (--flip)");
        }
        return;
    }
    if (sky + result.mean_back > largest_leak) {
        throw InputError(result.file + ": " + percent(sky) + " of the radiation leaves the surface, and " +
                         percent(result.mean_back) +
                         " ends on the backs of faces: say how warm the surroundings are, \"surroundings\": "
                         "{\"temperature\": 293.15}, or close the surface, make sheets double-sided, and turn over "
                         "what is inside out (--flip)");
    }
    if (sky + result.mean_back > 0.0) {
        execution.note(percent(sky + result.mean_back) + " of the radiation is lost through cracks and on backs");
    }
}

Values surfel_irradiance(const Solution& solution, const Execution& execution) {
    const FieldParts& parts = solution.field->parts();
    const Discretisation& discretisation = parts.system->discretisation();
    Values H;
    discretisation.averages->apply(discretisation.projection->coefficients(solution.h, execution), H, execution);
    if (!parts.direct_in_basis) {
        H += solution.light.direct;
    }
    return H;
}

void find_temperatures(BakeResult& result, const LightingOptions& options, const Execution& execution) {
    Scene& scene = *result.scene;
    if (!scene.thermal) {
        return;
    }
    const std::vector<char> used = scene.used_materials();
    std::vector<Index> found;
    for (Index m = 0; m < used.size(); ++m) {
        if (used[m] != 0 && is_body(scene.materials[m])) {
            found.push_back(m);
        }
    }
    if (found.empty()) {
        return;
    }
    execution.phase("find temperatures");
    SubordinateProgress unreported(execution.progress);
    const Bodies bodies = solve_for_bodies(result, std::move(found), options, execution.with(&unreported, nullptr));
    Eigen::VectorXd heat = -bodies.own, size(heat.size());
    for (Eigen::Index k = 0; k < heat.size(); ++k) {
        const auto i = static_cast<std::size_t>(k);
        const Thermal& thermal = *scene.materials[bodies.material[i]].thermal;
        heat[k] += thermal.value;
        size[k] = thermal.emissivity * bodies.area[i];
    }
    // By the heat that each would emit into the open.
    const Eigen::MatrixXd exchange = size.cwiseInverse().asDiagonal() * bodies.exchange;
    const double exchanged = singular_values(exchange).sigma.minCoeff();
    // Losses count as exchange with the surroundings, which are there or not.
    const double lost = scene.thermal->surroundings
                            ? 0.0
                            : result.mean_back + sky_share(*result.system->discretisation().sites,
                                                           result.system->transport(), execution);
    if (const double least = std::max(resolved * result.options.solve.tolerance, 10.0 * lost); !(exchanged > least)) {
        throw InputError("the temperatures of materials whose \"heat\" is given are not determined: some of them "
                         "exchange heat with each other alone, or only a share of " +
                         text_of(exchanged) +
                         " of what they emit with others, which cannot be told from errors below " + text_of(least) +
                         "; fix the temperature of one, or give a smaller --tolerance");
    }
    const Eigen::VectorXd power = solve_dense(exchange, heat.cwiseQuotient(size));
    for (Eigen::Index k = 0; k < power.size(); ++k) {
        const Index m = bodies.material[static_cast<std::size_t>(k)];
        const std::optional<double> temperature = temperature_of(power[k], scene.thermal->reference);
        if (!temperature) {
            throw InputError(colder_than_possible(scene.materials[m]));
        }
        set_temperature(scene, m, *temperature);
    }
}

void evaluate_thermal(BakeResult& result, const Execution& execution) {
    if (!result.scene->thermal) {
        return;
    }
    ThermalResult thermal;
    thermal.at_vertices = values_at_vertices(result);
    if (result.centres) {
        thermal.at_centres = values_at_centres(result);
    }
    add_surfaces(result, thermal, execution);
    if (result.errors) {
        add_errors(result, thermal, execution);
    }
    const EnergyBalance& energy = result.solution.energy;
    thermal.to_surroundings = energy.escaped[0];
    thermal.to_backs = energy.blocked[0] + energy.cut_off[0];
    thermal.exchanged += 0.5 * (std::abs(thermal.to_surroundings) + std::abs(thermal.to_backs));
    result.thermal = std::move(thermal);
}

} // namespace difusa
