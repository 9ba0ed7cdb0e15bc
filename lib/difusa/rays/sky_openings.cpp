#include <difusa/rays/sky_openings.h>

#include <difusa/core/even_sequence.h>
#include <difusa/core/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace difusa {

namespace {

constexpr std::size_t most_points = 2048, rays_of_point = 64; ///< to find openings with
constexpr std::size_t finest = 128, coarsest = 8;             ///< cells along each edge of the box
constexpr double rays_in_cell = 8.0;                          ///< that escape through each cell met, on average
constexpr double most_seen = 0.5;                             ///< form factor of all cells that rays are aimed at
constexpr double nearest = 1.5;                               ///< distance of a cell over its extent
constexpr double beside = 0x1p-20; ///< of the extent of the scene: how far outside of it the box is

/// Form factor, times pi, of a direction: of a surface with a shading normal, directions below the plane of its face
/// stand for those mirrored to above it (Sight::lift).
double cosine(const Vec3& direction, const Vec3& normal, const Vec3& face_normal) {
    const double above = face_normal.dot(direction);
    if (above <= 0.0) {
        return 0.0;
    }
    const Vec3 below = direction - 2.0 * above * face_normal;
    return std::max(0.0, normal.dot(direction)) + std::max(0.0, normal.dot(below));
}

} // namespace

SkyOpenings::SkyOpenings(const Eigen::AlignedBox3d& box) : box_(box) {
    const Vec3 margin = Vec3::Constant(beside * box.diagonal().norm());
    box_.extend(Vec3(box.min() - margin)).extend(Vec3(box.max() + margin));
}

void SkyOpenings::divide(std::size_t resolution) {
    resolution_ = resolution;
    is_open_.assign(6 * resolution * resolution, 0);
}

/// The cell through which a ray leaves the box.
std::size_t SkyOpenings::exit_of(const Vec3& x, const Vec3& direction) const {
    double first = std::numeric_limits<double>::infinity();
    int axis = 0;
    for (int k = 0; k < 3; ++k) {
        if (direction[k] != 0.0) {
            const double t = ((direction[k] > 0.0 ? box_.max()[k] : box_.min()[k]) - x[k]) / direction[k];
            if (t < first) {
                first = t;
                axis = k;
            }
        }
    }
    const auto cell_along = [&](int k) {
        const double part = (x[k] + first * direction[k] - box_.min()[k]) / (box_.max()[k] - box_.min()[k]);
        const auto n = static_cast<double>(resolution_);
        return static_cast<std::size_t>(std::clamp(part * n, 0.0, n - 1.0));
    };
    const std::size_t side = 2 * static_cast<std::size_t>(axis) + (direction[axis] > 0.0 ? 1 : 0);
    return (side * resolution_ + cell_along((axis + 1) % 3)) * resolution_ + cell_along((axis + 2) % 3);
}

/// Cells in which rays were counted, and those around each on its side of the box.
void SkyOpenings::add_cells(const std::vector<std::uint32_t>& count) {
    const auto n = static_cast<std::ptrdiff_t>(resolution_);
    for (std::ptrdiff_t side = 0; side < 6; ++side) {
        for (std::ptrdiff_t i = 0; i < n; ++i) {
            for (std::ptrdiff_t j = 0; j < n; ++j) {
                if (count[static_cast<std::size_t>((side * n + i) * n + j)] == 0) {
                    continue;
                }
                for (std::ptrdiff_t u = std::max<std::ptrdiff_t>(i - 1, 0); u <= std::min(i + 1, n - 1); ++u) {
                    for (std::ptrdiff_t v = std::max<std::ptrdiff_t>(j - 1, 0); v <= std::min(j + 1, n - 1); ++v) {
                        is_open_[static_cast<std::size_t>((side * n + u) * n + v)] = 1;
                    }
                }
            }
        }
    }
    const Vec3 edges = box_.sizes() / static_cast<double>(resolution_);
    for (std::size_t cell = 0; cell < is_open_.size(); ++cell) {
        if (is_open_[cell] == 0) {
            continue;
        }
        const std::size_t side = cell / (resolution_ * resolution_);
        const auto axis = static_cast<int>(side / 2), u = (axis + 1) % 3, v = (axis + 2) % 3;
        Cell one{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), axis, edges[u] * edges[v]};
        one.centre[axis] = side % 2 != 0 ? box_.max()[axis] : box_.min()[axis];
        one.centre[u] = box_.min()[u] + (static_cast<double>(cell / resolution_ % resolution_) + 0.5) * edges[u];
        one.centre[v] = box_.min()[v] + (static_cast<double>(cell % resolution_) + 0.5) * edges[v];
        one.half_u[u] = 0.5 * edges[u];
        one.half_v[v] = 0.5 * edges[v];
        cells_.push_back(one);
    }
}

