// Luminaires: photometric files, their flux, and their light.
#include <difusa/core/error.h>
#include <difusa/core/photometry.h>
#include <difusa/import/luminaire_file.h>
#include <difusa/scene/lights.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "scene_file_fixture.h"

namespace difusa::luminaires_test {
namespace {

using test::SceneFile;
using testing::HasSubstr;

constexpr double pi = std::numbers::pi;

Vec3 away(double gamma, double c) {
    const double g = gamma * pi / 180.0, a = c * pi / 180.0;
    return {std::sin(g) * std::cos(a), std::sin(g) * std::sin(a), -std::cos(g)};
}

/// The integral by the midpoint rule over gamma and C: a naive twin.
double flux_by_points(const IntensityDistribution& of) {
    constexpr int n = 400;
    double sum = 0.0;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < 2 * n; ++j) {
            const double gamma = (i + 0.5) * 180.0 / n;
            sum += of.intensity(away(gamma, (j + 0.5) * 180.0 / n)) * std::sin(gamma * pi / 180.0);
        }
    }
    return sum * (pi / n) * (pi / n);
}

const std::string ies_head = "IESNA:LM-63-2002\n[TEST] none\n[MANUFAC] none\n";

TEST(Ies, OneIntensityInAllDirectionsHasFourPiTimesItsFlux) {
    const Luminaire sphere =
        parse_ies(ies_head + "TILT=NONE\n1 -1 2 3 1 1 2 0.2 0.4 0\n0.5 7 20\n0 90 180\n0\n10 10 10\n", "a.ies");
    EXPECT_NEAR(sphere.distribution->flux(), 40.0 * pi, 1e-12); // multiplier 2, ballast 0.5; 7 is for future use
    EXPECT_NEAR(sphere.distribution->downward_flux(), 20.0 * pi, 1e-12);
    EXPECT_EQ(sphere.distribution->intensity(away(33, 77)), 10.0);
    EXPECT_EQ(sphere.width, 0.2);
    EXPECT_EQ(sphere.length, 0.4);
    EXPECT_FALSE(sphere.is_round);
}

TEST(Ies, TheFluxIsThatOfTheInterpolant) {
    // 100 at the nadir, linear to 0 at 90 degrees: 2 pi times 100 (1 - 2 / pi).
    const Luminaire cone =
        parse_ies(ies_head + "TILT=NONE\n1 1000 1 2 1 1 1 -1 0 0\n1 1 20\n0 90\n0\n100 0\n", "a.ies");
    EXPECT_NEAR(cone.distribution->flux(), 200.0 * pi * (1.0 - 2.0 / pi), 1e-11);
    EXPECT_NEAR(cone.distribution->intensity(away(22.5, 0)), 75.0, 1e-12);
    EXPECT_EQ(cone.distribution->intensity(away(91, 0)), 0.0);
    EXPECT_TRUE(cone.is_round);
    EXPECT_NEAR(cone.length, 0.3048, 1e-15); // a foot
}

TEST(IntensityDistribution, TheBeamEndsWhereCellsAreDimmerThanATenth) {
    using Table = IntensityDistribution::Table;
    EXPECT_DOUBLE_EQ(
        IntensityDistribution(Table{PhotometryType::C, {0}, {0, 2, 3, 90}, {100, 100, 1, 0}}).beyond_beam(),
        3.0 * pi / 180.0);
    EXPECT_DOUBLE_EQ(IntensityDistribution(Table{PhotometryType::C, {0}, {0, 90, 180}, {1, 1, 1}}).beyond_beam(), pi);
    // A floodlight: the cells around its axis, to their far corner.
    const Table flood{
        PhotometryType::B, {-10, -1, 1, 10}, {-10, -1, 1, 10}, {0, 0, 0, 0, 0, 5, 5, 0, 0, 5, 5, 0, 0, 0, 0, 0}};
    const double cosine = std::pow(std::cos(10.0 * pi / 180.0), 2);
    EXPECT_NEAR(IntensityDistribution(flood).beyond_beam(), std::acos(cosine), 1e-12);
}

