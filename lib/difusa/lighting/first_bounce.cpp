#include <difusa/lighting/first_bounce.h>

#include <difusa/core/even_sequence.h>
#include <difusa/core/parallel.h>
#include <difusa/mesh/surface_sampling.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace difusa {

namespace {

/// Cells in the square of the site distance; places at which the light of a whole cell is measured.
constexpr double cells_per_square = 8.0;
constexpr double places_per_cell = 4.0;

/// Cells that one thread measures in a row.
constexpr std::size_t block = 1024;

/// A triangle is cut along n - 1 lines parallel to each side into n² cells, in n rows along the second barycentric
/// coordinate v: row j has n - j cells that stand like the triangle, and between them n - j - 1 upside down.
std::size_t rows_for(double area, double cell_area) {
    return static_cast<std::size_t>(std::clamp(std::ceil(std::sqrt(area / cell_area)), 1.0, 4096.0));
}

bool is_dark(const Rgb& light) {
    return !(light > 0.0).any();
}

std::size_t cell_at(double u, double v, std::size_t n) {
    const auto whole = [&](double x, std::size_t end) {
        return std::min(static_cast<std::size_t>(std::max(0.0, x)), end - 1);
    };
    const double x = u * static_cast<double>(n), y = v * static_cast<double>(n);
    const std::size_t j = whole(y, n), i = whole(x, n - j);
    const bool upside_down = x - static_cast<double>(i) + y - static_cast<double>(j) > 1.0 && i + j + 1 < n;
    return j * (2 * n - j) + 2 * i + (upside_down ? 1 : 0);
}

/// The inverse: barycentric coordinates of the place (s, t), s + t <= 1, in a cell.
std::array<double, 2> in_cell(std::size_t cell, std::size_t n, double s, double t) {
    // Before row j there are n² - (n - j)² cells.
    const std::size_t left = n * n - cell;
    const std::size_t j = n - static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(left))));
    cell -= j * (2 * n - j);
    const double side = 1.0 / static_cast<double>(n);
    const std::size_t i = cell / 2;
    const double u = static_cast<double>(i), v = static_cast<double>(j);
    return cell % 2 == 0 ? std::array{(u + s) * side, (v + t) * side}
                         : std::array{(u + 1.0 - s) * side, (v + 1.0 - t) * side};
}

} // namespace

FirstBounce::FirstBounce(const Scene& scene, const Visibility& visibility, std::shared_ptr<const DirectLight> light,
                         double spacing, std::uint64_t seed, const Execution& execution)
    : scene_(scene), visibility_(visibility), light_(std::move(light)),
      cell_area_(spacing * spacing / cells_per_square) {
    const Mesh& mesh = scene.mesh;
    if (!light_->any()) {
        return;
    }
    first_.push_back(0);
    for (const double area : mesh.areas) {
        const std::size_t n = rows_for(area, cell_area_);
        first_.push_back(first_.back() + n * n);
    }
    below_.assign(first_.back() + 1, 0.0);
    std::vector<std::size_t> cast(execution.threads, 0);
    const std::size_t cells = first_.back();
    parallel_for((cells + block - 1) / block, 1, execution, [&](std::size_t begin, std::size_t end, unsigned number) {
        Worker worker;
        for (std::size_t b = begin; b < end; ++b) {
            measure(b * block, std::min(cells, (b + 1) * block), RandomStream(seed, "light of cells", b), worker);
        }
        cast[number] += worker.light.cast + worker.light.lamps.cast;
    });
    for (const std::size_t segments : cast) {
        segments_ += segments;
    }
    double all = 0.0, squares = 0.0;
    for (std::size_t t = 0; t < mesh.areas.size(); ++t) {
        const double area = mesh.areas[t] / static_cast<double>(first_[t + 1] - first_[t]);
        for (std::size_t cell = first_[t]; cell < first_[t + 1]; ++cell) {
            const double q = below_[cell];
            below_[cell] = all;
            all += q;
            squares += q * q / area;
        }
    }
    below_.back() = all;
    bright_share_ = all > 0.0 ? all * all / squares / mesh.area : 0.0;
    if (!(all > 0.0) || bright_share_ > broad) {
        below_.clear();
        first_.clear();
    }
}

double FirstBounce::memory(const Mesh& mesh, double spacing) {
    double cells = 0.0;
    for (const double area : mesh.areas) {
        cells += std::pow(static_cast<double>(rows_for(area, spacing * spacing / cells_per_square)), 2);
    }
    return (cells + static_cast<double>(mesh.areas.size())) * sizeof(double);
}

Index FirstBounce::triangle_of(std::size_t cell) const {
    const auto next = std::upper_bound(first_.begin(), first_.end(), cell);
    return static_cast<Index>(std::distance(first_.begin(), next)) - 1;
}

