#include <difusa/radiosity/energy.h>

#include <difusa/core/even_sequence.h>
#include <difusa/core/frame.h>
#include <difusa/core/parallel.h>
#include <difusa/core/random.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace difusa {

namespace {

/// ∫ E dA, and ∫ |E| dA.
struct EmittedPower {
    Eigen::ArrayXd net, gross;
    void add(double area, const Eigen::ArrayXd& E) {
        net += area * E;
        gross += area * E.abs();
    }
};

/// Of a triangle with a pattern or texture, as a sum over n² equal parts: of the edge midpoints of each, which is exact
/// for second-degree patterns. n is 1 without a texture, else such that there are eight parts for each pixel. If these
/// were more than `most`, it is the mean over as many low-discrepancy points: larger parts would step over pixels.
void add_unevenly(const Scene& scene, Index t, Eigen::Index channels, std::size_t most, EmittedPower& power) {
    const auto add = [&](double area, double u, double v) {
        power.add(area, scene.emission(scene.mesh.at(t, u, v)).head(channels));
    };
    const double divisions = std::max(1.0, std::ceil(2.0 * std::sqrt(2.0 * scene.pixels_of_emission(t))));
    if (!(divisions * divisions <= static_cast<double>(most))) {
        for (std::size_t k = 0; k < most; ++k) {
            const auto [u, v] = even_point<2>(k, {0.5, 0.5});
            add(scene.mesh.areas[t] / static_cast<double>(most), u + v < 1.0 ? u : 1.0 - u, u + v < 1.0 ? v : 1.0 - v);
        }
        return;
    }
    const auto n = static_cast<int>(divisions);
    const double edge = 1.0 / n, area = scene.mesh.areas[t] / (3.0 * n * n);
    for (int i = 0; i < n; ++i) {
        for (int j = 0; i + j < n; ++j) {
            const double u = edge * i, v = edge * j, half = 0.5 * edge;
            add(area, u + half, v);
            add(area, u, v + half);
            add(area, u + half, v + half);
            if (i + j < n - 1) { // the part upside down on the other side of the last of these edges
                add(area, u + half, v + half);
                add(area, u + edge, v + half);
                add(area, u + half, v + edge);
            }
        }
    }
}

/// All triangles with textures together are divided into so few parts that this takes a fraction of a second.
EmittedPower emitted_power(const Scene& scene, Eigen::Index channels, const Execution& execution) {
    constexpr std::size_t most_parts = std::size_t{1} << 20U, least_parts = 256;
    std::vector<Index> uneven;
    EmittedPower power{Eigen::ArrayXd::Zero(channels), Eigen::ArrayXd::Zero(channels)};
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        const Material& material = scene.materials[scene.mesh.material[t]];
        if (material.emits_unevenly() && (material.emission != 0.0).any()) {
            uneven.push_back(t);
        } else {
            power.add(scene.mesh.areas[t], material.emission.head(channels));
        }
    }
    const std::size_t each = std::max(least_parts, most_parts / std::max<std::size_t>(1, uneven.size()));
    std::vector<EmittedPower> powers(uneven.size(), {Eigen::ArrayXd::Zero(channels), Eigen::ArrayXd::Zero(channels)});
    parallel_for(uneven.size(), 1, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            add_unevenly(scene, uneven[i], channels, each, powers[i]);
        }
    });
    for (const EmittedPower& one : powers) {
        power.net += one.net;
        power.gross += one.gross;
    }
    return power;
}

/// Converts values at the points to means over the surfels.
Values on_surfels(const Discretisation& discretisation, const Values& at_points, const Execution& execution) {
    Values means;
    discretisation.averages->apply(discretisation.projection->coefficients(at_points, execution), means, execution);
    return means;
}

Values column(const std::vector<double>& share) {
    return Eigen::Map<const Eigen::VectorXd>(share.data(), static_cast<Eigen::Index>(share.size()));
}

/// Shares of the light that leaves the gather points, means over the surfels, #surfels by 1 or #channels.
struct LostShares {
    Values sky, back, cut_off;
    static Eigen::ArrayXd at(const Values& shares, Index s, Eigen::Index channels) {
        return shares.cols() == 1 ? Eigen::ArrayXd(Eigen::ArrayXd::Constant(channels, shares(s, 0)))
                                  : Eigen::ArrayXd(shares.row(s).transpose());
    }
};

LostShares lost_shares(const Discretisation& discretisation, const LightTransport& transport,
                       const Execution& execution) {
    if (transport.cut_off.rows() == 0) {
        return {on_surfels(discretisation, column(transport.sky), execution),
                on_surfels(discretisation, column(transport.back), execution),
                {}};
    }
    const Eigen::Index channels = transport.cut_off.cols();
    const auto surfels = static_cast<Eigen::Index>(transport.surfels);
    Values sky;
    transport.gather(Values::Zero(surfels, channels),
                     Values::Ones(static_cast<Eigen::Index>(transport.W->columns()) - surfels, channels), sky,
                     execution);
    return {on_surfels(discretisation, sky, execution),
            on_surfels(discretisation, transport.back_in_mirrors + column(transport.back).replicate(1, channels),
                       execution),
            on_surfels(discretisation, transport.cut_off, execution)};
}

