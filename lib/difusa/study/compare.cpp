#include <difusa/study/compare.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/core/photometry.h>
#include <difusa/core/text.h>
#include <difusa/mesh/nearest_surface.h>
#include <difusa/mesh/triangle_area.h>
#include <difusa/plugin/parameters.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>

namespace difusa {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// A file with its name for messages.
struct Side {
    const FieldFile& field;
    const std::string& name;
};

const FieldArray* find(const Side& side, const std::string& name) {
    const auto place = std::find_if(side.field.point_arrays.begin(), side.field.point_arrays.end(),
                                    [&](const FieldArray& array) { return array.name == name; });
    return place == side.field.point_arrays.end() ? nullptr : &*place;
}

std::string names_of(const Side& side) {
    std::string names;
    for (const FieldArray& array : side.field.point_arrays) {
        names += (names.empty() ? "" : ", ") + array.name;
    }
    return names.empty() ? "no point arrays" : names;
}

Values numbers(const FieldArray& array) {
    const auto columns = static_cast<Eigen::Index>(std::max<std::size_t>(1, array.components.size()));
    if (const Values* values = values_of(array)) {
        return *values;
    }
    const auto widened = [&](const auto& data) {
        Values values(static_cast<Eigen::Index>(data.size()) / columns, columns);
        std::copy(data.begin(), data.end(), values.data());
        return values;
    };
    if (const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&array.data)) {
        return widened(*bytes);
    }
    return widened(std::get<std::vector<std::int32_t>>(array.data));
}

bool is_rgb(const FieldArray& array) {
    return array.components == std::vector<std::string>{"R", "G", "B"};
}

// ---- what is compared -----------------------------------------------------------------------------------------

/// Values at the vertices of both meshes.
struct Pair {
    ComparedQuantity quantity;
    Values result, reference;
};

Pair make_pair(const std::string& name, const FieldArray& like, Values result, Values reference) {
    Pair pair{{}, std::move(result), std::move(reference)};
    pair.quantity.name = name;
    pair.quantity.unit = like.unit;
    pair.quantity.components = like.components;
    pair.quantity.rgb = is_rgb(like);
    return pair;
}

/// The array of this name in both files, or nothing if `optional` and one of them lacks it.
std::optional<Pair> array_pair(const Side& result, const Side& reference, const std::string& name, bool optional) {
    const FieldArray* arrays[2];
    for (const bool second : {false, true}) {
        const Side& side = second ? reference : result;
        arrays[second ? 1 : 0] = find(side, name);
        if (arrays[second ? 1 : 0] == nullptr) {
            if (optional) {
                return std::nullopt;
            }
            std::vector<std::string> known;
            for (const FieldArray& array : side.field.point_arrays) {
                known.push_back(array.name);
            }
            const std::string near = nearest_name(name, known);
            throw InputError(side.name + ": has no point array '" + name + "'" +
                             (near.empty() ? "" : ", did you mean '" + near + "'?") + "; it has: " + names_of(side));
        }
    }
    Values a = numbers(*arrays[0]), b = numbers(*arrays[1]);
    if (a.cols() != b.cols()) {
        throw InputError("the array '" + name + "' has " + counted(static_cast<std::size_t>(a.cols()), "component") +
                         " in " + result.name + " and " + std::to_string(b.cols()) + " in " + reference.name +
                         ": compare arrays of the same kind");
    }
    return make_pair(name, *arrays[0], std::move(a), std::move(b));
}

/// The weighted mean of the radiosity's channels in a file, under any of its names, W/m².
std::optional<Values> weighted_radiosity(const Side& side) {
    if (const FieldArray* array = find(side, "radiosity_weighted"); array != nullptr && numbers(*array).cols() == 1) {
        return numbers(*array);
    }
    if (const FieldArray* array = find(side, "radiosity"); array != nullptr && is_rgb(*array)) {
        return weighted_by_luminance(numbers(*array));
    }
    if (const FieldArray* array = find(side, side.field.quality.empty() ? "quality" : side.field.quality);
        array != nullptr && numbers(*array).cols() == 1) {
        const bool candelas = array->name == "luminance" && array->unit == "cd/m^2";
        return candelas ? Values(std::numbers::pi / lumens_per_watt * numbers(*array)) : numbers(*array);
    }
    return std::nullopt;
}

