#include <difusa/scene/intensity_distribution.h>

#include <difusa/core/text.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace difusa {

namespace {

constexpr double radian = std::numbers::pi / 180.0;

using Table = IntensityDistribution::Table;

bool ascends(const std::vector<double>& angles, double least, double most) {
    return !angles.empty() && angles.front() >= least && angles.back() <= most &&
           std::is_sorted(angles.begin(), angles.end(), [](double a, double b) { return a <= b; });
}

/// Whether planes of type C are those of one of the symmetries of IES LM-63, or of none.
bool goes_round(const std::vector<double>& plane) {
    const double first = plane.front(), last = plane.back();
    return plane.size() == 1 || (first == 0.0 && (last == 90.0 || last == 180.0)) || (first == 90.0 && last == 270.0) ||
           last - first > 180.0;
}

void check(const Table& table) {
    const auto refuse = [](const std::string& why) { throw std::invalid_argument(why); };
    const bool c = table.type == PhotometryType::C;
    const std::size_t rows = table.in_plane.size();
    // Not `a < b` of is_sorted: equal angles are refused, too.
    if (!ascends(table.plane, c ? 0.0 : -180.0, c ? 360.0 : 180.0)) {
        refuse("the angles of its planes do not ascend within their range");
    }
    if (!ascends(table.in_plane, c ? 0.0 : -90.0, c ? 180.0 : 90.0) || rows < 2) {
        refuse("the angles in its planes do not ascend within their range, or are fewer than two");
    }
    if (!c && table.plane.size() < 2) {
        refuse("a table of type A or B needs at least two planes");
    }
    if (c && !goes_round(table.plane)) {
        refuse("its planes are from " + text_of(table.plane.front()) + " to " + text_of(table.plane.back()) +
               " degrees: they must end at 90 or 180, or go from 90 to 270, if they stand for others by symmetry, and "
               "beyond 180 if not");
    }
    if (table.value.size() != table.plane.size() * rows) {
        refuse("it does not have one intensity for each angle of each plane");
    }
    if (!std::all_of(table.value.begin(), table.value.end(), [](double v) { return v >= 0.0 && v < 1e30; })) {
        refuse("an intensity is negative or above 1e30");
    }
    if (!std::any_of(table.value.begin(), table.value.end(), [](double v) { return v > 0.0; })) {
        refuse("all intensities are 0");
    }
}

/// Adds the planes 2 axis - p, in reverse order, of those known.
void mirror_planes(Table& table, double axis, bool before) {
    const std::size_t rows = table.in_plane.size();
    Table whole;
    const auto add = [&](double angle, std::size_t p) {
        whole.plane.push_back(angle);
        whole.value.insert(whole.value.end(), table.value.begin() + static_cast<std::ptrdiff_t>(p * rows),
                           table.value.begin() + static_cast<std::ptrdiff_t>((p + 1) * rows));
    };
    const auto add_known = [&] {
        for (std::size_t p = 0; p < table.plane.size(); ++p) {
            add(table.plane[p], p);
        }
    };
    if (!before) {
        add_known();
    }
    for (std::size_t p = table.plane.size(); p-- > 0;) {
        if (table.plane[p] != axis) {
            add(2.0 * axis - table.plane[p], p);
        }
    }
    if (before) {
        add_known();
    }
    table.plane = std::move(whole.plane);
    table.value = std::move(whole.value);
}

/// Angles in the planes from 0 on stand for those below 0 as well.
void mirror_rows(Table& table) {
    const std::size_t rows = table.in_plane.size(), skip = table.in_plane.front() == 0.0 ? 1 : 0;
    std::vector<double> angles, values;
    for (std::size_t r = rows; r-- > skip;) {
        angles.push_back(-table.in_plane[r]);
    }
    angles.insert(angles.end(), table.in_plane.begin(), table.in_plane.end());
    for (std::size_t p = 0; p < table.plane.size(); ++p) {
        const auto* const row = table.value.data() + p * rows;
        for (std::size_t r = rows; r-- > skip;) {
            values.push_back(row[r]);
        }
        values.insert(values.end(), row, row + rows);
    }
    table.in_plane = std::move(angles);
    table.value = std::move(values);
}

/// All planes of what symmetry leaves out. Horizontal angles of the types A and B from 0 on stand for those below 0;
/// vertical ones are of half a sphere.
void expand(Table& table) {
    if (table.type == PhotometryType::A) {
        if (table.plane.front() == 0.0) {
            mirror_planes(table, 0.0, true);
        }
        return;
    }
    if (table.type == PhotometryType::B) {
        if (table.in_plane.front() == 0.0) {
            mirror_rows(table);
        }
        return;
    }
    if (table.plane.front() == 90.0 && table.plane.back() == 270.0) {
        // From 90 to 270; the rest mirrored in the plane of 90 and 270.
        mirror_planes(table, 270.0, false); // up to 450
        const std::size_t rows = table.in_plane.size();
        const auto wrap = static_cast<std::size_t>(
            std::find_if(table.plane.begin(), table.plane.end(), [](double a) { return a >= 360.0; }) -
            table.plane.begin());
        Table whole = table;
        whole.plane.clear();
        whole.value.clear();
        const auto take = [&](std::size_t p, double shift) {
            whole.plane.push_back(table.plane[p] + shift);
            whole.value.insert(whole.value.end(), table.value.begin() + static_cast<std::ptrdiff_t>(p * rows),
                               table.value.begin() + static_cast<std::ptrdiff_t>((p + 1) * rows));
        };
        for (std::size_t p = wrap; p + 1 < table.plane.size(); ++p) {
            take(p, -360.0);
        }
        for (std::size_t p = 0; p < wrap; ++p) {
            take(p, 0.0);
        }
        table = std::move(whole);
        return;
    }
    if (table.plane.size() > 1 && table.plane.front() == 0.0 && table.plane.back() == 90.0) {
        mirror_planes(table, 90.0, false);
    }
    if (table.plane.size() > 1 && table.plane.front() == 0.0 && table.plane.back() == 180.0) {
        mirror_planes(table, 180.0, false);
    }
}

} // namespace

