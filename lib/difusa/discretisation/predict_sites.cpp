#include <difusa/discretisation/predict_sites.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/core/random.h>
#include <difusa/discretisation/cell_table.h>
#include <difusa/mesh/surface_sampling.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace difusa {

namespace {

constexpr double window_in_spacings = 8.0;
constexpr double margin_in_windows = 1.5 / window_in_spacings; ///< sites farther away hardly matter
constexpr double tolerance = 0.01;                             ///< relative standard error
constexpr std::size_t first_draws = 64;
constexpr double most_of_surface = 0.25;

/// Some cells of a grid over the surface, and the surface within them.
struct Windows {
    Vec3 origin;
    double size;
    CellTable table;              ///< numbers the windows
    std::vector<Index> drawn;     ///< #draws, window
    std::vector<double> area;     ///< #windows, of the surface in each, without the margin
    Mesh mesh;                    ///< the surface in the windows with their margins; each has its own regions
    std::vector<Index> window_of; ///< #triangles of that mesh

    Cell cell_of(const Vec3& p) const {
        const Vec3 scaled = (p - origin) / size;
        return {static_cast<std::int32_t>(std::floor(scaled[0])), static_cast<std::int32_t>(std::floor(scaled[1])),
                static_cast<std::int32_t>(std::floor(scaled[2]))};
    }
    Index find(const Cell& cell) const { return table.find(cell, 0); }
};

using Polygon = std::vector<Vec3>;

/// The part of a convex polygon inside the box (Sutherland and Hodgman 1974).
Polygon clip(Polygon polygon, const Vec3& low, const Vec3& high) {
    Polygon kept;
    for (int side = 0; side < 6 && !polygon.empty(); ++side) {
        const int axis = side / 2;
        const double sign = side % 2 == 0 ? 1.0 : -1.0;
        const double wall = side % 2 == 0 ? low[axis] : high[axis];
        kept.clear();
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const Vec3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
            const double inside_p = sign * (p[axis] - wall), inside_q = sign * (q[axis] - wall);
            if (inside_p >= 0.0) {
                kept.push_back(p);
            }
            if ((inside_p >= 0.0) != (inside_q >= 0.0)) {
                kept.emplace_back(p + inside_p / (inside_p - inside_q) * (q - p));
            }
        }
        polygon.swap(kept);
    }
    return polygon;
}

/// Calls `visit(a, b, c, area)` for the triangles of a fan over a convex polygon.
template <class Visit> void for_each_triangle(const Polygon& polygon, const Visit& visit) {
    for (std::size_t k = 2; k < polygon.size(); ++k) {
        const double area = 0.5 * (polygon[k - 1] - polygon[0]).cross(polygon[k] - polygon[0]).norm();
        if (area > 0.0) {
            visit(polygon[0], polygon[k - 1], polygon[k], area);
        }
    }
}

/// Triangles of the mesh near each window, as pairs (window, triangle) in order.
std::vector<std::pair<Index, Index>> triangles_near(const Windows& windows, const Mesh& mesh,
                                                    const Execution& execution) {
    constexpr std::size_t grain = 4096;
    std::vector<std::vector<std::pair<Index, Index>>> found((mesh.triangles.size() + grain - 1) / grain);
    parallel_for(mesh.triangles.size(), grain, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t t = begin; t < end; ++t) {
            const auto corner = [&](int k) -> const Vec3& { return mesh.corner(static_cast<Index>(t), k); };
            const Vec3 margin = Vec3::Constant(margin_in_windows * windows.size);
            const Cell low = windows.cell_of(corner(0).cwiseMin(corner(1)).cwiseMin(corner(2)) - margin);
            const Cell high = windows.cell_of(corner(0).cwiseMax(corner(1)).cwiseMax(corner(2)) + margin);
            const auto add = [&](Index window) {
                if (window != none) {
                    found[begin / grain].emplace_back(window, static_cast<Index>(t));
                }
            };
            double cells = 1.0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                cells *= static_cast<double>(high[axis]) - low[axis] + 1.0;
            }
            if (cells > static_cast<double>(windows.table.count())) {
                for (const CellTable::Slot& slot : windows.table.slots()) {
                    bool meets = slot.region != none;
                    for (std::size_t axis = 0; axis < 3; ++axis) {
                        meets = meets && low[axis] <= slot.cell[axis] && slot.cell[axis] <= high[axis];
                    }
                    add(meets ? slot.number : none);
                }
                continue;
            }
            for (std::int32_t x = low[0]; x <= high[0]; ++x) {
                for (std::int32_t y = low[1]; y <= high[1]; ++y) {
                    for (std::int32_t z = low[2]; z <= high[2]; ++z) {
                        add(windows.find({x, y, z}));
                    }
                }
            }
        }
    });
    std::vector<std::pair<Index, Index>> all;
    for (const auto& part : found) {
        all.insert(all.end(), part.begin(), part.end());
    }
    std::sort(all.begin(), all.end());
    return all;
}