std::vector<Pair> pairs_of(const Side& result, const Side& reference, const CompareOptions& options,
                           std::vector<std::string>& notes) {
    std::vector<Pair> pairs;
    if (auto total = array_pair(result, reference, "radiosity", true)) {
        pairs.push_back(std::move(*total));
    } else {
        auto a = weighted_radiosity(result), b = weighted_radiosity(reference);
        if (a && b) {
            pairs.push_back(
                make_pair("radiosity_weighted", {"radiosity_weighted", "W/m^2", {}, {}}, std::move(*a), std::move(*b)));
        } else {
            notes.push_back("the total light is not compared: " + (a ? reference.name : result.name) +
                            " has neither radiosity nor radiosity_weighted nor quality");
        }
    }
    auto temperature = array_pair(result, reference, "temperature", true);
    std::string lacks;
    for (const Side* side : {&result, &reference}) {
        for (const char* name : {"irradiance_indirect", "reflectance"}) {
            if (lacks.empty() && find(*side, name) == nullptr) {
                lacks = side->name + " has no array " + name;
            }
        }
    }
    if (temperature) { // thermal scenes, in which no light is indirect
        pairs.push_back(std::move(*temperature));
    } else if (lacks.empty()) {
        Pair indirect = *array_pair(result, reference, "irradiance_indirect", false);
        const Pair rho = *array_pair(result, reference, "reflectance", false);
        if (rho.result.cols() != indirect.result.cols()) {
            throw InputError(result.name + ": irradiance_indirect and reflectance have different numbers of " +
                             "components: write the file again with difusa");
        }
        indirect.result = indirect.result.cwiseProduct(rho.result).eval();
        indirect.reference = indirect.reference.cwiseProduct(rho.reference).eval();
        indirect.quantity.name = "radiosity_indirect";
        pairs.push_back(std::move(indirect));
    } else {
        notes.push_back("the indirect light is not compared: " + lacks + "; a .vtp baked by difusa has it");
    }
    for (const std::string& name : options.arrays) {
        const bool there =
            std::any_of(pairs.begin(), pairs.end(), [&](const Pair& p) { return p.quantity.name == name; });
        if (!there) {
            pairs.push_back(*array_pair(result, reference, name, false));
        }
    }
    if (pairs.empty()) {
        throw InputError("nothing to compare by default: name arrays that both files have (--array); " + result.name +
                         " has: " + names_of(result) + "; " + reference.name + " has: " + names_of(reference));
    }
    for (const Pair& pair : pairs) {
        for (const auto& [values, side] : {std::pair(&pair.result, &result), std::pair(&pair.reference, &reference)}) {
            for (Eigen::Index v = 0; v < values->rows(); ++v) {
                if (!values->row(v).allFinite()) {
                    throw InputError(side->name + ": " + pair.quantity.name + " is not finite at point " +
                                     std::to_string(v) + ": compare another array, or write the file again");
                }
            }
        }
    }
    return pairs;
}

// ---- where ----------------------------------------------------------------------------------------------------

/// A point of the result's surface as weights of corners, and its match.
struct Spot {
    std::array<Index, 3> corner{};
    std::array<double, 3> weight{};
    double area = 0.0;     ///< quadrature weight
    double distance = nan; ///< to the reference's surface
    bool matched = false;
    std::array<Index, 3> reference_corner{};
    std::array<double, 3> reference_weight{};
};

Vec3 at(const std::vector<Vec3>& points, const std::array<Index, 3>& corner, const std::array<double, 3>& weight) {
    return weight[0] * points[corner[0]] + weight[1] * points[corner[1]] + weight[2] * points[corner[2]];
}