IntensityDistribution::IntensityDistribution(Table table) {
    check(table);
    expand(table);
    const bool c = table.type == PhotometryType::C;
    const std::size_t rows = table.in_plane.size();
    if (c && table.plane.size() > 1 && table.plane.back() < table.plane.front() + 360.0) {
        table.plane.push_back(table.plane.front() + 360.0);
        std::vector<double> first(table.value.begin(), table.value.begin() + static_cast<std::ptrdiff_t>(rows));
        table.value.insert(table.value.end(), first.begin(), first.end());
    }
    even_ = c && table.plane.size() == 1;
    closed_ = c;
    for (const double angle : table.plane) {
        plane_.push_back(angle * radian);
    }
    for (const double angle : table.in_plane) {
        theta_.push_back((c ? angle : 90.0 + angle) * radian);
    }
    value_ = std::move(table.value);
    largest_ = *std::max_element(value_.begin(), value_.end());
    const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
    pole_ = table.type == PhotometryType::B ? y : Vec3(-z);
    zero_ = table.type == PhotometryType::B ? Vec3(-z) : x;
    side_ = table.type == PhotometryType::C ? y : table.type == PhotometryType::B ? x : Vec3(-y);
    beyond_beam_ = find_beyond_beam();
}

double IntensityDistribution::find_beyond_beam() const {
    constexpr double least = 0.1;
    const std::size_t rows = theta_.size(), last_plane = plane_.size() - 1;
    const auto is_bright = [&](std::size_t plane, std::size_t row) {
        return value_[plane * rows + row] > least * largest_;
    };
    double angle = 0.0;
    for (std::size_t p = 0; p <= last_plane; ++p) {
        const std::size_t from = p == 0 ? 0 : p - 1, to = std::min(p + 1, last_plane); // planes of the cells around
        for (std::size_t r = 0; r < rows; ++r) {
            bool bright = false;
            for (std::size_t plane = from; plane <= to; ++plane) {
                bright = bright || is_bright(plane, r) || (r > 0 && is_bright(plane, r - 1)) ||
                         (r + 1 < rows && is_bright(plane, r + 1));
            }
            if (bright) {
                const Vec3 way = std::cos(theta_[r]) * pole_ +
                                 std::sin(theta_[r]) * Vec3(std::cos(plane_[p]) * zero_ + std::sin(plane_[p]) * side_);
                angle = std::max(angle, std::atan2(std::hypot(way[0], way[1]), -way[2]));
            }
        }
    }
    return angle;
}

double IntensityDistribution::at_plane(std::size_t plane, std::size_t row, double share) const {
    const double* const at = value_.data() + plane * theta_.size() + row;
    return at[0] + share * (at[1] - at[0]);
}

double IntensityDistribution::intensity(const Vec3& away) const {
    constexpr double rounding = 1e-12; // of an angle: the last one tabulated counts
    const double along = away.dot(pole_), u = away.dot(zero_), v = away.dot(side_);
    const double theta = std::atan2(std::hypot(u, v), along);
    if (theta < theta_.front() - rounding || theta > theta_.back() + rounding) {
        return 0.0;
    }
    const auto cell = [](const std::vector<double>& angles, double angle, double& share) {
        const auto above = std::upper_bound(angles.begin() + 1, angles.end() - 1, angle);
        share = std::clamp((angle - above[-1]) / (above[0] - above[-1]), 0.0, 1.0);
        return static_cast<std::size_t>(above - angles.begin()) - 1;
    };
    double down = 0.0, across = 0.0;
    const std::size_t row = cell(theta_, theta, down);
    if (even_) {
        return at_plane(0, row, down);
    }
    double angle = std::atan2(v, u);
    if (closed_) {
        angle += angle < plane_.front() ? 2.0 * std::numbers::pi : 0.0;
    } else if (plane_.size() < 2 || angle < plane_.front() - rounding || angle > plane_.back() + rounding) {
        return 0.0;
    }
    const std::size_t plane = cell(plane_, angle, across);
    const double here = at_plane(plane, row, down), next = at_plane(plane + 1, row, down);
    return here + across * (next - here);
}

double IntensityDistribution::flux_up_to(double theta) const {
    const std::size_t rows = theta_.size();
    const auto in_plane = [&](std::size_t plane) {
        const double* const value = value_.data() + plane * rows;
        double sum = 0.0;
        for (std::size_t r = 0; r + 1 < rows && theta_[r] < theta; ++r) {
            const double a = theta_[r], b = std::min(theta_[r + 1], theta), whole = theta_[r + 1] - a;
            const double at_b = value[r] + (value[r + 1] - value[r]) * (b - a) / whole;
            sum +=
                value[r] * std::cos(a) - at_b * std::cos(b) + (at_b - value[r]) * (std::sin(b) - std::sin(a)) / (b - a);
        }
        return sum;
    };
    if (even_) {
        return 2.0 * std::numbers::pi * in_plane(0);
    }
    double sum = 0.0;
    for (std::size_t p = 0; p + 1 < plane_.size(); ++p) {
        sum += 0.5 * (plane_[p + 1] - plane_[p]) * (in_plane(p) + in_plane(p + 1));
    }
    return sum;
}

double IntensityDistribution::flux() const {
    return flux_up_to(std::numbers::pi * 2.0);
}

double IntensityDistribution::downward_flux() const {
    return flux_up_to(0.5 * std::numbers::pi);
}

} // namespace difusa
