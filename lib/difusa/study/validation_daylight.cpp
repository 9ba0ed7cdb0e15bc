// CIE 171:2006, 5.9, 5.11, 5.13 and 5.14: a black room of 4 m by 4 m by 3 m with an unglazed opening, under general
// skies. The report's figures, of its tables B.1 to B.4, B.9 to B.14 and B.21 to B.26, after
// github.com/jjathompson4/CyclesCIEtest, engine/cie171/test_cases_daylight.py.
#include <difusa/scene/cie_sky.h>
#include <difusa/study/references/opening.h>
#include <difusa/study/validation_rooms.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <utility>

namespace difusa {

namespace {

constexpr double room_width = 4.0, room_depth = 4.0, room_height = 3.0;
const Vec3 room_size(room_width, room_depth, room_height);
constexpr double ground_radiosity = 30.0;   ///< 30 % of 100 W/m²
constexpr double underside_radiosity = 5.0; ///< of the horizontal mask: see data/VALIDATION.md
constexpr double mask_reflectance = 0.3;    ///< of the vertical one
constexpr double mask_distance = 6.0;
constexpr double mask_reach = 10.0; ///< to both sides of the room's middle: beyond what any point sees of it

/// 100 W/m² on open ground, the sun 60° high in the direction of y times `south`.
std::shared_ptr<CieSky> general_sky(int type, double south) {
    auto sky = std::make_shared<CieSky>(type, Vec3::UnitZ(), Vec3(0.0, 0.5 * south, std::sqrt(0.75)));
    sky->scale_to_irradiance(Rgb::Constant(100.0));
    sky->set_ground(Rgb::Constant(ground_radiosity * std::numbers::inv_pi));
    return sky;
}

ValidationCase daylight_case(const std::string& name, int type, std::shared_ptr<const CieSky> sky) {
    ValidationCase one;
    one.name = name + ", sky " + std::to_string(type);
    one.unit = "% of E";
    one.scene.dome = std::move(sky);
    return one;
}

/// Figures of the report for a small and a large opening under one sky.
struct OpeningFigures {
    int type;
    std::vector<double> small_wall, small_floor, large_wall, large_floor;
};

/// B.1, B.2, B.3, B.4.
const std::vector<OpeningFigures>& roof_tables() {
    static const std::vector<OpeningFigures> tables{
        {1,
         {0.46, 1.64, 2.34, 2.26, 1.88, 1.47},
         {2.33, 3.11, 3.84, 4.29, 4.29, 3.84, 3.11, 2.33},
         {37.84, 31.72, 26.85, 22.10, 17.89, 14.38},
         {31.87, 37.30, 41.27, 43.35, 43.35, 41.27, 37.30, 31.87}},
        {5,
         {1.04, 2.39, 2.59, 2.20, 1.70, 1.27},
         {1.95, 2.52, 3.04, 3.37, 3.37, 3.04, 2.52, 1.95},
         {46.74, 36.05, 28.05, 21.67, 16.73, 12.98},
         {26.80, 30.95, 33.99, 35.58, 35.58, 33.99, 30.95, 26.80}},
        {12,
         {1.74, 3.76, 4.55, 4.61, 4.24, 3.63},
         {5.72, 6.01, 5.12, 3.97, 2.90, 2.03, 1.40, 0.96},
         {66.34, 54.33, 44.25, 36.10, 29.48, 24.25},
         {42.33, 43.82, 43.54, 40.85, 35.92, 29.17, 22.62, 16.79}},
    };
    return tables;
}

/// A ceiling with a square opening in its middle, from the share `low` of its width on.
void add_ceiling_around(Scene& scene, double low) {
    const RoomSide ceiling = room_side(room_size, RoomFace::ceiling);
    add_rectangle_around(scene, ceiling.name, ceiling.a, ceiling.u, ceiling.v, {low, 1.0 - low, low, 1.0 - low});
}

/// The measured wall, y = 0, faces the sun: the figures rise with its light.
ValidationCase roof_opening(int type, bool large, const std::vector<double>& wall, const std::vector<double>& floor) {
    const auto sky = general_sky(type, 1.0);
    const double side = large ? 4.0 : 1.0;
    ValidationCase one = daylight_case(large ? "5.9 roof 4x4" : "5.9 roof 1x1", type, sky);
    add_sides(one.scene, room_size,
              {RoomFace::floor, RoomFace::y_high, RoomFace::x_low, RoomFace::x_high, RoomFace::y_low});
    const double low = 0.5 * (room_width - side) / room_width;
    add_ceiling_around(one.scene, low);
    one.exact = [=](const Vec3& x, const Vec3& n) {
        return irradiance_through({{low * room_width, low * room_depth, room_height}, {side, 0, 0}, {0, side, 0}}, x, n,
                                  [&](const Vec3& towards) { return sky->radiance(towards)[0]; });
    };
    add_points(one, letters('A', 6), {2, 0, 2.75}, {0, 0, -0.5}, Vec3::UnitY(), wall);
    add_points(one, letters('G', 8), {2, 0.25, 0}, {0, 0.5, 0}, Vec3::UnitZ(), floor);
    fill_exact(one);
    return one;
}

/// A window in the wall y = 0, with what is outside.
struct Facade {
    double width = 2.0, sill = 1.0, height = 1.0;
    double overhang = 0.0;    ///< depth of the horizontal mask at the room's height; 0: none
    double mask_height = 0.0; ///< of the vertical mask; 0: none
    double mask_radiosity = 0.0;
    std::shared_ptr<const CieSky> sky;