Eigen::RowVectorXd at(const Values& values, const std::array<Index, 3>& corner, const std::array<double, 3>& weight) {
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(values.cols());
    for (std::size_t k = 0; k < 3; ++k) {
        if (weight[k] != 0.0) { // so that a vertex has exactly its own value
            sum += weight[k] * values.row(static_cast<Eigen::Index>(corner[k]));
        }
    }
    return sum;
}

/// The quadrature points, three per triangle, and then the vertices, as corners of their largest triangles.
struct Spots {
    std::vector<Spot> all;
    std::vector<Index> triangle; ///< #spots; none: a vertex without triangles
    std::vector<Vec3> normals;   ///< #T, zero without area
};

Spots spots_of(const FieldFile& field) {
    Spots spots;
    std::vector<double> areas;
    std::vector<Index> largest(field.points.size(), none);
    for (Index t = 0; t < field.triangles.size(); ++t) {
        const auto& corner = field.triangles[t];
        const Vec3 &a = field.points[corner[0]], &b = field.points[corner[1]], &c = field.points[corner[2]];
        const Vec3 vector = twice_vector_area(a, b, c);
        const bool has_area = !without_area(a, b, c);
        areas.push_back(has_area ? 0.5 * vector.stableNorm() : 0.0);
        spots.normals.push_back(has_area ? vector.stableNormalized() : Vec3(Vec3::Zero()));
        for (std::size_t k = 0; k < 3; ++k) {
            Spot spot;
            spot.corner = corner;
            spot.weight = {1.0 / 6.0, 1.0 / 6.0, 1.0 / 6.0};
            spot.weight[k] = 2.0 / 3.0;
            spot.area = areas.back() / 3.0;
            spots.all.push_back(spot);
            spots.triangle.push_back(t);
            Index& best = largest[corner[k]];
            if (best == none || areas[t] > areas[best]) {
                best = t;
            }
        }
    }
    for (Index v = 0; v < field.points.size(); ++v) {
        Spot spot;
        spot.corner = {v, v, v};
        spot.weight = {1.0, 0.0, 0.0};
        spots.all.push_back(spot);
        spots.triangle.push_back(largest[v]);
    }
    return spots;
}

/// Finds each spot on the reference's surface.
void match(Spots& spots, const Side& result, const Side& reference, double limit, const Execution& execution) {
    const NearestSurface surface(reference.field.points, reference.field.triangles);
    const std::vector<Vec3>& points = result.field.points;
    parallel_for(spots.all.size(), 256, execution, [&](std::size_t begin, std::size_t end, unsigned /*worker*/) {
        for (std::size_t i = begin; i < end; ++i) {
            const Index t = spots.triangle[i];
            if (t == none || spots.normals[t].isZero(0.0)) {
                continue;
            }
            Spot& spot = spots.all[i];
            const Vec3 position = at(points, spot.corner, spot.weight);
            constexpr double third = 1.0 / 3.0;
            const Vec3 middle = at(points, result.field.triangles[t], {third, third, third});
            const Vec3 toward = position + (middle - position) / 1024.0;
            const NearestSurface::Place place = surface.nearest({position, spots.normals[t], toward});
            if (place.triangle == none) {
                continue;
            }
            spot.distance = place.distance;
            spot.matched = place.distance <= limit;
            spot.reference_corner = reference.field.triangles[place.triangle];
            spot.reference_weight = place.weight;
        }
    });
}

void match_same(Spots& spots) {
    for (Spot& spot : spots.all) {
        spot.distance = 0.0;
        spot.matched = true;
        spot.reference_corner = spot.corner;
        spot.reference_weight = spot.weight;
    }
}

double area_of(const FieldFile& field) {
    double area = 0.0;
    for (const auto& [a, b, c] : field.triangles) {
        area += 0.5 * twice_vector_area(field.points[a], field.points[b], field.points[c]).stableNorm();
    }
    return area;
}

double diameter_of(const FieldFile& field) {
    Vec3 low = field.points[field.triangles[0][0]], high = low;
    for (const auto& triangle : field.triangles) {
        for (const Index p : triangle) {
            low = low.cwiseMin(field.points[p]);
            high = high.cwiseMax(field.points[p]);
        }
    }
    return (high - low).stableNorm();
}

