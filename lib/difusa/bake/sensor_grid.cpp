#include <difusa/bake/sensor_grid.h>

#include <difusa/bake/names.h>
#include <difusa/core/error.h>
#include <difusa/core/text.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace difusa {

namespace {

using Vec2 = Eigen::Vector2d;

constexpr double most_sensors = 1e6;
constexpr double flat = 1e-6; ///< relative to the scene's size, and to a unit normal

[[noreturn]] void refuse(const SensorGrid& grid, const std::string& why) {
    throw UsageError("--grid " + grid.on + ": " + why);
}

/// Triangles of the face or material that a grid names.
std::vector<Index> triangles_named(const SensorGrid& grid, const Scene& scene) {
    const Mesh& mesh = scene.mesh;
    std::vector<Index> found;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (scene.materials[mesh.material[t]].name == grid.on) {
            found.push_back(t);
        }
    }
    Index face = 0;
    const char* const end = grid.on.data() + grid.on.size();
    const auto [rest, error] = std::from_chars(grid.on.data(), end, face);
    if (found.empty() && error == std::errc() && rest == end) {
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            if (mesh.original_face[t] == face) {
                found.push_back(t);
            }
        }
    }
    if (found.empty()) {
        refuse(grid, unknown_name("material", grid.on, names_of_materials_in_use(scene)) +
                         " (nor is it the number of a face)");
    }
    return found;
}

/// A flat face with coordinates in its plane.
struct GridPlane {
    Vec3 normal, across, along, origin;
    std::vector<std::array<Vec2, 3>> triangles;
    std::vector<std::array<Vec2, 2>> outline;
    Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;

    Vec2 at(const Vec3& p) const { return {across.dot(p - origin), along.dot(p - origin)}; }
};

/// 1 for each triangle that is the other side of one before it (#triangles): the backs of double-sided faces.
std::vector<char> backs_among(const std::vector<Index>& triangles, const Mesh& mesh) {
    using Corner = std::array<double, 3>;
    std::map<std::array<Corner, 3>, Index> sides;
    std::vector<char> back(triangles.size(), 0);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        std::array<Corner, 3> corners;
        for (int k = 0; k < 3; ++k) {
            const Vec3& p = mesh.corner(triangles[i], k);
            corners[static_cast<std::size_t>(k)] = {p.x(), p.y(), p.z()};
        }
        std::sort(corners.begin(), corners.end());
        const auto [first, is_new] = sides.emplace(corners, triangles[i]);
        back[i] = !is_new && mesh.normals[first->second].dot(mesh.normals[triangles[i]]) < 0.0 ? 1 : 0;
    }
    return back;
}

double cross(const Vec2& a, const Vec2& b) {
    return a.x() * b.y() - a.y() * b.x();
}

/// The direction of one of the sides, within 45° of x, along which the rectangle around all of them is smallest; x
/// itself, unless another one is smaller.
Vec2 best_direction(const std::vector<std::array<Vec2, 2>>& outline) {
    constexpr double hardly = 0.01;         // of an area: discs have no better direction than others
    constexpr double per_radian = 1 << 14U; // directions that are told apart
    std::map<long, Vec2> directions;
    for (const std::array<Vec2, 2>& side : outline) {
        if (side[0] == side[1]) {
            continue;
        }
        Vec2 way = (side[1] - side[0]).normalized();
        for (int turns = 0; turns < 3 && (way.x() < std::abs(way.y()) || way.y() <= -way.x()); ++turns) {
            way = Vec2(-way.y(), way.x());
        }
        directions.emplace(std::lround(per_radian * std::atan2(way.y(), way.x())), way);
    }
    const auto area = [&](const Vec2& way) {
        Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
        for (const std::array<Vec2, 2>& side : outline) {
            const Vec2 p(way.dot(side[0]), cross(way, side[0]));
            low = low.cwiseMin(p);
            high = high.cwiseMax(p);
        }
        return (high - low).prod();
    };
    Vec2 best = Vec2::UnitX();
    double least = area(best);
    for (const auto& [number, way] : directions) {
        if (const double here = area(way); here < (1.0 - hardly) * least) {
            best = way;
            least = here;
        }
    }
    return best;
}

