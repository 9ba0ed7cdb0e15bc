#include <difusa/radiosity/surfel_transport.h>

#include <difusa/core/error.h>
#include <difusa/core/random.h>
#include <difusa/transport/gathered.h>

#include <utility>
#include <vector>

namespace difusa {

namespace {

/// A random point of each surfel, with its shading normal.
std::vector<SurfacePoint> point_of_each(const RadiositySystem& system, std::uint64_t seed) {
    const Surfels& surfels = *system.discretisation().surfels;
    std::vector<SurfacePoint> points;
    points.reserve(surfels.size());
    std::vector<Surfels::Piece> pieces;
    for (Index s = 0; s < surfels.size(); ++s) {
        RandomStream stream(seed, "points of surfels", s);
        surfels.pieces(s, pieces);
        const double u = stream.uniform(), v = stream.uniform();
        points.push_back(surfels.mesh().shaded(surfels.point_on(pieces, u, v)));
    }
    return points;
}

} // namespace

SurfelTransport::SurfelTransport(const RadiositySystem& system, std::size_t rays, std::uint64_t seed,
                                 const Execution& execution)
    : transport_(gathered(system.tracer(), point_of_each(system, seed), *system.discretisation().surfels,
                          system.fresh_directions(), rays, seed, execution)) {
    if (transport_.glossy) {
        throw UsageError("transport between surfels has no glossy surfaces");
    }
}

Values SurfelTransport::respond(const Values& rho, const Values& b, Values start, double tolerance,
                                const Execution& execution) const {
    constexpr int most_iterations = 100;
    Values z = std::move(start), next;
    for (int i = 0; i < most_iterations; ++i) {
        execution.check();
        transport_.gather(b + rho.cwiseProduct(z), {}, next, execution);
        const double change = (next - z).cwiseAbs().maxCoeff();
        z.swap(next);
        if (!(change > tolerance * z.cwiseAbs().maxCoeff())) {
            break;
        }
    }
    return z;
}

} // namespace difusa
