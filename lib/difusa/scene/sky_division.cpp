#include <difusa/scene/sky_division.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

namespace difusa {

namespace {

constexpr std::array<int, 7> parts_of_bands{30, 30, 24, 24, 18, 12, 6};
constexpr double quarter_turn = 0.5 * std::numbers::pi, whole_turn = 2.0 * std::numbers::pi;

/// Row i and column j of a cell cut into rows and columns of equal solid angle.
SkyCell cut_cell(const SkyCell& cell, int rows, int columns, int i, int j) {
    const double low = std::sin(cell.low), step = (std::sin(cell.high) - low) / rows;
    const double width = (cell.to - cell.from) / columns;
    SkyCell piece = cell;
    piece.low = i == 0 ? cell.low : std::asin(std::clamp(low + i * step, -1.0, 1.0));
    piece.high = i + 1 == rows ? cell.high : std::asin(std::clamp(low + (i + 1) * step, -1.0, 1.0));
    piece.from = cell.from + j * width;
    piece.to = j + 1 == columns ? cell.to : cell.from + (j + 1) * width;
    return piece;
}

} // namespace

double SkyCell::solid_angle() const {
    return (to - from) * (std::sin(high) - std::sin(low));
}

SkyDivision::SkyDivision(int factor, const Vec3& up, const Vec3& north) : factor_(factor), up_(up) {
    if (factor < 1 || factor > most) {
        throw UsageError("a sky is divided by a factor from 1 (Tregenza's 145 parts) to " + std::to_string(most));
    }
    const Vec3 level = north - north.dot(up) * up;
    if (!(level.norm() > 1e-6 * north.norm())) {
        throw UsageError("--north: must not be vertical");
    }
    north_ = level.normalized();
    east_ = north_.cross(up_);
    const int rows = factor * static_cast<int>(parts_of_bands.size());
    height_ = quarter_turn / (rows + 0.5);
    cells_.push_back({0, -quarter_turn, 0.0, 0.0, whole_turn});
    for (int row = 0; row < rows; ++row) {
        const int columns = parts_of_bands[static_cast<std::size_t>(row / factor)] * factor;
        first_.push_back(count());
        for (int j = 0; j < columns; ++j) {
            cells_.push_back({count(), row * height_, (row + 1) * height_, (j - 0.5) * whole_turn / columns,
                              (j + 0.5) * whole_turn / columns});
        }
    }
    first_.push_back(count());
    cells_.push_back({count(), rows * height_, quarter_turn, 0.0, whole_turn});
}

Vec3 SkyDivision::along(double elevation, double azimuth) const {
    return std::sin(elevation) * up_ + std::cos(elevation) * (std::sin(azimuth) * east_ + std::cos(azimuth) * north_);
}

Index SkyDivision::at(const Vec3& towards) const {
    const double sine = std::clamp(towards.dot(up_), -1.0, 1.0);
    if (sine < 0.0) {
        return 0;
    }
    const auto row = std::min(static_cast<std::size_t>(std::asin(sine) / height_), first_.size() - 1);
    if (row + 1 == first_.size()) {
        return first_.back();
    }
    const auto columns = static_cast<int>(first_[row + 1] - first_[row]);
    const double turn = std::atan2(towards.dot(east_), towards.dot(north_)) / whole_turn;
    const int column = static_cast<int>(std::floor(turn * columns + 0.5));
    return first_[row] + static_cast<Index>((column + columns) % columns);
}

Vec3 SkyDivision::centre(Index part) const {
    if (part == 0) {
        return -up_;
    }
    const SkyCell& whole = cells_[part];
    return part == first_.back() ? up_ : along(0.5 * (whole.low + whole.high), 0.5 * (whole.from + whole.to));
}

Vec3 SkyDivision::direction(const SkyCell& cell, double u, double v) const {
    const double sine = (1.0 - u) * std::sin(cell.low) + u * std::sin(cell.high);
    const double azimuth = (1.0 - v) * cell.from + v * cell.to;
    return sine * up_ +
           std::sqrt(std::max(0.0, 1.0 - sine * sine)) * (std::sin(azimuth) * east_ + std::cos(azimuth) * north_);
}

Vec3 SkyDivision::moment(const SkyCell& cell) const {
    const double low = std::sin(cell.low), high = std::sin(cell.high);
    const double level = 0.5 * (cell.high - cell.low + high * std::cos(cell.high) - low * std::cos(cell.low));
    return level * ((std::cos(cell.from) - std::cos(cell.to)) * east_ +
                    (std::sin(cell.to) - std::sin(cell.from)) * north_) +
           0.5 * (high * high - low * low) * (cell.to - cell.from) * up_;
}

bool SkyDivision::is_above(const SkyCell& cell, const Vec3& n) const {
    // Along a meridian and along a parallel, n.w is a sinusoid: where it is least is known.
    constexpr double rounding = -1e-12;
    const auto corners_are_above = [&](double azimuth) {
        return n.dot(along(cell.low, azimuth)) >= rounding && n.dot(along(cell.high, azimuth)) >= rounding;
    };
    if (!corners_are_above(cell.from) || !corners_are_above(cell.to)) {
        return false;
    }
    const double away = std::atan2(-n.dot(east_), -n.dot(north_)); // from the azimuth of n
    const double turns = std::ceil((cell.from - away) / whole_turn);
    const double first = away + turns * whole_turn;
    return first > cell.to || corners_are_above(first);
}

std::vector<SkyCell> SkyDivision::cells(std::size_t each) const {
    const int rows = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(each))));
    const int columns = std::max(1, static_cast<int>(each) / rows);
    std::vector<SkyCell> all;
    for (Index part = 1; part < count(); ++part) {
        for (int i = 0; i < rows; ++i) {
            for (int j = 0; j < columns; ++j) {
                all.push_back(cut_cell(cells_[part], rows, columns, i, j));
            }
        }
    }
    const std::size_t above = all.size();
    for (std::size_t k = 0; k < above; ++k) {
        SkyCell below = all[k];
        below.part = 0;
        below.low = -all[k].high;
        below.high = -all[k].low;
        all.push_back(below);
    }
    return all;
}

Values SkyDivision::mean_radiances(const SkyDome& sky) const {
    Values mean = Values::Zero(static_cast<Eigen::Index>(count()), 3);
    for (Index part = 0; part < count(); ++part) {
        const int across = part == 0 ? 64 : 8;
        Rgb sum = Rgb::Zero();
        for (int k = 0; k < across * across; ++k) {
            const double u = (k / across + 0.5) / across, v = (k % across + 0.5) / across; // NOLINT: whole rows
            sum += sky.radiance(direction(cells_[part], u, v));
        }
        mean.row(static_cast<Eigen::Index>(part)) = (sum / (across * across)).matrix().transpose();
    }
    return mean;
}

Eigen::RowVectorXd SkyDivision::level_irradiance(const Values& radiance) const {
    DIFUSA_REQUIRE(radiance.rows() == static_cast<Eigen::Index>(count()));
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(radiance.cols());
    for (Index part = 1; part < count(); ++part) {
        sum += moment(cells_[part]).dot(up_) * radiance.row(static_cast<Eigen::Index>(part));
    }
    return sum;
}

} // namespace difusa