std::shared_ptr<const SkyOpenings> SkyOpenings::find(const Tracer& tracer, std::span<const SurfacePoint> points,
                                                     const Directions& directions, std::uint64_t seed,
                                                     const Execution& execution) {
    Eigen::AlignedBox3d box;
    for (const Vec3& p : tracer.mesh().points) {
        box.extend(p);
    }
    if (points.empty() || !(box.sizes().minCoeff() > 0.0)) {
        return nullptr;
    }
    std::shared_ptr<SkyOpenings> found(new SkyOpenings(box)); // NOLINT: the constructor is private
    found->divide(finest);
    const DirectionPool pool(directions, rays_of_point, RandomStream(seed, "sky openings").bits());
    const std::size_t looked_at = std::min(points.size(), most_points);
    std::vector<std::vector<std::uint32_t>> exits(looked_at); // of each point
    parallel_for(looked_at, 16, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        Hemisphere around(tracer, pool);
        for (std::size_t k = begin; k < end; ++k) {
            around.look(points[k * points.size() / looked_at], k);
            const Vec3& origin = around.rays().front().origin;
            around.for_each([](const Hit&, double) {},
                            [&](const Vec3& direction, double) {
                                exits[k].push_back(static_cast<std::uint32_t>(found->exit_of(origin, direction)));
                            });
        }
    });
    std::vector<std::uint32_t> count(6 * finest * finest, 0);
    std::size_t escaped = 0;
    for (const std::vector<std::uint32_t>& of_point : exits) {
        escaped += of_point.size();
        for (const std::uint32_t cell : of_point) {
            ++count[cell];
        }
    }
    found->rays_ = looked_at * pool.count();
    if (escaped == 0 || static_cast<double>(escaped) > most_open * static_cast<double>(found->rays_)) {
        return nullptr;
    }
    const auto is_sparse = [&] {
        const auto met = static_cast<double>(std::count_if(count.begin(), count.end(), [](auto c) { return c > 0; }));
        return static_cast<double>(escaped) < rays_in_cell * met;
    };
    while (found->resolution_ > coarsest && is_sparse()) {
        const std::size_t n = found->resolution_, half = n / 2;
        std::vector<std::uint32_t> coarse(6 * half * half, 0);
        for (std::size_t cell = 0; cell < count.size(); ++cell) {
            coarse[(cell / (n * n) * half + cell / n % n / 2) * half + cell % n / 2] += count[cell];
        }
        count = std::move(coarse);
        found->divide(half);
    }
    found->add_cells(count);
    return found;
}

bool SkyOpenings::View::look(const Tracer& tracer, const SkyOpenings& openings, const SurfacePoint& x,
                             std::size_t count, RandomStream& stream) {
    segments_.clear();
    directions_.clear();
    weights_.clear();
    const Mesh& mesh = tracer.mesh();
    const SurfacePoint from = inset(mesh, x);
    if (!openings.box_.contains(from.position)) {
        return false;
    }
    const Vec3 &n = from.normal, &face_normal = mesh.face_normal(from);
    factors_.assign(openings.cells_.size(), 0.0);
    double whole = 0.0;
    for (std::size_t c = 0; c < openings.cells_.size(); ++c) {
        const Cell& cell = openings.cells_[c];
        const Vec3 way = cell.centre - from.position;
        // The corner that is highest above the plane of the face: some of the cell may be seen only if it is.
        const double reach = std::abs(face_normal.dot(cell.half_u)) + std::abs(face_normal.dot(cell.half_v));
        if (face_normal.dot(way) + reach <= 0.0) {
            continue;
        }
        const double square = way.squaredNorm();
        if (square < nearest * nearest * 4.0 * (cell.half_u.squaredNorm() + cell.half_v.squaredNorm())) {
            return false;
        }
        const double distance = std::sqrt(square);
        // At least what half of its reach would give: no cell is left out whose centre is below the horizon.
        const double slope = std::max(cosine(way / distance, n, face_normal), 0.5 * reach / distance);
        factors_[c] = slope * std::abs(way[cell.axis]) / distance * cell.area / (std::numbers::pi * square);
        whole += factors_[c];
        if (whole > most_seen) {
            return false;
        }
    }
    if (whole == 0.0) {
        return true;
    }
    // Systematic sampling: one ray for each equal part of the sum, in its cell at a place of a lattice.
    const double start = stream.uniform();
    const std::array<double, 2> shift{stream.uniform(), stream.uniform()};
    const double step = whole / static_cast<double>(count);
    double sum = 0.0; // of the cells up to c
    std::size_t c = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const double at = (static_cast<double>(k) + start) * step;
        for (; c + 1 < factors_.size() && sum + factors_[c] <= at; ++c) {
            sum += factors_[c];
        }
        if (!(factors_[c] > 0.0)) {
            continue; // rounding at the end of the sum
        }
        const Cell& cell = openings.cells_[c];
        const auto [u, v] = even_point<2>(k, shift);
        const Vec3 to = cell.centre + (2.0 * u - 1.0) * cell.half_u + (2.0 * v - 1.0) * cell.half_v,
                   way = to - from.position;
        const double distance = way.norm();
        const Vec3 direction = way / distance;
        const double slope = cosine(direction, n, face_normal);
        if (slope > 0.0) {
            segments_.push_back({from.position, to, from.face, none});
            directions_.push_back(direction);
            weights_.push_back(slope * std::abs(direction[cell.axis]) * cell.area /
                               (std::numbers::pi * distance * distance) * step / factors_[c]);
        }
    }
    blocked_.resize(segments_.size());
    tracer.occluded(segments_, blocked_);
    return true;
}

} // namespace difusa