Matching summarize(const Spots& spots, std::size_t vertices) {
    Matching matching;
    const std::size_t inside = spots.all.size() - vertices;
    for (std::size_t i = 0; i < spots.all.size(); ++i) {
        const Spot& spot = spots.all[i];
        double& sum = spot.matched                ? matching.matched_area
                      : std::isnan(spot.distance) ? matching.turned_away_area
                                                  : matching.too_far_area;
        sum += spot.area;
        if (spot.matched) {
            matching.largest_distance = std::max(matching.largest_distance, spot.distance);
        }
        if (i >= inside) {
            matching.matched.push_back(spot.matched ? 1 : 0);
            matching.distance.push_back(spot.distance);
            matching.unmatched_vertices += spot.matched ? 0 : 1;
        }
    }
    matching.area = matching.matched_area + matching.turned_away_area + matching.too_far_area;
    return matching;
}

/// Whether a quantity contains the light that a surface emits itself.
bool contains_emission(const std::string& name) {
    return name == "radiosity" || name == "radiosity_weighted" || name == "luminance" ||
           name.starts_with("radiosity_of_");
}

/// Which spots emit light, in either file; empty if no matched part of the surface does, or all of it.
std::vector<bool> emitting_spots(const Spots& spots, const Side& result, const Side& reference, Matching& matching) {
    std::vector<bool> emitting(spots.all.size(), false);
    for (const Side* side : {&result, &reference}) {
        const FieldArray* array = find(*side, "emission");
        if (array == nullptr) {
            continue;
        }
        const Values emission = numbers(*array);
        for (std::size_t i = 0; i < spots.all.size(); ++i) {
            const Spot& spot = spots.all[i];
            if (spot.matched) {
                const auto& corner = side == &result ? spot.corner : spot.reference_corner;
                const auto& weight = side == &result ? spot.weight : spot.reference_weight;
                emitting[i] = emitting[i] || (at(emission, corner, weight).array() > 0.0).any();
            }
        }
    }
    double area = 0.0;
    for (std::size_t i = 0; i < spots.all.size(); ++i) {
        area += emitting[i] ? spots.all[i].area : 0.0;
    }
    if (!(area > 0.0) || !(area < matching.matched_area * (1.0 - 1e-12))) {
        return {};
    }
    matching.emitting_area = area;
    return emitting;
}

/// Whether neither file tells emitters from what they light. In a thermal scene everything emits.
bool emission_unknown(const Side& result, const Side& reference) {
    const auto tells = [](const Side& side) {
        return find(side, "emission") != nullptr || find(side, "temperature") != nullptr;
    };
    return !tells(result) && !tells(reference);
}

/// Norms over all matched spots but those left out, and the values at the vertices.
void fill(Pair& pair, const Spots& spots, std::size_t vertices, const std::vector<bool>& left_out) {
    ComparedQuantity& quantity = pair.quantity;
    const Eigen::Index channels = pair.result.cols();
    const auto included = [&](std::size_t i) { return spots.all[i].matched && (left_out.empty() || !left_out[i]); };
    Eigen::Index rows = 0;
    for (std::size_t i = 0; i < spots.all.size(); ++i) {
        rows += included(i) ? 1 : 0;
    }
    Values f(rows, channels), g(rows, channels);
    std::vector<double> area;
    quantity.result = quantity.reference = Values::Constant(static_cast<Eigen::Index>(vertices), channels, nan);
    const std::size_t inside = spots.all.size() - vertices;
    Eigen::Index row = 0;
    for (std::size_t i = 0; i < spots.all.size(); ++i) {
        const Spot& spot = spots.all[i];
        if (!spot.matched) {
            continue;
        }
        const Eigen::RowVectorXd own = at(pair.result, spot.corner, spot.weight),
                                 other = at(pair.reference, spot.reference_corner, spot.reference_weight);
        if (i >= inside) {
            quantity.result.row(static_cast<Eigen::Index>(i - inside)) = own;
            quantity.reference.row(static_cast<Eigen::Index>(i - inside)) = other;
        }
        if (included(i)) {
            f.row(row) = own;
            g.row(row++) = other;
            area.push_back(spot.area);
        }
    }
    quantity.norms = field_norms(f, g, area, quantity.rgb);
}