/// Cuts the surface inside the windows and their margins out of the mesh.
void cut_out(Windows& windows, const Mesh& mesh, const Execution& execution) {
    std::vector<Cell> cell(windows.table.count());
    for (const CellTable::Slot& slot : windows.table.slots()) {
        if (slot.region != none) {
            cell[slot.number] = slot.cell;
        }
    }
    windows.area.assign(cell.size(), 0.0);
    Mesh& part = windows.mesh;
    std::vector<std::pair<Index, Index>> regions; // window, region of the mesh
    for (const auto& [window, t] : triangles_near(windows, mesh, execution)) {
        const Cell& c = cell[window];
        const Vec3 low = windows.origin + windows.size * Vec3(c[0], c[1], c[2]);
        const Vec3 high = low + Vec3::Constant(windows.size);
        const Vec3 margin = Vec3::Constant(margin_in_windows * windows.size);
        const Polygon whole{mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)};
        const auto add_area = [&, at = window](const Vec3&, const Vec3&, const Vec3&, double area) {
            windows.area[at] += area;
        };
        for_each_triangle(clip(whole, low, high), add_area);
        const auto add = [&, at = window, face = t](const Vec3& p, const Vec3& q, const Vec3& r, double area) {
            const auto first = static_cast<Index>(part.points.size());
            part.points.insert(part.points.end(), {p, q, r});
            part.triangles.push_back({first, first + 1, first + 2});
            part.normals.push_back(mesh.normals[face]);
            part.areas.push_back(area);
            part.area += area;
            regions.emplace_back(at, mesh.region[face]);
            windows.window_of.push_back(at);
        };
        for_each_triangle(clip(whole, low - margin, high + margin), add);
    }
    std::vector<std::pair<Index, Index>> distinct = regions;
    std::sort(distinct.begin(), distinct.end());
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    for (const auto& region : regions) {
        part.region.push_back(
            static_cast<Index>(std::lower_bound(distinct.begin(), distinct.end(), region) - distinct.begin()));
    }
    part.region_count = static_cast<Index>(distinct.size());
    part.low = mesh.low;
    part.high = mesh.high;
}

Windows draw_windows(const Mesh& mesh, double size, std::size_t draws, std::uint64_t seed, const Execution& execution) {
    Windows windows;
    windows.size = size;
    RandomStream stream(seed, "windows", draws);
    const double x = stream.uniform(), y = stream.uniform(), z = stream.uniform();
    windows.origin = mesh.low - size * Vec3(x, y, z); // axis-parallel walls do not coincide with cell borders
    for (const SurfacePoint& p : even_points(mesh, draws, stream)) {
        windows.drawn.push_back(windows.table.insert(windows.cell_of(p.position), 0));
    }
    cut_out(windows, mesh, execution);
    return windows;
}

} // namespace

std::optional<double> predict_sites(const Sampler& sampler, const Mesh& mesh, double spacing, std::uint64_t seed,
                                    const Execution& execution) {
    DIFUSA_REQUIRE(!sampler.needs_visibility());
    if (!sampler.covers_evenly()) {
        return std::nullopt;
    }
    const double size = window_in_spacings * spacing;
    const double across = 1.0 + 2.0 * margin_in_windows;
    if (!(mesh.diameter() / size < 0x1p30)) {
        return std::nullopt;
    }
    for (std::size_t draws = first_draws;; draws *= 4) {
        const double wanted = static_cast<double>(draws) * across * across * size * size;
        if (wanted > 2.0 * most_of_surface * mesh.area) { // some are drawn more than once
            return std::nullopt;
        }
        const Windows windows = draw_windows(mesh, size, draws, seed, execution);
        if (windows.mesh.area > most_of_surface * mesh.area) {
            return std::nullopt;
        }
        constexpr std::size_t no_limit = std::size_t{1} << 30U;
        const std::vector<SurfacePoint> sites =
            sampler.sample(windows.mesh, nullptr, spacing, no_limit, RandomStream(seed, "window sites"), execution);
        std::vector<double> count(windows.area.size(), 0.0);
        for (const SurfacePoint& site : sites) {
            const Index window = windows.window_of[site.face];
            count[window] += windows.find(windows.cell_of(site.position)) == window ? 1.0 : 0.0;
        }
        double sum = 0.0, squares = 0.0;
        for (const Index window : windows.drawn) {
            const double density = windows.area[window] > 0.0 ? count[window] / windows.area[window] : 0.0;
            sum += density;
            squares += density * density;
        }
        const auto n = static_cast<double>(draws);
        const double mean = sum / n;
        const double error = std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1.0));
        if (mean > 0.0 && error <= tolerance * mean) {
            return mean * mesh.area;
        }
    }
}

ExpectedSites expected_sites(const Sampler& sampler, const Mesh& mesh, const Visibility* visibility, double spacing,
                             std::size_t limit, std::uint64_t seed, const Execution& execution) {
    if (!sampler.needs_visibility()) {
        if (const std::optional<double> count = predict_sites(sampler, mesh, spacing, seed, execution)) {
            return {*count, false};
        }
    }
    try {
        const RandomStream stream(seed, "sites");
        return {static_cast<double>(sampler.sample(mesh, visibility, spacing, limit, stream, execution).size()), true};
    } catch (const ResourceError&) { // far too many
        return {static_cast<double>(limit), false};
    }
}

} // namespace difusa