/// Writes the light of the cells from `first` to `last`, the mean of the channels times the area, to `below_`.
void FirstBounce::measure(std::size_t first, std::size_t last, RandomStream stream, Worker& worker) {
    const std::array<double, 2> shift{stream.uniform(), stream.uniform()};
    worker.places.clear();
    std::vector<std::pair<std::size_t, double>> owner; // of each place the cell, and the area it stands for
    Index t = triangle_of(first);
    for (std::size_t cell = first; cell < last; ++cell) {
        t += cell == first_[t + 1] ? 1 : 0;
        const std::size_t n = rows_for(scene_.mesh.areas[t], cell_area_);
        const double area = scene_.mesh.areas[t] / static_cast<double>(n * n);
        const double count = std::ceil(places_per_cell * std::min(1.0, area / cell_area_));
        for (double k = 0.0; k < count; ++k) {
            const auto [a, b] = even_point<2>(owner.size(), shift);
            const double root = std::sqrt(a);
            const auto [u, v] = in_cell(cell - first_[t], n, root * (1.0 - b), root * b);
            worker.places.push_back(scene_.mesh.at(t, u, v));
            owner.emplace_back(cell, area / count);
        }
    }
    worker.H.resize(worker.places.size());
    light_->sample(worker.places, stream, worker.H, worker.light);
    for (std::size_t k = 0; k < worker.places.size(); ++k) {
        if (!is_dark(worker.H[k])) {
            below_[owner[k].first] += owner[k].second * (scene_.reflectance(worker.places[k]) * worker.H[k]).mean();
        }
    }
}

/// Probability density, by area, with which y is drawn.
double FirstBounce::chance(const SurfacePoint& y) const {
    const std::size_t n = rows_for(scene_.mesh.areas[y.face], cell_area_);
    const std::size_t cell = first_[y.face] + cell_at(y.u, y.v, n);
    return (below_[cell + 1] - below_[cell]) / below_.back() * static_cast<double>(n * n) / scene_.mesh.areas[y.face];
}

/// Probability density, by area, with which a ray from x goes towards y: cosine over pi by solid angle, the directions
/// below the plane of the face mirrored to above it (Surroundings::look). It is also the kernel of irradiance.
double FirstBounce::ray_density(const SurfacePoint& x, const SurfacePoint& y) const {
    const Vec3 way = y.position - x.position;
    const Vec3& n = scene_.mesh.normals[x.face];
    const double r2 = way.squaredNorm(), up = n.dot(way), at_y = -scene_.mesh.normals[y.face].dot(way);
    if (!(up > 0.0) || !(at_y > 0.0)) {
        return 0.0;
    }
    const double at_x = std::max(0.0, x.normal.dot(way)) + std::max(0.0, x.normal.dot(way - 2.0 * up * n));
    return at_x * at_y / (std::numbers::pi * r2 * r2);
}

/// The place in the cell up to which `light` comes.
SurfacePoint FirstBounce::place(double light, double u, double v) const {
    const auto after = std::upper_bound(below_.begin(), below_.end() - 1, light);
    const auto cell = static_cast<std::size_t>(std::distance(below_.begin(), after)) - 1;
    const Index t = triangle_of(cell);
    const double root = std::sqrt(u);
    const auto [a, b] =
        in_cell(cell - first_[t], rows_for(scene_.mesh.areas[t], cell_area_), root * (1.0 - v), root * v);
    return scene_.mesh.at(t, a, b);
}

Rgb FirstBounce::irradiance(const SurfacePoint& x, std::span<const SurfacePoint> met, std::span<const double> weight,
                            std::size_t rays, RandomStream& stream, Worker& worker) const {
    const SurfacePoint from = inset(scene_.mesh, x); // where the rays started
    worker.H.resize(met.size());
    light_->sample(met, stream, worker.H, worker.light);
    const std::size_t count = places(rays);
    const auto by_rays = static_cast<double>(rays), by_places = static_cast<double>(count);
    Rgb sum = Rgb::Zero();
    for (std::size_t p = 0; p < met.size(); ++p) {
        if (is_dark(worker.H[p])) {
            continue;
        }
        double share = 1.0;
        if (const double other = count == 0 ? 0.0 : by_places * chance(met[p]); other > 0.0) {
            const double own = by_rays * ray_density(from, met[p]);
            share = own / (own + other);
        }
        sum += weight[p] * share * scene_.reflectance(met[p]) * worker.H[p];
    }
    if (count == 0) {
        return sum;
    }
    worker.places.clear();
    worker.segments.clear();
    const double along = stream.uniform();
    const std::array<double, 2> shift{stream.uniform(), stream.uniform()};
    for (std::size_t k = 0; k < count; ++k) {
        const auto [u, v] = even_point<2>(k, shift);
        const SurfacePoint y = place((static_cast<double>(k) + along) / by_places * below_.back(), u, v);
        if (ray_density(from, y) > 0.0) {
            worker.places.push_back(y);
            worker.segments.push_back({from.position, y.position, from.face, y.face});
        }
    }
    worker.blocked.assign(worker.places.size(), 0);
    if (!scene_.mesh.convex) {
        visibility_.occluded(worker.segments, worker.blocked);
        worker.light.cast += worker.segments.size();
    }
    std::size_t seen = 0;
    for (std::size_t k = 0; k < worker.places.size(); ++k) {
        if (worker.blocked[k] == 0) {
            worker.places[seen++] = worker.places[k];
        }
    }
    worker.places.resize(seen);
    worker.H.resize(seen);
    light_->sample(worker.places, stream, worker.H, worker.light);
    for (std::size_t k = 0; k < seen; ++k) {
        const SurfacePoint& y = worker.places[k];
        const double density = ray_density(from, y);
        sum += density / (by_rays * density + by_places * chance(y)) * scene_.reflectance(y) * worker.H[k];
    }
    return sum;
}

} // namespace difusa
