#include <difusa/radiosity/field.h>

#include <difusa/core/colour.h>
#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/discretisation/evaluate.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/radiosity/exact_correction.h>
#include <difusa/radiosity/gatherer.h>
#include <difusa/radiosity/gathering_noise.h>
#include <difusa/radiosity/system.h>
#include <difusa/rays/glance.h>
#include <difusa/scene/sky_parts.h>
#include <difusa/transport/gathered_rows.h>

#include <algorithm>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>

namespace difusa {

namespace {

constexpr std::size_t fewest_out_of_reach = 64, most_out_of_reach = 256; ///< rays from points that no element reaches
constexpr std::size_t share_out_of_reach = 8; ///< all of them together: one for as many rays of the transport

/// The rays from each of so many of these points.
std::size_t rays_out_of_reach(const FieldParts& parts, std::size_t points) {
    return std::clamp(parts.system->transport().rays / share_out_of_reach / points, fewest_out_of_reach,
                      most_out_of_reach);
}

} // namespace

void raise_to_zero(Values& H, int channels) {
    const Values sum = sum_of_parts(H, channels);
    for (Eigen::Index i = 0; i < H.rows(); ++i) {
        for (Eigen::Index c = 0; c < H.cols(); ++c) {
            H(i, c) = sum(i, c % channels) < 0.0 ? 0.0 : H(i, c);
        }
    }
}

void Field::require_on_surface(std::span<const SurfacePoint> x) const {
    const std::size_t faces = parts_.scene->mesh.triangles.size();
    if (std::any_of(x.begin(), x.end(), [&](const SurfacePoint& point) { return point.face >= faces; })) {
        throw UsageError("the light of a field is asked for at points that are on no face of its surface: in mid-air, "
                         "read_sensors measures it");
    }
}

Values Field::sharp(std::span<const SurfacePoint> x, std::uint64_t seed, std::string_view purpose,
                    const Execution& execution, DirectLight::Effort& effort, Values* variance) const {
    return parts_.direct->irradiance(x, channels(), parts_.shadow_rays, seed, purpose, execution, effort, variance);
}

Irradiance Field::evaluate_smooth(std::span<const SurfacePoint> x, const Execution& execution, bool displayed,
                                  const RowVisitor& visit) const {
    require_on_surface(x);
    Values both(parts_.smooth.rows(), 2 * parts_.smooth.cols());
    both << parts_.soft_direct, parts_.smooth;
    std::vector<SurfacePoint> inside;
    inside.reserve(x.size());
    for (const SurfacePoint& point : x) {
        inside.push_back(inset(parts_.scene->mesh, point));
    }
    const Basis& basis = *parts_.system->discretisation().basis;
    const Values h = displayed ? evaluate_display(basis, both, inside, execution, visit)
                               : difusa::evaluate(basis, both, inside, execution);
    Irradiance H;
    H.direct = h.leftCols(parts_.smooth.cols());
    H.indirect = h.rightCols(parts_.smooth.cols()) - H.direct;
    return H;
}

Irradiance Field::evaluate(std::span<const SurfacePoint> x, std::uint64_t seed, std::string_view purpose,
                           const Execution& execution, const RowVisitor& visit) const {
    Irradiance H = evaluate_smooth(x, execution, true, visit);
    if (!parts_.direct_in_basis) {
        DirectLight::Effort effort;
        H.direct += sharp(x, seed, purpose, execution, effort,
                          parts_.direct->casts_penumbras() ? &H.variance_of_sharp : nullptr);
        H.segments = effort.segments;
        H.clear = effort.clear;
    }
    return H;
}

Irradiance Field::gather_smooth(std::span<const SurfacePoint> x, std::size_t rays, std::uint64_t seed,
                                std::string_view purpose, const Execution& execution) const {
    return gather_smooth(x, nullptr, nullptr, rays, seed, purpose, execution);
}

Irradiance Field::gather_by_surfels(std::span<const SurfacePoint> x, const SurfelMeans& means,
                                    const ExactCorrection* correction, std::size_t rays, std::uint64_t seed,
                                    std::string_view purpose, const Execution& execution) const {
    DIFUSA_REQUIRE(static_cast<std::size_t>(means.smooth.rows()) == parts_.system->discretisation().surfels->size() &&
                   means.smooth.cols() == parts_.smooth.cols());
    return gather_smooth(x, &means, correction, rays, seed, purpose, execution);
}

Irradiance Field::gather_smooth(std::span<const SurfacePoint> x, const SurfelMeans* means,
                                const ExactCorrection* correction, std::size_t rays, std::uint64_t seed,
                                std::string_view purpose, const Execution& execution) const {
    // A different seed: the directions must not be those of the sites.
    const std::uint64_t own_seed = RandomStream(seed, purpose).bits();
    const DirectionPool pool(parts_.system->fresh_directions(), rays, own_seed);
    Irradiance result;
    result.direct.setZero(static_cast<Eigen::Index>(x.size()), parts_.smooth.cols());
    result.indirect.setZero(static_cast<Eigen::Index>(x.size()), parts_.smooth.cols());
    result.variance.setZero(static_cast<Eigen::Index>(x.size()), 1);
    result.rays = x.size() * pool.count();
    std::vector<std::unique_ptr<Gatherer>> workers(execution.threads);
    const std::size_t grain = std::clamp<std::size_t>(4096 / pool.count(), 1, 16);
    const SkyBins sky{SkyParts::count, SkyParts::at};
    std::optional<GatheredRows> rows; // of the same rays
    if (correction != nullptr) {
        const RadiositySystem& system = *parts_.system;
        rows.emplace(system.tracer(), x, *system.discretisation().surfels, sky, pool, grain);
    }
    parallel_for(x.size(), grain, execution, [&](std::size_t begin, std::size_t end, unsigned number) {
        if (!workers[number]) {
            workers[number] = std::make_unique<Gatherer>(parts_, means, correction != nullptr ? 8 : 16, pool, own_seed);
        }
        for (std::size_t i = begin; i < end; ++i) {
            const auto row = static_cast<Eigen::Index>(i);
            result.variance(row, 0) = workers[number]->add(x[i], i, result.direct.row(row), result.indirect.row(row));
            if (rows) {
                rows->set(i, workers[number]->around(), workers[number]->scratch());
            }
        }
        if (rows) {
            rows->close_block(begin);
        }
    });
    DirectLight::Effort effort;
    for (const auto& worker : workers) {
        if (worker) {
            effort.add(worker->light().light);
        }
    }
    result.segments = effort.segments;
    result.clear = effort.clear;
    if (correction != nullptr) {
        const Irradiance change = correction->of(rows->finish(), execution);
        result.direct += change.direct;
        result.indirect += change.indirect;
        result.variance.setZero(); // what is left is little, and unknown
    }
    return result;
}

Irradiance Field::gather(std::span<const SurfacePoint> x, std::size_t rays, std::uint64_t seed,
                         std::string_view purpose, const Execution& execution,
                         const ExactCorrection* correction) const {
    DirectLight::Effort effort;
    const Values light = sharp(x, seed, purpose, execution, effort);
    Irradiance result = gather_smooth(x, nullptr, correction, rays, seed, purpose, execution);
    result.direct += light;
    result.segments += effort.segments;
    result.clear += effort.clear;
    return result;
}

Values Field::radiosity(std::span<const SurfacePoint> x, const Values& H) const {
    Values B = sum_of_parts(H, channels());
    for (Eigen::Index i = 0; i < H.rows(); ++i) {
        const SurfacePoint& point = x[static_cast<std::size_t>(i)];
        const Eigen::ArrayXd E = parts_.scene->emission(point).head(channels());
        const Eigen::ArrayXd rho = parts_.scene->reflectance(point).head(channels());
        B.row(i) = (E + rho * B.row(i).transpose().array()).matrix().transpose();
    }
    return B;
}

void Field::gather_twice(std::span<const SurfacePoint> x, std::size_t rays, std::uint64_t seed,
                         const std::string& purpose, const Execution& execution, Irradiance& first,
                         Irradiance& second) const {
    const std::size_t half = (rays + 1) / 2;
    if (!parts_.sent) {
        first = gather(x, half, seed, purpose + ", first", execution);
        second = gather(x, half, seed, purpose + ", second", execution);
        return;
    }
    constexpr std::size_t most = 16384; // points with their rays and form factors in memory
    for (Irradiance* const both : {&first, &second}) {
        both->direct.resize(static_cast<Eigen::Index>(x.size()), parts_.smooth.cols());
        both->indirect = both->direct;
        both->variance.setZero(static_cast<Eigen::Index>(x.size()), 1);
    }
    for (std::size_t begin = 0; begin < x.size(); begin += most) {
        const std::span<const SurfacePoint> block = x.subspan(begin, std::min(most, x.size() - begin));
        const std::string name = begin == 0 ? purpose : purpose + ", from " + std::to_string(begin);
        const ExactCorrection correction(parts_, block, rays, execution);
        const auto put = [&](const Irradiance& part, Irradiance& all) {
            const auto row = static_cast<Eigen::Index>(begin);
            all.direct.middleRows(row, part.direct.rows()) = part.direct;
            all.indirect.middleRows(row, part.indirect.rows()) = part.indirect;
            all.rays += part.rays;
            all.segments += part.segments;
            all.clear += part.clear;
        };
        put(gather(block, half, seed, name + ", first", execution, &correction), first);
        put(gather(block, half, seed, name + ", second", execution, &correction), second);
    }
}

/// Gathers at x, and sets the noise in `values`.
Irradiance Field::gather_with_noise(std::span<const SurfacePoint> x, std::size_t rays, std::uint64_t seed,
                                    const std::string& purpose, const Execution& execution, PointValues& values) const {
    const Scene& scene = *parts_.scene;
    Irradiance H, other;
    gather_twice(x, rays, seed, purpose, execution, H, other);
    const Values first = H.direct + H.indirect, second = other.direct + other.indirect;
    const Values difference = sum_of_parts(Values(first - second), channels());
    const Values squares = 0.25 * difference.rowwise().squaredNorm();
    const Values all = noise_of_gathers(squares, 1, 0.25 * (H.variance + other.variance));
    values.rays_of_each = rays;
    values.noise_of_irradiance = all / std::sqrt(channels());
    values.noise = values.noise_of_irradiance;
    for (Eigen::Index i = 0; i < all.rows() && !scene.thermal; ++i) {
        const Eigen::RowVectorXd rho =
            scene.reflectance(x[static_cast<std::size_t>(i)]).head(channels()).matrix().transpose();
        const double own = difference.row(i).norm();
        // In the channels as the difference, or as all light.
        const Eigen::RowVectorXd part = own > 0.0
                                            ? Eigen::RowVectorXd(difference.row(i) / own)
                                            : Eigen::RowVectorXd::Constant(channels(), std::sqrt(1.0 / channels()));
        values.noise(i, 0) *= part.cwiseProduct(rho).norm();
    }
    H.direct = 0.5 * (H.direct + other.direct);
    H.indirect = 0.5 * (H.indirect + other.indirect);
    H.rays += other.rays;
    H.segments += other.segments;
    H.clear += other.clear;
    return H;
}

/// The points that no element reaches, though light may, as far as a glance tells. `H`: of the basis.
std::vector<std::size_t> Field::out_of_reach(std::span<const SurfacePoint> x, const Irradiance& H, std::uint64_t seed,
                                             const std::string& purpose, const Execution& execution) const {
    const Discretisation& discretisation = parts_.system->discretisation();
    const Mesh& mesh = parts_.scene->mesh;
    const bool dark = (H.indirect.array() == 0.0).all() && (H.direct.array() == 0.0).all();
    if (dark || !are_elements_everywhere(parts_)) {
        return {};
    }
    std::vector<std::uint8_t> lacks(x.size(), 0);
    const Unreported unreported(execution);
    parallel_for(x.size(), 256, unreported, [&](std::size_t begin, std::size_t end, unsigned) {
        BasisRow row;
        for (std::size_t i = begin; i < end; ++i) {
            if (!(H.indirect.row(static_cast<Eigen::Index>(i)).array() == 0.0).all() ||
                discretisation.sites->is_dark(mesh.region[x[i].face])) {
                continue;
            }
            const SurfacePoint inside = inset(mesh, x[i]);
            discretisation.basis->evaluate(inside, row);
            if (row.element.empty()) {
                RandomStream stream(seed, purpose + ", glance", i);
                lacks[i] = Glance(parts_.system->tracer(), inside, stream).light_arrives() ? 1 : 0;
            }
        }
    });
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < lacks.size(); ++i) {
        if (lacks[i] != 0) {
            found.push_back(i);
        }
    }
    return found;
}