std::string percent(double share) {
    return text_of(100.0 * share) + " %";
}

void require_match(const Matching& matching, const Side& result, const Side& reference, double least) {
    const double share = matching.matched_area > 0.0 ? matching.matched_area / matching.area : 0.0;
    if (share > 0.0 && share >= least) {
        return;
    }
    const std::string part = share > 0.0 ? "only " + percent(share) + " of the area of " : "no part of ";
    throw InputError(part + result.name + " lies on " + reference.name + " and faces the same way (within " +
                     text_of(matching.max_distance) +
                     "): are they of the same scene, in the same unit and position? Otherwise give a larger "
                     "--max-distance" +
                     (share > 0.0 ? ", or compare what matches with a smaller --min-match" : ""));
}

void add_notes(const Side& result, const Side& reference, Comparison& comparison) {
    const Matching& matching = comparison.matching;
    if (matching.same_mesh) {
        return;
    }
    const auto note = [&](const std::string& text) { comparison.notes.push_back(text); };
    if (matching.too_far_area > 0.0) {
        note(percent(matching.too_far_area / matching.area) + " of the result's area is farther than " +
             text_of(matching.max_distance) +
             " from the reference's surface and is excluded from the norms (--max-distance)");
    }
    if (matching.turned_away_area > 0.0) {
        note(percent(matching.turned_away_area / matching.area) +
             " of the result's area faces a direction that no triangle of the reference does, and is excluded from the "
             "norms");
    }
    if (std::abs(matching.area - matching.reference_area) > 0.01 * std::max(matching.area, matching.reference_area)) {
        note("the surfaces differ: the result's area is " + text_of(matching.area) + ", the reference's " +
             text_of(matching.reference_area) + "; parts found only in the reference are not compared");
    }
    if (reference.field.points.size() < result.field.points.size()) {
        note("the reference has fewer vertices (" + std::to_string(reference.field.points.size()) +
             ") than the result (" + std::to_string(result.field.points.size()) +
             "): detail it lacks between them counts as error; bake it with a smaller --output-spacing");
    }
}

// ---- error field ----------------------------------------------------------------------------------------------

/// |e| / max(|g|, 1 % of the mean of |g|).
double relative_error(double error, double reference, double mean) {
    const double scale = std::max(std::abs(reference), 0.01 * mean);
    return error == 0.0 ? 0.0 : scale > 0.0 ? std::abs(error) / scale : nan;
}

/// Signed, absolute and relative error of one column.
struct ErrorColumns {
    Values error, absolute, relative;
};

ErrorColumns errors_of(const Values& f, const Values& g, const std::vector<double>& mean) {
    ErrorColumns e{f - g, (f - g).cwiseAbs(), Values(f.rows(), f.cols())};
    for (Eigen::Index v = 0; v < f.rows(); ++v) {
        for (Eigen::Index c = 0; c < f.cols(); ++c) {
            e.relative(v, c) = relative_error(e.error(v, c), g(v, c), mean[static_cast<std::size_t>(c)]);
        }
    }
    return e;
}

} // namespace