/// Fills in those of surfels that emit and that no element reaches.
void add_unreached(const Tracer& tracer, std::uint64_t seed, const Discretisation& discretisation,
                   const Values& emission, LostShares& lost, const Execution& execution) {
    constexpr std::size_t rays_of_each = 64;
    const Surfels& surfels = *discretisation.surfels;
    std::vector<Index> unreached;
    for (Index s = 0; s < surfels.size(); ++s) {
        if (discretisation.averages->is_empty(s) && (emission.row(s).array() != 0.0).any()) {
            unreached.push_back(s);
        }
    }
    parallel_for(unreached.size(), 16, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        std::vector<Surfels::Piece> pieces;
        std::vector<SurfacePoint> points;
        std::vector<Ray> rays;
        std::vector<Hit> hits(rays_of_each);
        for (std::size_t i = begin; i < end; ++i) {
            const Index s = unreached[i];
            RandomStream stream(seed, "light of unreached surfels", s);
            const std::array<double, 2> place{stream.uniform(), stream.uniform()},
                way{stream.uniform(), stream.uniform()};
            surfels.pieces(s, pieces);
            spread_points(surfels, pieces, rays_of_each, place, points);
            rays.clear();
            for (std::size_t k = 0; k < rays_of_each; ++k) {
                const auto [u, v] = even_point<2>(k, way);
                const Vec3& n = tracer.mesh().normals[points[k].face];
                rays.push_back(
                    {points[k].position, cosine_direction(n, u, 2.0 * std::numbers::pi * v), points[k].face});
            }
            tracer.first_hits(rays, hits);
            const auto share = [&](const auto& is) {
                return static_cast<double>(std::count_if(hits.begin(), hits.end(), is)) / rays_of_each;
            };
            lost.sky.row(s).setConstant(share([](const Hit& hit) { return hit.face == none && !hit.cut_off; }));
            if (lost.cut_off.rows() > 0) {
                lost.cut_off.row(s).setConstant(share([](const Hit& hit) { return hit.cut_off; }));
            }
            lost.back.row(s).setConstant(share([](const Hit& hit) { return hit.face != none && !hit.front; }));
        }
    });
}

/// The mean specular reflectance of each surfel, of mirrors and gloss, #surfels by #channels; no rows if there is none.
Values specular_of(const Scene& scene, const Surfels& surfels, Eigen::Index channels) {
    const Mirrors& mirrors = scene.mesh.mirrors;
    const GlossySurfaces& glossy = scene.mesh.glossy;
    Values mean;
    if (!mirrors.any() && !glossy.any()) {
        return mean;
    }
    mean.setZero(static_cast<Eigen::Index>(surfels.size()), channels);
    std::vector<Surfels::Piece> pieces;
    for (Index s = 0; s < surfels.size(); ++s) {
        surfels.pieces(s, pieces);
        for (const Surfels::Piece& piece : pieces) {
            if (!(surfels.area(s) > 0.0)) {
                continue;
            }
            const double share = piece.area / surfels.area(s);
            if (const Index kind = mirrors.kind(piece.triangle); kind != none) {
                mean.row(s) += share * mirrors.reflectance[kind].head(channels).matrix().transpose();
            }
            if (const Index kind = glossy.kind(piece.triangle); kind != none) {
                mean.row(s) += share * glossy.kinds[kind].reflectance.head(channels).matrix().transpose();
            }
        }
    }
    return mean;
}

} // namespace

EnergyBalance energy_balance(const Scene& scene, const Tracer& tracer, std::uint64_t seed,
                             const Discretisation& discretisation, const LightTransport& transport,
                             const SurfelLight& light, const Values& irradiance, const Values& from_sky,
                             const Values& from_lights, const Execution& execution) {
    const Eigen::Index channels = irradiance.cols();
    const Eigen::ArrayXd zero = Eigen::ArrayXd::Zero(channels);
    const EmittedPower emitted = emitted_power(scene, channels, execution);
    EnergyBalance balance{emitted.net, zero, zero, zero, zero, zero, zero, zero};
    LostShares lost = lost_shares(discretisation, transport, execution);
    add_unreached(tracer, seed, discretisation, light.all_emission, lost, execution);
    const Values specular = specular_of(scene, *discretisation.surfels, channels);
    const Values H_sky = on_surfels(discretisation, from_sky, execution);
    const Values H_lights = from_lights.rows() > 0 ? on_surfels(discretisation, from_lights, execution) : Values();
    for (Index s = 0; s < discretisation.surfels->size(); ++s) {
        const double area = discretisation.surfels->area(s);
        const Eigen::ArrayXd rho = light.reflectance.row(s).transpose(), H = irradiance.row(s).transpose();
        const Eigen::ArrayXd B = light.all_emission.row(s).transpose().array() + rho * H;
        const Eigen::ArrayXd kept = specular.rows() > 0 ? Eigen::ArrayXd(1.0 - specular.row(s).transpose().array())
                                                        : Eigen::ArrayXd(1.0 - zero);
        balance.absorbed += area * (kept - rho) * H;
        balance.from_sky += area * kept * H_sky.row(s).transpose().array();
        balance.escaped += area * LostShares::at(lost.sky, s, channels) * B;
        balance.blocked += area * LostShares::at(lost.back, s, channels) * B;
        if (lost.cut_off.rows() > 0) {
            balance.cut_off += area * LostShares::at(lost.cut_off, s, channels) * B;
        }
        balance.from_lights += area * kept * light.from_outside.row(s).transpose().array();
        if (H_lights.rows() > 0) {
            balance.from_lights += area * kept * H_lights.row(s).transpose().array();
        }
    }
    const Eigen::ArrayXd in = balance.emitted + balance.from_lights + balance.from_sky;
    const Eigen::ArrayXd gross = emitted.gross + balance.from_lights + balance.from_sky;
    balance.imbalance =
        (gross > 0.0)
            .select((in - balance.absorbed - balance.escaped - balance.blocked - balance.cut_off) / gross, 0.0);
    return balance;
}

} // namespace difusa
