#include <difusa/study/edge_study.h>

#include <difusa/core/text.h>
#include <difusa/mesh/nearest_surface.h>
#include <difusa/study/references/edge.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace difusa {

namespace {

constexpr std::size_t places_along = 64;

/// At this distance from the edge, on both walls.
std::vector<SurfacePoint> along_edge(const Mesh& mesh, double distance) {
    const NearestSurface surface(mesh.points, mesh.triangles);
    std::vector<SurfacePoint> points;
    for (std::size_t i = 0; i < places_along; ++i) {
        const double y = mesh.high.y() * (static_cast<double>(i) + 0.5) / static_cast<double>(places_along);
        for (const bool floor : {true, false}) {
            const Vec3 position = floor ? Vec3(distance, y, 0.0) : Vec3(0.0, y, distance);
            const auto place = surface.nearest({position, floor ? Vec3::UnitZ() : Vec3::UnitX(), position});
            points.push_back(mesh.at(place.triangle, place.weight[1], place.weight[2]));
        }
    }
    return points;
}

/// The mean irradiance of a bake at a distance from the edge.
double irradiance_at(const BakeResult& result, double distance, const Execution& execution) {
    const std::vector<SurfacePoint> points = along_edge(result.scene->mesh, distance);
    const Irradiance H = result.field().evaluate(points, result.options.seed, "edge", execution);
    return H.direct.col(0).mean() + H.indirect.col(0).mean();
}

EdgeTrial try_edge(const Registry& registry, double rho, const std::vector<double>& spacings, double from,
                   const BakeOptions& options, const MeasureOptions& how, const Execution& execution) {
    EdgeTrial trial;
    trial.rho = rho;
    trial.exponent = edge_exponent(rho);
    trial.from = from;
    trial.spacings = spacings;
    const Judge judge(edge_case(rho), how, execution);
    const auto exact = [&](double d) { return judge.reference.exact->at(Vec3(d, 0, 0), Vec3::UnitZ()).H; };
    trial.exact_slope = local_exponent(exact(from), exact(2.0 * from), exact(4.0 * from));
    const double finest = *std::min_element(spacings.begin(), spacings.end());
    BakeOptions own = options;
    for (const double spacing : spacings) {
        own.spacing = spacing;
        own.adaptive = false;
        trial.even.push_back(measure(registry, judge, own, how, execution));
        own.adaptive = true;
        trial.graded.push_back(measure(registry, judge, own, how, execution, [&](const BakeResult& result) {
            const auto baked = [&](double d) { return irradiance_at(result, d, execution); };
            if (spacing == finest) {
                trial.baked_slope = local_exponent(baked(from), baked(2.0 * from), baked(4.0 * from));
            }
        }));
    }
    return trial;
}

double error_of_bake(const Measurement& m) {
    return m.failed ? NAN : m.total.l2.relative().value_or(NAN);
}

/// NaN if a bake has failed.
double order_of(const std::vector<double>& spacings, const std::vector<Measurement>& bakes) {
    std::vector<double> errors(bakes.size());
    std::transform(bakes.begin(), bakes.end(), errors.begin(), error_of_bake);
    const bool known = std::all_of(errors.begin(), errors.end(), [](double error) { return error > 0.0; });
    return known ? convergence_order(spacings, errors) : NAN;
}

/// "–" for NaN.
std::string written(const char* format, double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), format, value);
    return std::isnan(value) ? "–" : text.data();
}

} // namespace

double local_exponent(double at_d, double at_2d, double at_4d) {
    return std::log2((at_4d - at_2d) / (at_2d - at_d));
}

std::vector<EdgeTrial> edge_study(const Registry& registry, const std::vector<double>& reflectances,
                                  const std::vector<double>& spacings, double from, const BakeOptions& options,
                                  const MeasureOptions& how, const Execution& execution,
                                  const std::function<void(const EdgeTrial&)>& tell) {
    std::vector<EdgeTrial> trials;
    for (const double rho : reflectances) {
        trials.push_back(try_edge(registry, rho, spacings, from, options, how, execution));
        tell(trials.back());
    }
    return trials;
}

std::string edge_header(const std::vector<double>& spacings) {
    std::string header = "| reflectance | exponent | between the distances: exact, baked ", line = "|---|---|---";
    for (const char* const sites : {"even", "graded"}) {
        for (const double spacing : spacings) {
            header += std::string("| ") + sites + ", " + text_of(spacing) + " ";
            line += "|---";
        }
        header += "| order ";
        line += "|---";
    }
    return header + "|\n" + line + "|\n";
}

std::string edge_row(const EdgeTrial& t) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "| %g | %.3f | %.3f, ", t.rho, t.exponent, t.exact_slope);
    std::string row = text.data() + written("%.3f", t.baked_slope) + " ";
    for (const std::vector<Measurement>* const bakes : {&t.even, &t.graded}) {
        for (const Measurement& m : *bakes) {
            row += "| " + written("%.2e", error_of_bake(m)) + " ";
        }
        row += "| " + written("%.2f", order_of(t.spacings, *bakes)) + " ";
    }
    return row + "|\n";
}

std::string edge_csv_header() {
    return "reflectance,exponent,from,exact_slope,baked_slope,graded,spacing,sites,rms_error,seconds\n";
}

std::string edge_csv_rows(const EdgeTrial& t) {
    std::string rows;
    for (const bool graded : {false, true}) {
        for (std::size_t i = 0; i < t.spacings.size(); ++i) {
            const Measurement& m = (graded ? t.graded : t.even)[i];
            for (const double value : {t.rho, t.exponent, t.from, t.exact_slope, t.baked_slope}) {
                rows += text_of(value) + ",";
            }
            rows += std::string(graded ? "1," : "0,") + text_of(t.spacings[i]) + "," + std::to_string(m.sites) + "," +
                    text_of(error_of_bake(m)) + "," + text_of(m.seconds) + "\n";
        }
    }
    return rows;
}

} // namespace difusa