/// The irradiance at x; sets what `values` say of gathered points.
Irradiance Field::irradiance(std::span<const SurfacePoint> x, std::size_t final_gather, std::uint64_t seed,
                             const std::string& purpose, const Execution& execution, const RowVisitor& visit,
                             PointValues& values) const {
    if (final_gather > 0) {
        values.gathered.resize(x.size());
        std::iota(values.gathered.begin(), values.gathered.end(), std::size_t{0});
        return gather_with_noise(x, final_gather, seed, purpose, execution, values);
    }
    Irradiance H = evaluate(x, seed, purpose, execution, visit);
    values.gathered = out_of_reach(x, H, seed, purpose, execution);
    if (values.gathered.empty()) {
        return H;
    }
    std::vector<SurfacePoint> points;
    for (const std::size_t i : values.gathered) {
        points.push_back(x[i]);
    }
    const Irradiance gathered = gather_with_noise(points, rays_out_of_reach(parts_, points.size()), seed,
                                                  purpose + ", out of reach", execution, values);
    for (std::size_t k = 0; k < points.size(); ++k) {
        const auto from = static_cast<Eigen::Index>(k), to = static_cast<Eigen::Index>(values.gathered[k]);
        H.direct.row(to) = gathered.direct.row(from);
        H.indirect.row(to) = gathered.indirect.row(from);
        if (H.variance_of_sharp.size() > 0) {
            H.variance_of_sharp.row(to).setZero();
        }
    }
    H.rays += gathered.rays;
    H.segments += gathered.segments;
    return H;
}

