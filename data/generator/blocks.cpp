#include "blocks.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace scenes {

namespace {

using Cell = std::array<int, 3>;

std::array<double, 3> coordinates(const Vector& v) {
    return {v.x, v.y, v.z};
}

Vector vector(const std::array<double, 3>& c) {
    return {c[0], c[1], c[2]};
}

/// The coordinates along one axis at which blocks begin or end.
std::vector<double> sorted(std::vector<double> breaks) {
    std::sort(breaks.begin(), breaks.end());
    breaks.erase(std::unique(breaks.begin(), breaks.end()), breaks.end());
    return breaks;
}

/// An arch's faces between its front at y_low and its back at y_high; those towards solids are omitted.
void add_arch(Surface& surface, const Vector& low, const Vector& high, int segments, unsigned material, bool open_low,
              bool open_high) {
    const double radius = 0.5 * (high.x - low.x), middle = 0.5 * (low.x + high.x);
    if (segments < 2 || segments % 2 != 0 || !(high.z - low.z > radius)) {
        throw std::logic_error("an arch needs an even number of segments and room for its crown");
    }
    const auto at = [&](int i, double y) -> Vector { // from the foot at high.x over the crown to low.x
        if (i == 0 || i == segments) {
            return {i == 0 ? high.x : low.x, y, low.z};
        }
        const double angle = std::numbers::pi * i / segments;
        return {middle + radius * std::cos(angle), y, low.z + radius * std::sin(angle)};
    };
    for (int i = 0; i < segments; ++i) {
        surface.polygon({at(i, low.y), at(i + 1, low.y), at(i + 1, high.y), at(i, high.y)}, material);
    }
    for (const bool back : {false, true}) {
        if (!(back ? open_high : open_low)) {
            continue;
        }
        const double y = back ? high.y : low.y;
        // Counterclockwise seen from -y; reversed for the back.
        const auto triangle = [&](const Vector& a, const Vector& b, const Vector& c) {
            surface.polygon(back ? std::vector<Vector>{a, c, b} : std::vector<Vector>{a, b, c}, material);
        };
        const Vector top_low{low.x, y, high.z}, top_high{high.x, y, high.z};
        for (int i = 0; i < segments / 2; ++i) {
            triangle(top_high, at(i + 1, y), at(i, y));
        }
        triangle(top_high, top_low, at(segments / 2, y));
        for (int i = segments / 2; i < segments; ++i) {
            triangle(top_low, at(i + 1, y), at(i, y));
        }
    }
}

} // namespace

Vector rounded(const Vector& v) {
    const auto micrometres = [](double x) { return std::round(x * 1e6) / 1e6; };
    return {micrometres(v.x), micrometres(v.y), micrometres(v.z)};
}

Blocks::Blocks(const Vector& low, const Vector& high) {
    steps_.push_back({rounded(low), rounded(high), std::nullopt, 0, false});
}

void Blocks::fill(const Vector& low, const Vector& high, unsigned material) {
    steps_.push_back({rounded(low), rounded(high), material, 0, false});
}

void Blocks::carve(const Vector& low, const Vector& high) {
    steps_.push_back({rounded(low), rounded(high), std::nullopt, 0, false});
}

void Blocks::arch(const Vector& low, const Vector& high, int segments, unsigned material) {
    steps_.push_back({rounded(low), rounded(high), material, segments, false});
}

void Blocks::leave_out(const Vector& low, const Vector& high) {
    steps_.push_back({rounded(low), rounded(high), std::nullopt, 0, true});
}

void Blocks::add_to(Surface& surface) const {
    std::array<std::vector<double>, 3> breaks;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (const Step& step : steps_) {
            breaks[axis].push_back(coordinates(step.low)[axis]);
            breaks[axis].push_back(coordinates(step.high)[axis]);
        }
        breaks[axis] = sorted(breaks[axis]);
    }
    const auto place = [&](const Cell& lattice) {
        std::array<double, 3> result{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            result[axis] = breaks[axis][static_cast<std::size_t>(lattice[axis])];
        }
        return result;
    };
    const auto end = [&](std::size_t axis) { return static_cast<int>(breaks[axis].size()) - 1; };

    /// The last step containing a cell; steps begin and end at breaks, so it is either entirely inside or outside.
    const auto step_of = [&](const Cell& cell) {
        const auto low = place(cell);
        std::size_t found = 0;
        for (std::size_t s = 0; s < steps_.size(); ++s) {
            const auto a = coordinates(steps_[s].low), b = coordinates(steps_[s].high);
            bool inside = true;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                inside = inside && a[axis] <= low[axis] && low[axis] < b[axis];
            }
            found = inside ? s : found;
        }
        return found;
    };
    const auto is_air = [&](const Cell& cell) {
        const Step& step = steps_[step_of(cell)];
        return !step.material && !step.left_out;
    };

    Cell cell{};
    for (cell[2] = 0; cell[2] < end(2); ++cell[2]) {
        for (cell[1] = 0; cell[1] < end(1); ++cell[1]) {
            for (cell[0] = 0; cell[0] < end(0); ++cell[0]) {
                const Step& step = steps_[step_of(cell)];
                if (!step.material) {
                    continue;
                }
                std::array<bool, 6> open{};
                for (std::size_t side = 0; side < 6; ++side) {
                    Cell beside = cell;
                    beside[side / 2] += side % 2 == 0 ? -1 : 1;
                    open[side] = beside[side / 2] >= 0 && beside[side / 2] < end(side / 2) && is_air(beside);
                }
                const auto low = place(cell), high = place({cell[0] + 1, cell[1] + 1, cell[2] + 1});
                if (step.segments > 0) {
                    if (low != coordinates(step.low) || high != coordinates(step.high)) {
                        throw std::logic_error("a block ends within an arch");
                    }
                    if (open[x_low] || open[x_high] || open[z_high]) {
                        throw std::logic_error("an arch must stand between solids, and under one");
                    }
                    add_arch(surface, step.low, step.high, step.segments, *step.material, open[y_low], open[y_high]);
                    continue;
                }
                for (std::size_t side = 0; side < 6; ++side) {
                    if (!open[side]) {
                        continue;
                    }
                    const std::size_t axis = side / 2;
                    const std::size_t u = side % 2 == 1 ? (axis + 1) % 3 : (axis + 2) % 3, v = 3 - axis - u;
                    std::vector<Vector> corners;
                    for (std::size_t k = 0; k < 4; ++k) {
                        auto corner = side % 2 == 1 ? high : low;
                        corner[u] = k == 1 || k == 2 ? high[u] : low[u];
                        corner[v] = k >= 2 ? high[v] : low[v];
                        corners.push_back(vector(corner));
                    }
                    surface.polygon(corners, *step.material);
                }
            }
        }
    }
}

} // namespace scenes