TEST(Ies, SymmetricPlanesStandForAll) {
    const auto of = [](const std::string& planes, const std::string& values) {
        return parse_ies(ies_head + "TILT=NONE\n1 -1 1 2 " + planes + values, "a.ies").distribution;
    };
    const auto quarter = of("2 1 2 0 0 0\n1 1 0\n0 90\n0 90\n", "5 1\n5 3\n");
    const auto half = of("3 1 2 0 0 0\n1 1 0\n0 90\n0 90 180\n", "5 1\n5 3\n5 1\n");
    const auto whole = of("5 1 2 0 0 0\n1 1 0\n0 90\n0 90 180 270 360\n", "5 1\n5 3\n5 1\n5 3\n5 1\n");
    const auto open = of("4 1 2 0 0 0\n1 1 0\n0 90\n0 90 180 270\n", "5 1\n5 3\n5 1\n5 3\n");
    const auto across = of("3 1 2 0 0 0\n1 1 0\n0 90\n90 180 270\n", "5 3\n5 1\n5 3\n");
    for (const double c : {0.0, 30.0, 100.0, 200.0, 300.0, 359.0}) {
        const double known = whole->intensity(away(70, c));
        for (const auto& other : {quarter, half, open, across}) {
            EXPECT_NEAR(other->intensity(away(70, c)), known, 1e-12) << c;
            EXPECT_NEAR(other->flux(), whole->flux(), 1e-12);
        }
    }
    EXPECT_NEAR(whole->intensity(away(90, 45)), 2.0, 1e-12);
    // Symmetric about one plane only: 4 in C90, 3 in C270, or 4 in C180, 1 in C0.
    const auto about_90 = of("3 1 2 0 0 0\n1 1 0\n0 90\n90 180 270\n", "5 4\n5 1\n5 3\n");
    const auto about_0 = of("3 1 2 0 0 0\n1 1 0\n0 90\n0 90 180\n", "5 1\n5 3\n5 4\n");
    EXPECT_NEAR(about_90->intensity(away(90, 90)), 4.0, 1e-12);
    EXPECT_NEAR(about_90->intensity(away(90, 270)), 3.0, 1e-12);
    EXPECT_NEAR(about_90->intensity(away(90, 45)), 2.5, 1e-12);
    EXPECT_NEAR(about_90->intensity(away(90, 315)), 2.0, 1e-12);
    EXPECT_NEAR(about_0->intensity(away(90, 0)), 1.0, 1e-12);
    EXPECT_NEAR(about_0->intensity(away(90, 180)), 4.0, 1e-12);
    EXPECT_NEAR(about_0->intensity(away(90, 225)), 3.5, 1e-12);
    EXPECT_NEAR(about_0->intensity(away(90, 315)), 2.0, 1e-12);
    EXPECT_NEAR(flux_by_points(*whole), whole->flux(), 1e-4 * whole->flux());
}

TEST(Ies, TypesAAndBAreEvaluatedInTheirOwnAngles) {
    const std::string table = " 3 3 ";
    const std::string rest = "2 0 0 0\n1 1 0\n-90 0 90\n-90 0 90\n1 2 3\n4 9 5\n6 7 8\n";
    const auto b = parse_ies(ies_head + "TILT=NONE\n1 -1 1" + table + "2 " + rest, "b.ies").distribution;
    const auto a = parse_ies(ies_head + "TILT=NONE\n1 -1 1" + table + "3 " + rest, "a.ies").distribution;
    // Type B: vertical 0 and horizontal 0 straight down, vertical 90 along +x, horizontal 90 along -y.
    EXPECT_NEAR(b->intensity({0, 0, -1}), 9.0, 1e-12);
    EXPECT_NEAR(b->intensity({1, 0, 0}), 5.0, 1e-12);
    EXPECT_NEAR(b->intensity({-1, 0, 0}), 4.0, 1e-12);
    EXPECT_EQ(b->intensity({0.6, 0, 0.8}), 0.0);
    // Type A: both 0 along +x, vertical 90 straight up, horizontal 90 along -y.
    EXPECT_NEAR(a->intensity({1, 0, 0}), 9.0, 1e-12);
    EXPECT_NEAR(a->intensity({0, -1, 0}), 7.0, 1e-12);
    EXPECT_NEAR(a->intensity({0, 1, 0}), 2.0, 1e-12);
    EXPECT_EQ(a->intensity({-1, 0, 0}), 0.0);
    for (const auto& of : {a, b}) { // half of the sphere is dark: the edge costs the midpoint rule an order
        EXPECT_NEAR(flux_by_points(*of), of->flux(), 5e-3 * of->flux());
    }
}

