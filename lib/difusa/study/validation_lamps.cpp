// CIE 171:2006, 5.2 to 5.8: lamps, reflection, obstructions. The report's figures:
// github.com/jjathompson4/CyclesCIEtest, engine/cie171/test_cases.py, from tables 11, 12, 17, 20, and for 5.7 those
// with which the validation of Iray (Dau Design and Consulting, 2016) replaces the erroneous table 19.
#include <difusa/core/photometry.h>
#include <difusa/study/references/opening.h>
#include <difusa/study/validation_rooms.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

namespace difusa {

namespace {

constexpr double pi_of_lamps = std::numbers::pi;

ValidationCase lux_case(const std::string& name) {
    ValidationCase one;
    one.name = name;
    one.unit = "lx";
    one.unit_of_watts = lumens_per_watt;
    return one;
}

PointLight point_light(const Vec3& position, double candela) {
    PointLight light;
    light.position = position;
    light.intensity = Rgb::Constant(candela / lumens_per_watt);
    return light;
}

constexpr std::initializer_list<RoomFace> all_sides{RoomFace::floor,  RoomFace::ceiling, RoomFace::y_low,
                                                    RoomFace::y_high, RoomFace::x_low,   RoomFace::x_high};

/// 5.2, diffuse: I = 1000 cd cos(gamma), 3 m above the middle of a black square of 4 m.
ValidationCase point_source() {
    ValidationCase one = lux_case("5.2 point source");
    const Vec3 lamp(0.0, 0.0, 3.0);
    const double candela = 1000.0;
    IntensityDistribution::Table table; // every quarter of a degree: linear between, within 3e-6 of the cosine
    table.plane = {0.0};
    for (int k = 0; k <= 360; ++k) {
        table.in_plane.push_back(0.25 * k);
        table.value.push_back(std::max(0.0, candela * std::cos(k * pi_of_lamps / 720.0)));
    }
    PointLight light = point_light(lamp, candela);
    light.distribution = std::make_shared<IntensityDistribution>(std::move(table));
    light.c90 = -light.direction.cross(light.c0);
    one.scene.point_lights = {light};
    add_rectangle(one.scene, "surface", {-2, -2, 0}, {4, 0, 0}, {0, 4, 0});
    one.exact = [=](const Vec3& x, const Vec3& n) {
        const Vec3 way = lamp - x;
        return candela * (way.z() / way.norm()) * n.dot(way.normalized()) / way.squaredNorm();
    };
    const std::array<std::array<double, 2>, 10> at{
        {{0, 0}, {0.5, 0}, {1, 0}, {1.5, 0}, {0.5, 0.5}, {1, 0.5}, {1.5, 0.5}, {1, 1}, {1.5, 1}, {1.5, 1.5}}};
    const std::array<double, 10> table_11{111.11, 105.21, 90.02, 71.11, 99.73, 85.64, 68.06, 74.36, 59.98, 49.39};
    const std::vector<std::string> names = letters('A', at.size());
    for (std::size_t k = 0; k < at.size(); ++k) {
        add_points(one, {names[k]}, {at[k][0], at[k][1], 0.0}, Vec3::Zero(), Vec3::UnitZ(), {table_11[k]});
    }
    fill_exact(one);
    return one;
}

/// 5.3, diffuse: a source of 1 m² and 1000 cd in the middle of the ceiling of a black room of 4 m by 4 m by 3 m.
ValidationCase area_source() {
    ValidationCase one = lux_case("5.3 area source");
    const double radiance = 1000.0 / lumens_per_watt; // of 1 m²
    Scene& scene = one.scene;
    const Vec3 size(4, 4, 3);
    const RoomSide ceiling = room_side(size, RoomFace::ceiling);
    add_sides(scene, size, {RoomFace::floor});
    add_rectangle_around(scene, ceiling.name, ceiling.a, ceiling.u, ceiling.v, {0.375, 0.625, 0.375, 0.625});
    add_rectangle(scene, "source", {1.5, 1.5, 3}, {0, 1, 0}, {1, 0, 0}, 0.0, pi_of_lamps * radiance);
    add_sides(scene, size, {RoomFace::y_low, RoomFace::y_high, RoomFace::x_low, RoomFace::x_high});
    one.exact = [=](const Vec3& at, const Vec3& n) {
        return lumens_per_watt * irradiance_through({{1.5, 1.5, 3}, {1, 0, 0}, {0, 1, 0}}, at, n,
                                                    [&](const Vec3& /*towards*/) { return radiance; });
    };
    add_points(one, letters('A', 6), {2, 0, 2.75}, {0, 0, -0.5}, Vec3::UnitY(),
               {32.68, 75.09, 81.38, 69.12, 53.41, 39.90});
    add_points(one, letters('G', 8), {2, 0.25, 0}, {0, 0.5, 0}, Vec3::UnitZ(),
               {61.27, 79.18, 95.52, 105.89, 105.89, 95.52, 79.18, 61.27});
    fill_exact(one);
    return one;
}

/// 5.4: all that a lamp of 10000 lm emits arrives on the walls.
ValidationCase conservation() {
    ValidationCase one = lux_case("5.4 flux of a lamp");
    one.unit = "lm";
    const Vec3 size(4, 4, 3);
    add_sides(one.scene, size, all_sides);
    one.scene.point_lights = {point_light(0.5 * size, 10000.0 / (4.0 * pi_of_lamps))};
    one.readings.push_back({"sum", {}, {}, 10000.0, 10000.0});
    add_side_nodes(one, size, all_sides, 16, 1.0);
    return one;
}

/// 5.6: a square of 4 m and reflectance 0.3 on the ground, 100 lx on it from a sun that no other surface sees; a wall
/// from 0.5 m up along one side, and a ceiling 3 m above.
ValidationCase reflection() {
    ValidationCase one;
    one.name = "5.6 reflection";
    one.unit = "% of rho E";
    one.indirect = true;
    const double rho = 0.3, elevation = pi_of_lamps / 6.0;
    one.unit_of_watts = 100.0 / rho; // for 1 W/m² on the ground
    Sun sun;
    sun.towards = {0.0, std::cos(elevation), std::sin(elevation)};
    sun.irradiance = Rgb::Constant(1.0 / std::sin(elevation));
    one.scene.suns = {sun};
    add_rectangle(one.scene, "S2", Vec3::Zero(), {4, 0, 0}, {0, 4, 0}, rho);
    add_rectangle(one.scene, "S1-v", {0, 0, 0.5}, {0, 0, 2.5}, {4, 0, 0});
    add_rectangle(one.scene, "S1-hz", {0, 0, 3}, {0, 4, 0}, {4, 0, 0});
    one.exact = [](const Vec3& x, const Vec3& n) {
        return irradiance_through({Vec3::Zero(), {4, 0, 0}, {0, 4, 0}}, x, n,
                                  [](const Vec3& /*towards*/) { return 100.0 / pi_of_lamps; });
    };
    add_points(one, letters('B', 5), {2, 0, 0.75}, {0, 0, 0.5}, Vec3::UnitY(),
               {35.901, 27.992, 21.639, 16.716, 12.967});
    add_points(one, letters('G', 8), {2, 0.25, 3}, {0, 0.5, 0}, -Vec3::UnitZ(),
               {26.80, 30.94, 33.98, 35.57, 35.57, 33.98, 30.94, 26.80});
    fill_exact(one);
    return one;
}

/// 5.7: a wall of reflectance 0.6 at y = 4, lit by a sun 60° high, behind a black block as wide as the room, 1 m high.
ValidationCase obstruction() {
    ValidationCase one;
    one.name = "5.7 internal obstruction";
    one.unit = "% of rho E";
    one.indirect = true;
    const double rho = 0.6;
    one.unit_of_watts = 100.0 / rho;
    Sun sun;
    sun.towards = {0.0, -0.5, std::sqrt(0.75)};
    sun.irradiance = Rgb::Constant(2.0);
    one.scene.suns = {sun};
    add_rectangle(one.scene, "S2", {0, 4, 0}, {4, 0, 0}, {0, 0, 3}, rho);
    add_rectangle(one.scene, "S1-v", Vec3::Zero(), {0, 0, 3}, {4, 0, 0});
    add_rectangle(one.scene, "S1-hz", Vec3::Zero(), {4, 0, 0}, {0, 2.5, 0});
    add_rectangle(one.scene, "block, y low", {0, 2.5, 0}, {4, 0, 0}, {0, 0, 1});
    add_rectangle(one.scene, "block, y high", {0, 2.7, 0}, {0, 0, 1}, {4, 0, 0});
    add_rectangle(one.scene, "block, top", {0, 2.5, 1}, {4, 0, 0}, {0, 0.2, 0});
    add_rectangle(one.scene, "block, x low", {0, 2.5, 0}, {0, 0, 1}, {0, 0.2, 0});
    add_rectangle(one.scene, "block, x high", {4, 2.5, 0}, {0, 0.2, 0}, {0, 0, 1});
    one.exact = [](const Vec3& x, const Vec3& n) {
        // The block hides what is below the higher one of the lines of sight over its upper edges.
        double low = 0.0;
        for (const double edge : {2.5, 2.7}) {
            low = std::max(low, x.z() + (1.0 - x.z()) * (4.0 - x.y()) / (edge - x.y()));
        }
        return low >= 3.0 ? 0.0
                          : irradiance_through({{0, 4, low}, {4, 0, 0}, {0, 0, 3.0 - low}}, x, n,
                                               [](const Vec3& /*towards*/) { return 100.0 / pi_of_lamps; });
    };
    add_points(one, letters('A', 6), {2, 0, 2.75}, {0, 0, -0.5}, Vec3::UnitY(),
               {16.07, 16.33, 15.40, 13.32, 10.32, 7.08});
    add_points(one, letters('G', 5), {2, 0.25, 0}, {0, 0.5, 0}, Vec3::UnitZ(), {3.38, 3.63, 3.01, 0.0, 0.0});
    fill_exact(one);
    return one;
}

/// 5.8: the mean indirect illuminance of a cube of 4 m around a lamp of 10000 lm, rho Phi / (S (1 - rho)).
ValidationCase interreflection(double rho, double published) {
    char name[40];
    std::snprintf(name, sizeof name, "5.8 closed cube, rho %g", rho);
    ValidationCase one = lux_case(name);
    one.indirect = true;
    const Vec3 size(4, 4, 4);
    const double flux = 10000.0, surface = 96.0;
    add_sides(one.scene, size, all_sides, rho);
    one.scene.point_lights = {point_light(0.5 * size, flux / (4.0 * pi_of_lamps))};
    one.readings.push_back({"mean", {}, {}, rho * flux / (surface * (1.0 - rho)), published});
    add_side_nodes(one, size, all_sides, 8, 1.0 / surface);
    return one;
}

} // namespace

std::vector<ValidationCase> cie_171_lamps() {
    std::vector<ValidationCase> all{point_source(), area_source(), conservation(), reflection(), obstruction()};
    const std::array<std::array<double, 2>, 6> table_20{
        {{0.1, 11.6}, {0.3, 44.6}, {0.5, 104.0}, {0.7, 243.0}, {0.9, 937.0}, {0.95, 1979.0}}};
    for (const auto& [rho, published] : table_20) {
        all.push_back(interreflection(rho, published));
    }
    return all;
}

} // namespace difusa
