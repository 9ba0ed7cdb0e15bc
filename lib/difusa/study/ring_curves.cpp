#include <difusa/study/ring_curves.h>

#include <difusa/core/error.h>
#include <difusa/io/chart.h>
#include <difusa/mesh/surface_sampling.h>

#include <cmath>
#include <numbers>

namespace difusa {

namespace {

/// The first hits of rays from these origins, with the normals of the ideal surface.
std::vector<SurfacePoint> meet(const BakeResult& result, const ReferenceCase& reference, const std::vector<Ray>& rays) {
    std::vector<Hit> hits(rays.size());
    result.system->tracer().engine().first_hits(rays, hits);
    std::vector<SurfacePoint> points;
    for (const Hit& hit : hits) {
        DIFUSA_REQUIRE(hit.face != none, "a ray aimed at the ball or the disc hit neither");
        SurfacePoint x = inset(result.scene->mesh, result.scene->mesh.at(hit.face, hit.u, hit.v));
        x.normal = reference.normal(x);
        points.push_back(x);
    }
    return points;
}

} // namespace

std::vector<RingCurve> ring_curves(const BakeResult& result, const ReferenceCase& reference, int rings, int azimuths,
                                   const Execution& execution) {
    constexpr double R = 40.0, h = 20.0; // from the case
    std::vector<RingCurve> curves;
    for (const bool disc : {true, false}) {
        const std::string body = disc ? "disc" : "ball";
        std::vector<double> place;
        std::vector<Ray> rays;
        for (int i = 0; i < rings; ++i) {
            const double share = (i + 0.5) / rings;
            place.push_back(disc ? share * R * 0.999 : (share - 0.5) * std::numbers::pi);
            for (int k = 0; k < azimuths; ++k) {
                const double azimuth = 2.0 * std::numbers::pi * k / azimuths;
                const Vec3 out(std::cos(azimuth), std::sin(azimuth), 0.0);
                rays.push_back(
                    disc ? Ray{place.back() * out + Vec3(0, 0, 1), Vec3(0, 0, -1), none}
                         : Ray{Vec3(0, 0, h), std::cos(place.back()) * out + Vec3(0, 0, std::sin(place.back())), none});
            }
        }
        const std::vector<SurfacePoint> points = meet(result, reference, rays);
        const Irradiance H = result.field().evaluate(points, result.options.seed, "rings", execution);
        for (const char* const kind : {"direct", "total", "indirect"}) {
            const bool direct = kind[0] != 'i', indirect = kind[0] != 'd';
            RingCurve curve{body + ", " + kind,
                            disc ? "distance from the centre" : "latitude (rad)",
                            place,
                            std::vector<double>(place.size(), 0.0),
                            {},
                            {}};
            for (std::size_t p = 0; p < points.size(); ++p) {
                const auto row = static_cast<Eigen::Index>(p);
                const ReferenceLight exact = reference.exact->at(points[p].position, points[p].normal);
                const double B =
                    exact.rho * ((direct ? H.direct(row, 0) : 0.0) + (indirect ? H.indirect(row, 0) : 0.0));
                const std::size_t ring = p / static_cast<std::size_t>(azimuths);
                curve.mean[ring] += B / azimuths;
                if (p % static_cast<std::size_t>(azimuths) == 0) {
                    const double H_direct = exact.H_direct.value_or(0.0);
                    curve.meridian.push_back(B);
                    curve.exact.push_back(exact.rho *
                                          ((direct ? H_direct : 0.0) + (indirect ? exact.H - H_direct : 0.0)));
                }
            }
            curves.push_back(std::move(curve));
        }
    }
    return curves;
}

std::string chart_of(const RingCurve& curve, const std::string& title) {
    Chart chart;
    chart.title = title + ": " + curve.name;
    chart.x_title = curve.place_title;
    chart.y_title = "radiosity (W/m²)";
    chart.series = {{"one meridian", curve.place, curve.meridian, 1.0, false, 1, false},
                    {"mean of the ring", curve.place, curve.mean, 3.0, false, 0, false},
                    {"exact", curve.place, curve.exact, 1.5, false, -1, true}};
    return svg_of(chart);
}

} // namespace difusa