TEST(Ies, HorizontalAnglesOfTypesAAndBFromZeroStandForBothSides) {
    // Type A: horizontal 0 and 90, vertical -90, 0, 90. Type B: the same angles.
    const std::string rest = "2 0 0 0\n1 1 0\n-90 0 90\n0 90\n";
    const auto a = parse_ies(ies_head + "TILT=NONE\n1 -1 1 3 2 3 " + rest + "4 9 5\n6 7 8\n", "a.ies").distribution;
    EXPECT_NEAR(a->intensity({1, 0, 0}), 9.0, 1e-12);
    EXPECT_NEAR(a->intensity({0, -1, 0}), 7.0, 1e-12);
    EXPECT_NEAR(a->intensity({0, 1, 0}), 7.0, 1e-12);
    const auto b = parse_ies(ies_head + "TILT=NONE\n1 -1 1 3 2 2 " + rest + "4 9 5\n6 7 8\n", "b.ies").distribution;
    EXPECT_NEAR(b->intensity({0, 0, -1}), 9.0, 1e-12);
    EXPECT_NEAR(b->intensity({1, 0, 0}), 5.0, 1e-12);
    EXPECT_NEAR(b->intensity({-1, 0, 0}), 4.0, 1e-12);
    const double half = std::sqrt(0.5); // vertical 0, horizontal 45 and -45
    EXPECT_NEAR(b->intensity({0, half, -half}), 8.0, 1e-12);
    EXPECT_NEAR(b->intensity({0, -half, -half}), 8.0, 1e-12);
    // Vertical angles from 0 are of the half above (A), or of that on one side (B).
    const std::string upper = "2 0 0 0\n1 1 0\n0 90\n-90 0 90\n2 2\n9 5\n7 7\n";
    const auto above = parse_ies(ies_head + "TILT=NONE\n1 -1 1 2 3 3 " + upper, "a.ies").distribution;
    EXPECT_GT(above->intensity(Vec3(1, 0, 1).normalized()), 0.0);
    EXPECT_EQ(above->intensity(Vec3(1, 0, -1).normalized()), 0.0);
}

TEST(Ies, LabelsMayBeginWithTilt) {
    const Luminaire old =
        parse_ies("Lamp of 1986\nTilted head\nTILT = NONE\n1 -1 1 2 1 1 2 0 0 0\n1 0.5 0\n0 90\n0\n8 8\n", "a.ies");
    EXPECT_NEAR(old.distribution->largest(), 4.0, 1e-12); // with its ballast-lamp factor
    const Luminaire worded =
        parse_ies("IES file of a lamp\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 0.5 0\n0 90\n0\n8 8\n", "a.ies");
    EXPECT_NEAR(worded.distribution->largest(), 4.0, 1e-12);
}

TEST(Ies, TiltFactorsAreRead) {
    const Luminaire tilted = parse_ies(
        ies_head + "TILT=INCLUDE\n1\n3\n0 45 90\n1, 0.9, 0.7\n1 -1 1 2 1 1 2 0 0 0\n1 1 0\n0 90\n0\n1 1\n", "a.ies");
    EXPECT_NEAR(tilted.tilt_factor(0), 1.0, 1e-15);
    EXPECT_NEAR(tilted.tilt_factor(60), 0.9 - 0.2 / 3.0, 1e-12);
    EXPECT_NEAR(tilted.tilt_factor(120), 0.7, 1e-15);
}

TEST(Ies, MessagesNameFileLineAndRemedy) {
    const auto refused = [](const std::string& text) -> std::string {
        try {
            parse_ies(text, "lamp.ies");
        } catch (const InputError& error) {
            return error.what();
        }
        return "accepted";
    };
    EXPECT_THAT(refused("IESNA91\n"), HasSubstr("TILT"));
    EXPECT_THAT(refused("TILT=NONE\n1 -1 1 2 1 4 2 0 0 0\n"), HasSubstr("lamp.ies:2: the photometric type"));
    EXPECT_THAT(refused("TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 0\n0 90\n0\n1\n"), HasSubstr("a candela value"));
    EXPECT_THAT(refused("TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 0\n90 0\n0\n1 1\n"), HasSubstr("do not ascend"));
    EXPECT_THAT(refused("TILT=away.tlt\n"), HasSubstr("cannot be found"));
    EXPECT_THAT(refused("TILT=NONE\n1 -1 1 2 3 1 2 0 0 0\n1 1 0\n0 90\n0 30 60\n1 1 2 2 3 3\n"),
                HasSubstr("its planes are from 0 to 60 degrees"));
    for (const std::string type : {"2", "3"}) {
        const std::string angles = type == "3" ? "3 1" : "1 3", lists = type == "3" ? "-90 0 90\n0\n" : "0\n-90 0 90\n";
        EXPECT_THAT(refused("TILT=NONE\n1 -1 1 " + angles + " " + type + " 2 0 0 0\n1 1 0\n" + lists + "1 2 3\n"),
                    HasSubstr("at least two planes"));
    }
}