PointValues Field::at(std::span<const SurfacePoint> x, std::size_t final_gather, std::uint64_t seed,
                      const std::string& purpose, const Execution& execution, const RowVisitor& visit) const {
    require_on_surface(x);
    const Scene& scene = *parts_.scene;
    PointValues values;
    Irradiance H = irradiance(x, final_gather, seed, purpose, execution, visit, values);
    if (!scene.thermal) {
        raise_to_zero(H.direct, channels());
        raise_to_zero(H.indirect, channels());
    }
    values.rays = H.rays;
    values.segments = H.segments;
    values.clear = H.clear;
    values.variance_of_sharp = std::move(H.variance_of_sharp);
    const auto count = static_cast<Eigen::Index>(x.size());
    values.rho.resize(count, 3);
    values.E.resize(count, 3);
    for (Eigen::Index i = 0; i < count; ++i) {
        const SurfacePoint& point = x[static_cast<std::size_t>(i)];
        values.rho.row(i) = scene.reflectance(point).matrix().transpose();
        values.E.row(i) = scene.emission(point).matrix().transpose();
    }
    values.H_direct = three_channels(sum_of_parts(H.direct, channels()));
    values.H_indirect = three_channels(sum_of_parts(H.indirect, channels()));
    values.H = values.H_direct + values.H_indirect;
    // Using E and rho at the exact point keeps their edges sharp whatever the basis.
    values.B = values.E + values.rho.cwiseProduct(values.H);
    if (sets().names.size() == 1 && sets().names.front().empty()) {
        return values;
    }
    for (Index set = 0; set < sets().count(); ++set) {
        const Eigen::Index first = static_cast<Eigen::Index>(set) * channels();
        GroupValues group{sets().names[set], {}, {}};
        group.H = three_channels(H.direct.middleCols(first, channels()) + H.indirect.middleCols(first, channels()));
        group.B = values.rho.cwiseProduct(group.H);
        for (Eigen::Index i = 0; i < count; ++i) {
            if (sets().material[scene.mesh.material[x[static_cast<std::size_t>(i)].face]] == set) {
                group.B.row(i) += values.E.row(i);
            }
        }
        values.groups.push_back(std::move(group));
    }
    return values;
}

} // namespace difusa