Comparison compare(const FieldFile& result, const std::string& result_name, const FieldFile& reference,
                   const std::string& reference_name, const CompareOptions& options, const Execution& execution) {
    const Side a{result, result_name}, b{reference, reference_name};
    for (const Side& side : {a, b}) {
        if (side.field.triangles.empty()) {
            throw InputError(side.name + ": has " + counted(side.field.points.size(), "point") +
                             " and no triangles: norms need a surface; name a baked field, not its sites");
        }
    }
    Comparison comparison;
    std::vector<Pair> pairs = pairs_of(a, b, options, comparison.notes);

    Spots spots = spots_of(result);
    const bool same = result.points == reference.points && result.triangles == reference.triangles;
    const double limit = options.max_distance > 0.0 ? options.max_distance : 0.01 * diameter_of(reference);
    if (same) {
        match_same(spots);
    } else {
        match(spots, a, b, limit, execution);
    }
    comparison.matching = summarize(spots, result.points.size());
    comparison.matching.same_mesh = same;
    comparison.matching.reference_area = area_of(reference);
    comparison.matching.max_distance = limit;
    require_match(comparison.matching, a, b, options.least_matched);
    add_notes(a, b, comparison);
    const std::vector<bool> emitting =
        options.with_emitters ? std::vector<bool>{} : emitting_spots(spots, a, b, comparison.matching);
    if (!emitting.empty()) {
        comparison.notes.push_back("emitters, " +
                                   percent(comparison.matching.emitting_area / comparison.matching.area) +
                                   " of the area, are left out of the norms of the total light (--with-emitters)");
    } else if (!options.with_emitters && emission_unknown(a, b) &&
               std::any_of(pairs.begin(), pairs.end(),
                           [](const Pair& pair) { return contains_emission(pair.quantity.name); })) {
        comparison.notes.push_back(
            "neither file has an array emission: emitters, if there are any, are included in the "
            "norms of the total light, where they hide errors; a .vtp baked by difusa has it");
    }
    for (Pair& pair : pairs) {
        if (execution.progress != nullptr) {
            execution.progress->check();
        }
        const bool total = contains_emission(pair.quantity.name);
        fill(pair, spots, result.points.size(), total ? emitting : std::vector<bool>{});
        comparison.quantities.push_back(std::move(pair.quantity));
    }
    return comparison;
}

FieldFile error_field(const Comparison& comparison, const FieldFile& result, const std::string& result_name,
                      const std::string& reference_name) {
    FieldFile field;
    field.points = result.points;
    field.normals = result.normals;
    field.triangles = result.triangles;
    for (const ComparedQuantity& quantity : comparison.quantities) {
        const auto add = [&](const ErrorColumns& e, const std::string& suffix, const std::vector<std::string>& names) {
            field.point_arrays.push_back({quantity.name + "_error" + suffix, quantity.unit, names, e.error});
            field.point_arrays.push_back(
                {quantity.name + "_error_absolute" + suffix, quantity.unit, names, e.absolute});
            field.point_arrays.push_back({quantity.name + "_error_relative" + suffix, "", names, e.relative});
        };
        std::vector<double> means;
        for (const ErrorNorms& norms : quantity.norms.channel) {
            means.push_back(norms.l1.reference);
        }
        const Values &f = quantity.result, &g = quantity.reference;
        if (f.cols() == 1) {
            add(errors_of(f, g, means), "", {});
        } else if (quantity.rgb) {
            add(errors_of(weighted_by_luminance(f), weighted_by_luminance(g), {quantity.norms.weighted->l1.reference}),
                "", {});
            add(errors_of(f, g, means), "_rgb", quantity.components);
        } else {
            const Values size = (f - g).rowwise().norm(), length = g.rowwise().norm();
            double mean = 0.0; // of the reference's magnitude, computed above
            for (const double m : means) {
                mean += m;
            }
            ErrorColumns e{size, size, Values(f.rows(), 1)};
            for (Eigen::Index v = 0; v < f.rows(); ++v) {
                e.relative(v, 0) = relative_error(size(v, 0), length(v, 0), mean);
            }
            add(e, "", {});
            add(errors_of(f, g, means), "_components", quantity.components);
        }
    }
    const auto count = static_cast<Eigen::Index>(result.points.size());
    field.point_arrays.push_back({"matched", "", {}, comparison.matching.matched});
    field.point_arrays.push_back(
        {"distance", "", {}, Values(Eigen::Map<const Eigen::VectorXd>(comparison.matching.distance.data(), count))});
    field.cell_arrays = result.cell_arrays;
    field.notes = {{"result", result_name}, {"reference", reference_name}};
    return field;
}

} // namespace difusa