std::string eulumdat(int symmetry, int planes, const std::string& c, const std::string& values,
                     const std::string& ratio = "100") {
    return "company\n1\n" + std::to_string(symmetry) + "\n" + std::to_string(planes) +
           "\n90\n3\n90\nreport\nname\nnumber\nfile\ndate\n1200\n300\n80\n1100\n0\n0\n0\n0\n0\n50\n" + ratio +
           "\n1,0\n0\n1\n2\nT16\n2000\n3000\n1A\n60\n0\n0\n0\n0\n0\n0\n0\n0\n0\n0\n" + c + "0\n90\n180\n" + values;
}

TEST(Eulumdat, IsInCandelaPerThousandLumensOfTheLamps) {
    const double even = 1000.0 / (4.0 * pi);
    const std::string one = std::to_string(even) + "\n";
    const Luminaire sphere = parse_eulumdat(eulumdat(1, 4, "0\n90\n180\n270\n", one + one + one), "a.ldt");
    EXPECT_NEAR(sphere.distribution->flux(), 2000.0, 1e-4); // six digits in the file
    EXPECT_NEAR(*sphere.stated_flux, 2000.0, 1e-12);
    EXPECT_TRUE(sphere.is_round);
    EXPECT_NEAR(sphere.width, 1.1, 1e-15);
    EXPECT_TRUE(sphere.notes.empty());
}

TEST(Eulumdat, AllSymmetriesGiveTheSamePlanes) {
    const std::string c = "0\n90\n180\n270\n", x = "9\n4\n1\n", y = "9\n2\n1\n";
    const Luminaire whole = parse_eulumdat(eulumdat(0, 4, c, x + y + x + y), "a.ldt");
    EXPECT_NEAR(whole.distribution->intensity(away(90, 90)), 4.0, 1e-12); // 2 cd/klm of 2000 lm
    EXPECT_NEAR(whole.distribution->intensity(away(90, 180)), 8.0, 1e-12);
    const Luminaire two = parse_eulumdat(eulumdat(2, 4, c, x + y + x), "a.ldt"),
                    three = parse_eulumdat(eulumdat(3, 4, c, y + x + y), "a.ldt"),
                    four = parse_eulumdat(eulumdat(4, 4, c, x + y), "a.ldt");
    for (const double plane : {0.0, 20.0, 130.0, 220.0, 350.0}) {
        const double known = whole.distribution->intensity(away(60, plane));
        for (const Luminaire* each : {&two, &three, &four}) {
            EXPECT_NEAR(each->distribution->intensity(away(60, plane)), known, 1e-12) << plane;
        }
    }
}

TEST(Eulumdat, SymmetryIsAboutThePlaneThatItSays) {
    const std::string c = "0\n90\n180\n270\n", x = "9\n4\n1\n", y = "9\n2\n1\n", z = "9\n3\n1\n";
    // Indicator 2: about C0-C180. Indicator 3: about C90-C270; the file has C270, C0, C90.
    const Luminaire two = parse_eulumdat(eulumdat(2, 4, c, x + y + z), "a.ldt");
    EXPECT_NEAR(two.distribution->intensity(away(90, 0)), 8.0, 1e-12); // 4 cd/klm of 2000 lm
    EXPECT_NEAR(two.distribution->intensity(away(90, 180)), 6.0, 1e-12);
    EXPECT_NEAR(two.distribution->intensity(away(90, 270)), 4.0, 1e-12);
    EXPECT_NEAR(two.distribution->intensity(away(90, 225)), 5.0, 1e-12);
    const Luminaire three = parse_eulumdat(eulumdat(3, 4, c, x + y + z), "a.ldt");
    EXPECT_NEAR(three.distribution->intensity(away(90, 270)), 8.0, 1e-12);
    EXPECT_NEAR(three.distribution->intensity(away(90, 0)), 4.0, 1e-12);
    EXPECT_NEAR(three.distribution->intensity(away(90, 180)), 4.0, 1e-12);
    EXPECT_NEAR(three.distribution->intensity(away(90, 90)), 6.0, 1e-12);
    EXPECT_NEAR(three.distribution->intensity(away(90, 135)), 5.0, 1e-12);
}