GridPlane plane_of(const SensorGrid& grid, const Mesh& mesh, const std::vector<Index>& triangles) {
    GridPlane plane;
    const std::vector<char> back = backs_among(triangles, mesh);
    plane.normal = Vec3::Zero();
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        plane.normal += (back[i] != 0 ? 0.0 : mesh.areas[triangles[i]]) * mesh.normals[triangles[i]];
    }
    plane.normal.normalize();
    plane.origin = mesh.corner(triangles.front(), 0);
    std::map<std::pair<Index, Index>, int> sides;
    for (std::size_t of = 0; of < triangles.size(); ++of) {
        const Index t = triangles[of];
        for (int k = 0; back[of] == 0 && k < 3; ++k) {
            const double off = std::abs(plane.normal.dot(mesh.corner(t, k) - plane.origin));
            if (!(mesh.normals[t].dot(plane.normal) > 1.0 - flat) || off > flat * mesh.diameter()) {
                refuse(grid, "not flat: sensors at one height need a flat face; name one by its number in the file");
            }
            const auto i = static_cast<std::size_t>(k);
            ++sides[std::minmax({mesh.triangles[t][i], mesh.triangles[t][(i + 1) % 3]})];
        }
    }
    for (const Vec3& axis : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ())}) {
        plane.across = axis - axis.dot(plane.normal) * plane.normal;
        if (plane.across.norm() > 0.6) { // one of the three is at least sqrt(2/3)
            break;
        }
    }
    plane.across.normalize();
    plane.along = plane.normal.cross(plane.across);
    const auto find_outline = [&] {
        plane.outline.clear();
        for (const auto& [side, count] : sides) {
            if (count == 1) {
                plane.outline.push_back({plane.at(mesh.points[side.first]), plane.at(mesh.points[side.second])});
            }
        }
    };
    find_outline();
    const Vec2 direction = best_direction(plane.outline);
    if (direction != Vec2(Vec2::UnitX())) {
        plane.across = direction.x() * plane.across + direction.y() * plane.along;
        plane.along = plane.normal.cross(plane.across);
        find_outline();
    }
    for (const Index t : triangles) {
        plane.triangles.push_back(
            {plane.at(mesh.corner(t, 0)), plane.at(mesh.corner(t, 1)), plane.at(mesh.corner(t, 2))});
        for (const Vec2& corner : plane.triangles.back()) {
            plane.low = plane.low.cwiseMin(corner);
            plane.high = plane.high.cwiseMax(corner);
        }
    }
    return plane;
}

bool covers(const std::array<Vec2, 3>& t, const Vec2& p, double slack) {
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec2 side = t[(k + 1) % 3] - t[k];
        if (cross(side, p - t[k]) < -slack * side.norm()) {
            return false;
        }
    }
    return true;
}

double distance(const std::array<Vec2, 2>& side, const Vec2& p) {
    const Vec2 way = side[1] - side[0];
    const double along = std::clamp((p - side[0]).dot(way) / way.squaredNorm(), 0.0, 1.0);
    return (p - side[0] - along * way).norm();
}

/// The cells of a grid in the plane, row by row.
class GridCells {
  public:
    GridCells(Vec2 low, Vec2 size, Vec2 count)
        : low_(std::move(low)), size_(std::move(size)), count_(std::move(count)) {}

    std::size_t size() const { return static_cast<std::size_t>(count_.prod()); }

    Vec2 centre(std::size_t cell) const {
        const auto columns = static_cast<std::size_t>(count_.x());
        const std::size_t row = cell / columns, column = cell % columns;
        return centre(static_cast<double>(row), static_cast<double>(column));
    }

    /// `body(cell, centre)` for all centres that are no farther than `reach` from the convex polygon with these
    /// corners, and maybe for some more.
    template <std::size_t n, class Body>
    void visit(const std::array<Vec2, n>& corners, double reach, const Body& body) const {
        double low = corners[0].y(), high = low;
        for (const Vec2& corner : corners) {
            low = std::min(low, corner.y());
            high = std::max(high, corner.y());
        }
        const auto [row, end_row] = range(low - reach, high + reach, 1);
        for (double r = row; r < end_row; ++r) {
            const auto [left, right] = extent(corners, centre(r, 0.0).y(), reach);
            const auto [column, end] = range(left - reach, right + reach, 0);
            for (double c = column; c < end; ++c) {
                body(static_cast<std::size_t>(r * count_.x() + c), centre(r, c));
            }
        }
    }