    /// What is seen from x inside through the window's points at the height z: the lines between sky, ground and masks
    /// are level, as the masks are as good as endless.
    double radiance(const Vec3& x, double z, const Vec3& towards) const {
        const double slope = (z - x.z()) / x.y(); // rise per distance from the facade
        if (overhang > 0.0 && slope > 0.0) {
            const double beyond = (room_height - x.z()) / slope - x.y();
            if (beyond > 0.0 && beyond < overhang) {
                return underside_radiosity * std::numbers::inv_pi;
            }
        }
        if (mask_height > 0.0) {
            const double met = x.z() + slope * (x.y() + mask_distance);
            if (met > 0.0 && met < mask_height) {
                return mask_radiosity * std::numbers::inv_pi;
            }
        }
        return sky->radiance(towards)[0];
    }

    double irradiance(const Vec3& x, const Vec3& n) const {
        std::vector<double> cuts{sill, sill + height, x.z()};
        if (overhang > 0.0) {
            cuts.push_back(x.z() + (room_height - x.z()) * x.y() / (x.y() + overhang));
        }
        if (mask_height > 0.0) {
            for (const double end : {0.0, mask_height}) {
                cuts.push_back(x.z() + (end - x.z()) * x.y() / (x.y() + mask_distance));
            }
        }
        std::sort(cuts.begin(), cuts.end());
        double sum = 0.0;
        for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
            const double low = std::max(cuts[k], sill), high = std::min(cuts[k + 1], sill + height);
            if (high > low) {
                const double middle = 0.5 * (low + high);
                sum += irradiance_through({{0.5 * (room_width - width), 0, low}, {width, 0, 0}, {0, 0, high - low}}, x,
                                          n, [&](const Vec3& towards) { return radiance(x, middle, towards); });
            }
        }
        return sum;
    }
};

/// The room with that window; the sun is in front of it.
ValidationCase facade_case(const std::string& name, int type, const Facade& facade) {
    ValidationCase one = daylight_case(name, type, facade.sky);
    add_sides(one.scene, room_size,
              {RoomFace::floor, RoomFace::y_high, RoomFace::x_low, RoomFace::x_high, RoomFace::ceiling});
    const double left = 0.5 * (room_width - facade.width) / room_width;
    add_rectangle_around(one.scene, "facade", Vec3::Zero(), {0, 0, room_height}, {room_width, 0, 0},
                         {facade.sill / room_height, (facade.sill + facade.height) / room_height, left, 1.0 - left});
    const double start = 0.5 * room_width - mask_reach;
    if (facade.overhang > 0.0) { // its underside; from above it blocks the light
        add_rectangle(one.scene, "horizontal mask", {start, -facade.overhang, room_height}, {0, facade.overhang, 0},
                      {2.0 * mask_reach, 0, 0}, 0.0, underside_radiosity);
    }
    if (facade.mask_height > 0.0) {
        add_rectangle(one.scene, "vertical mask", {start, -mask_distance, 0}, {0, 0, facade.mask_height},
                      {2.0 * mask_reach, 0, 0}, 0.0, facade.mask_radiosity);
    }
    one.exact = [facade](const Vec3& x, const Vec3& n) { return facade.irradiance(x, n); };
    return one;
}

/// B.9, B.10, B.12, B.13.
const std::vector<OpeningFigures>& facade_tables() {
    static const std::vector<OpeningFigures> tables{
        {1,
         {0.95, 1.06, 1.25, 1.51, 1.70, 1.86},
         {0.87, 1.31, 2.02, 3.20, 5.07, 7.64, 9.33, 5.09},
         {5.25, 6.11, 6.98, 7.99, 8.77, 9.35},
         {4.27, 5.92, 8.33, 11.82, 16.84, 23.83, 33.05, 44.06}},
        {5,
         {0.95, 1.06, 1.79, 3.09, 3.54, 3.17},
         {1.27, 1.75, 2.49, 3.59, 5.19, 7.11, 7.99, 4.13},
         {6.43, 8.96, 11.11, 13.47, 14.57, 15.17},
         {5.79, 7.63, 10.20, 13.78, 18.76, 25.50, 34.24, 45.29}},
        {12,
         {0.95, 1.06, 2.39, 4.93, 5.80, 5.01},
         {2.00, 2.80, 4.06, 6.13, 9.54, 14.57, 16.35, 5.03},
         {7.63, 12.15, 15.80, 19.96, 22.13, 23.68},
         {9.26, 12.35, 16.79, 23.17, 32.10, 43.03, 54.44, 65.07}},
    };
    return tables;
}

ValidationCase open_facade(int type, bool large, const std::vector<double>& wall, const std::vector<double>& floor) {
    Facade facade;
    facade.sky = general_sky(type, -1.0);
    if (large) {
        facade.width = room_width;
        facade.sill = 0.0;
        facade.height = room_height;
    }
    ValidationCase one = facade_case(large ? "5.11 facade 4x3" : "5.11 facade 2x1", type, facade);
    add_points(one, letters('A', 6), {2, room_depth, 2.75}, {0, 0, -0.5}, -Vec3::UnitY(), wall);
    add_points(one, letters('G', 8), {2, 3.75, 0}, {0, -0.5, 0}, Vec3::UnitZ(), floor);
    // B.11 and B.14: of every sky, as only the ground is seen.
    add_points(one, letters('G', 8, "'"), {2, 3.75, room_height}, {0, -0.5, 0}, -Vec3::UnitZ(),
               large ? std::vector<double>{1.74, 2.29, 3.06, 4.14, 5.63, 7.65, 10.27, 13.59}
                     : std::vector<double>{0.38, 0.53, 0.75, 1.08, 1.56, 2.14, 2.40, 1.24});
    fill_exact(one);
    return one;
}

struct MaskFigures {
    int type;
    double size; ///< depth or height, m
    std::vector<double> floor;
    std::string doubtful; ///< letters
};

/// B.21 to B.23. Of the mask of 1 m under sky 1 the report has E and F as without a mask.
const std::vector<MaskFigures>& overhang_tables() {
    static const std::vector<MaskFigures> tables{
        {1, 0.5, {0.87, 1.31, 2.02, 3.20, 5.07, 7.64, 8.27, 0.21}, ""},
        {5, 0.5, {1.27, 1.75, 2.49, 3.59, 5.19, 7.11, 7.13, 0.21}, ""},
        {12, 0.5, {2.00, 2.80, 4.06, 6.13, 9.54, 14.57, 14.68, 0.21}, ""},
        {1, 1.0, {0.87, 1.31, 2.02, 3.20, 5.07, 7.64, 5.69, 0.21}, "EFG"},
        {5, 1.0, {1.27, 1.75, 2.49, 3.59, 4.82, 5.42, 3.63, 0.21}, ""},
        {12, 1.0, {2.00, 2.80, 4.06, 6.13, 8.73, 10.46, 7.25, 0.21}, ""},
        {1, 2.0, {0.83, 1.09, 1.44, 1.88, 2.22, 1.72, 0.40, 0.21}, ""},
        {5, 2.0, {1.21, 1.50, 1.86, 2.24, 2.44, 1.73, 0.40, 0.21}, ""},
        {12, 2.0, {1.90, 2.36, 2.94, 3.58, 3.97, 2.82, 0.40, 0.21}, ""},
    };
    return tables;
}

/// B.24 to B.26. With 6 m and 9 m the window shows A and B nothing but the mask, and yet the figures differ by a factor
/// of two: all that see these masks are doubtful.
const std::vector<MaskFigures>& fence_tables() {
    static const std::vector<MaskFigures> tables{
        {1, 3.0, {0.82, 1.28, 2.02, 3.20, 5.07, 7.64, 9.33, 5.09}, ""},
        {5, 3.0, {1.15, 1.70, 2.49, 3.59, 5.19, 7.11, 7.99, 4.13}, ""},
        {12, 3.0, {1.78, 2.69, 4.06, 6.13, 9.54, 14.57, 16.35, 5.03}, ""},
        {1, 6.0, {0.41, 0.47, 0.79, 1.79, 3.725, 7.40, 9.33, 5.09}, "ABCDEF"},
        {5, 6.0, {0.51, 0.59, 0.95, 1.96, 3.751, 6.89, 7.99, 4.13}, "ABCDEF"},
        {12, 6.0, {0.38, 0.44, 0.99, 2.84, 6.611, 14.07, 16.35, 5.03}, "ABCDEF"},
        {1, 9.0, {0.77, 0.90, 1.04, 1.19, 1.27, 3.97, 9.33, 5.09}, "ABCDEF"},
        {5, 9.0, {0.97, 1.12, 1.30, 1.48, 1.59, 3.90, 7.99, 4.13}, "ABCDEF"},
        {12, 9.0, {0.72, 0.84, 0.97, 1.10, 1.19, 1.02, 16.35, 5.03}, "ABCDEF"},
    };
    return tables;
}

ValidationCase masked_facade(const MaskFigures& figures, bool horizontal) {
    Facade facade;
    facade.sky = general_sky(figures.type, -1.0);
    char name[48];
    if (horizontal) {
        facade.overhang = figures.size;
        std::snprintf(name, sizeof name, "5.13 horizontal mask %.1f", figures.size);
    } else {
        facade.mask_height = figures.size;
        const double lit =
            vertical_irradiance(Vec3::UnitY(), [&](const Vec3& towards) { return facade.sky->radiance(towards)[0]; });
        facade.mask_radiosity = mask_reflectance * (lit + 0.5 * ground_radiosity);
        std::snprintf(name, sizeof name, "5.14 vertical mask %.0f", figures.size);
    }
    ValidationCase one = facade_case(name, figures.type, facade);
    add_points(one, letters('A', 8), {2, 3.75, 0}, {0, -0.5, 0}, Vec3::UnitZ(), figures.floor);
    for (ValidationReading& reading : one.readings) {
        reading.doubtful = figures.doubtful.find(reading.name) != std::string::npos;
    }
    fill_exact(one);
    return one;
}

/// 5.4 with daylight: what enters through an opening of 1 m² in the roof arrives on the floor and the walls.
ValidationCase daylight_conservation() {
    const auto sky = general_sky(12, 1.0);
    ValidationCase one = daylight_case("5.4 flux of daylight", 12, sky);
    one.unit = "W";
    add_sides(one.scene, room_size,
              {RoomFace::floor, RoomFace::y_high, RoomFace::x_low, RoomFace::x_high, RoomFace::y_low});
    add_ceiling_around(one.scene, 0.375);
    one.readings.push_back({"sum", {}, {}, 100.0, {}});
    add_side_nodes(one, room_size,
                   {RoomFace::floor, RoomFace::y_low, RoomFace::y_high, RoomFace::x_low, RoomFace::x_high}, 20, 1.0);
    return one;
}

} // namespace

std::vector<ValidationCase> cie_171_daylight() {
    std::vector<ValidationCase> all{daylight_conservation()};
    const auto add_openings = [&](const std::vector<OpeningFigures>& tables, const auto& make) {
        for (const bool large : {false, true}) {
            for (const OpeningFigures& figures : tables) {
                all.push_back(make(figures.type, large, large ? figures.large_wall : figures.small_wall,
                                   large ? figures.large_floor : figures.small_floor));
            }
        }
    };
    add_openings(roof_tables(), roof_opening);
    add_openings(facade_tables(), open_facade);
    for (const MaskFigures& figures : overhang_tables()) {
        all.push_back(masked_facade(figures, true));
    }
    for (const MaskFigures& figures : fence_tables()) {
        all.push_back(masked_facade(figures, false));
    }
    return all;
}

} // namespace difusa