TEST(Eulumdat, WhatDoesNotFitIsRefusedOrNoted) {
    const std::string c = "0\n90\n180\n270\n", x = "9\n4\n1\n";
    EXPECT_THROW(parse_eulumdat(eulumdat(4, 4, "0\n80\n180\n270\n", x + x), "a.ldt"), InputError);
    EXPECT_THROW(parse_eulumdat(eulumdat(2, 4, "0\n90\n160\n270\n", x + x + x), "a.ldt"), InputError);
    const Luminaire more = parse_eulumdat(eulumdat(1, 4, c, x + x), "a.ldt");
    EXPECT_THAT(more.notes, testing::Contains(HasSubstr("what follows its last intensity")));
    std::string blank = eulumdat(1, 4, c, x);
    const std::size_t ratios = blank.find("60\n0\n0\n") + 3;
    blank.erase(ratios, 1); // a blank line in place of a ratio
    EXPECT_NEAR(parse_eulumdat(blank, "a.ldt").distribution->intensity(away(90, 10)), 8.0, 1e-12);
}

TEST_F(SceneFile, ALuminaireTurnsWithItsDirection) {
    write("lamp.ies", ies_head + "TILT=NONE\n1 -1 1 2 2 1 2 0.3 1.2 0\n1 1 0\n0 90\n0 90\n683 100\n683 300\n");
    const PolygonSoup soup = with(
        "\"lights\": [{\"type\": \"luminaire\", \"file\": \"lamp.ies\", \"position\": [0, 0, 3], \"as\": \"area\"},"
        "{\"type\": \"luminaire\", \"file\": \"lamp.ies\", \"position\": [0, 0, 3], \"direction\": [1, 0, 0], "
        "\"luminous_flux\": 1000, \"name\": \"desk\"}]");
    ASSERT_EQ(soup.lights.points.size(), 2U);
    const PointLight &down = soup.lights.points[0], &aside = soup.lights.points[1];
    EXPECT_NEAR(down.intensity[0], 1.0, 1e-15);
    EXPECT_NEAR(down.falloff({0, 0, -1}), 1.0, 1e-15);
    EXPECT_NEAR(down.falloff({1, 0, 0}), 100.0 / 683.0, 1e-12);
    EXPECT_NEAR(down.falloff({0, 1, 0}), 300.0 / 683.0, 1e-12);
    EXPECT_NEAR(down.half_length, 0.6, 1e-15);
    EXPECT_NEAR(down.half_width, 0.15, 1e-15);
    EXPECT_NEAR(aside.falloff({1, 0, 0}), 1.0, 1e-12);
    EXPECT_NEAR(aside.falloff({0, 1, 0}), 300.0 / 683.0, 1e-12);
    EXPECT_NEAR(aside.falloff({0, 0, 1}), 100.0 / 683.0, 1e-12);
    EXPECT_NEAR(aside.intensity[0] * lumens_per_watt * aside.distribution->flux() / aside.distribution->largest(),
                1000.0, 1e-9);
    EXPECT_EQ(soup.files.size(), 4U); // scene, mesh and the luminaires
}

TEST(Opening, ItsLightConvergesToTheQuadratureOfTheSource) {
    PointLight light;
    light.intensity = Rgb::Ones();
    light.half_length = 0.6;
    light.half_width = 0.15;
    light.distribution = std::make_shared<IntensityDistribution>(
        IntensityDistribution::Table{PhotometryType::C,
                                     {0},
                                     {0, 10, 20, 30, 40, 50, 60, 70, 80, 90},
                                     {100, 98.5, 94, 86.6, 76.6, 64.3, 50, 34.2, 17.4, 0}});
    for (const Vec3& x : {Vec3(0, 0, -0.1), Vec3(0.5, 0.1, -0.2), Vec3(1.0, 0.4, -0.5), Vec3(0, 0, -3)}) {
        double sum = 0.0;
        constexpr int n = 400;
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n / 4; ++j) {
                sum += light.kernel(light.place({(i + 0.5) / n, (j + 0.5) / (n / 4.0)}), x, Vec3::UnitZ());
            }
        }
        sum /= n * (n / 4);
        // The intensity has kinks at its angles.
        EXPECT_NEAR(light.mean_kernel(x, Vec3::UnitZ()), sum, 1e-3 * sum) << x.transpose();
    }
    // Far away it is a point, but for the tip of the table: from 0 to 10 degrees the intensity falls by 1.5 %, and the
    // corner is 0.59 degrees away from the axis.
    const Vec3 far(0, 0, -60);
    EXPECT_NEAR(light.mean_kernel(far, Vec3::UnitZ()), light.kernel(light.position, far, Vec3::UnitZ()),
                0.015 * 0.059 / (60.0 * 60.0));
}

} // namespace
} // namespace difusa::luminaires_test