  private:
    Vec2 centre(double row, double column) const {
        return low_ + Vec2((column + 0.5) / count_.x() * size_.x(), (row + 0.5) / count_.y() * size_.y());
    }

    /// The first cell along an axis with its centre between these, and the one after the last.
    std::pair<double, double> range(double from, double to, Eigen::Index axis) const {
        constexpr double rounding = 1e-6; // of a cell
        const double per_length = count_[axis] / size_[axis];
        return {std::max(0.0, std::ceil((from - low_[axis]) * per_length - 0.5 - rounding)),
                std::min(count_[axis], std::floor((to - low_[axis]) * per_length + 0.5 + rounding))};
    }

    /// The least and the largest x of those points of a polygon whose y is within `reach` of this one.
    template <std::size_t n>
    static std::pair<double, double> extent(const std::array<Vec2, n>& corners, double y, double reach) {
        double least = std::numeric_limits<double>::infinity(), most = -least;
        for (std::size_t k = 0; k < n; ++k) {
            const Vec2 &a = corners[k], &b = corners[(k + 1) % n];
            const double low = std::max(y - reach, std::min(a.y(), b.y())),
                         high = std::min(y + reach, std::max(a.y(), b.y())), rise = b.y() - a.y();
            if (low > high) {
                continue;
            }
            const double at_low = rise != 0.0 ? a.x() + (low - a.y()) / rise * (b.x() - a.x()) : a.x();
            const double at_high = rise != 0.0 ? a.x() + (high - a.y()) / rise * (b.x() - a.x()) : b.x();
            least = std::min({least, at_low, at_high});
            most = std::max({most, at_low, at_high});
        }
        return {least, most};
    }

    Vec2 low_, size_, count_;
};

} // namespace

GridPlaces places_of_grid(const SensorGrid& grid, const Scene& scene) {
    const GridPlane plane = plane_of(grid, scene.mesh, triangles_named(grid, scene));
    const double slack = 1e-9 * scene.mesh.diameter();
    const Vec2 size = plane.high - plane.low - Vec2::Constant(2.0 * grid.margin);
    if (!(size.minCoeff() > 0.0)) {
        refuse(grid, "the margin of " + text_of(grid.margin) + " leaves nothing of a face of " +
                         text_of((plane.high - plane.low).x()) + " by " + text_of((plane.high - plane.low).y()));
    }
    const Vec2 cells = (size / grid.spacing - Vec2::Constant(1e-9)).array().ceil().max(1.0);
    if (!(cells.prod() <= most_sensors)) {
        refuse(grid, "more than a million sensors: give it a larger spacing");
    }
    const GridCells on_plane(plane.low + Vec2::Constant(grid.margin), size, cells);
    std::vector<char> on(on_plane.size(), 0), near(on_plane.size(), 0);
    for (const std::array<Vec2, 3>& t : plane.triangles) {
        on_plane.visit(t, 2.0 * slack, [&](std::size_t cell, const Vec2& p) {
            on[cell] = on[cell] != 0 || covers(t, p, slack) ? 1 : 0;
        });
    }
    for (const std::array<Vec2, 2>& side : plane.outline) {
        on_plane.visit(side, grid.margin, [&](std::size_t cell, const Vec2& p) {
            near[cell] = near[cell] != 0 || distance(side, p) < grid.margin - slack ? 1 : 0;
        });
    }
    GridPlaces places;
    places.normal = plane.normal;
    for (std::size_t cell = 0; cell < on.size(); ++cell) {
        if (on[cell] != 0 && near[cell] == 0) {
            const Vec2 p = on_plane.centre(cell);
            places.positions.push_back(plane.origin + p.x() * plane.across + p.y() * plane.along +
                                       grid.height * plane.normal);
        }
    }
    if (places.positions.empty()) {
        refuse(grid, "no sensor falls on the face: give it a smaller spacing or margin");
    }
    return places;
}

} // namespace difusa
