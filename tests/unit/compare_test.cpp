#include <difusa/core/error.h>
#include <difusa/core/random.h>
#include <difusa/import/shapes.h>
#include <difusa/mesh/nearest_surface.h>
#include <difusa/study/compare.h>

#include <meshes.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

namespace difusa::compare_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
constexpr double eps = std::numeric_limits<double>::epsilon();
using Function = std::function<double(const Vec3&)>;

/// A field with the scalar `radiosity_weighted` = f at the points of the mesh.
FieldFile scalar_field(const Mesh& mesh, const Function& f, const std::string& name = "radiosity_weighted") {
    FieldFile field;
    field.points = mesh.points;
    field.triangles = mesh.triangles;
    Values values(static_cast<Eigen::Index>(mesh.points.size()), 1);
    for (std::size_t p = 0; p < mesh.points.size(); ++p) {
        values(static_cast<Eigen::Index>(p), 0) = f(mesh.points[p]);
    }
    field.point_arrays.push_back({name, "W/m^2", {}, values});
    return field;
}

Comparison compare(const FieldFile& result, const FieldFile& reference, const CompareOptions& options = {}) {
    return difusa::compare(result, "result.vtp", reference, "reference.vtp", options, {});
}

const Values& array(const FieldFile& field, const std::string& name) {
    for (const FieldArray& a : field.point_arrays) {
        if (a.name == name) {
            return std::get<Values>(a.data);
        }
    }
    ADD_FAILURE() << "no array " << name;
    static const Values nothing;
    return nothing;
}

Vec3 random_point(RandomStream& stream) {
    return {stream.uniform(), stream.uniform(), stream.uniform()};
}

// ---- emitters -------------------------------------------------------------------------------------------------

/// A floor of radiosity `floor` and a lamp of the same area of radiosity 1000, which emits it all, or as `emission`
/// says.
FieldFile floor_and_lamp(double floor, const Function& emission) {
    Mesh mesh = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 2, 2);
    add(mesh, rectangle({0, 0, 2}, {0, 1, 0}, {1, 0, 0}), 1);
    FieldFile field = scalar_field(mesh, [&](const Vec3& p) { return p.z() < 1.0 ? floor : 1000.0; });
    field.point_arrays.push_back(scalar_field(mesh, emission, "emission").point_arrays[0]);
    return field;
}

double lamp_alone(const Vec3& p) {
    return p.z() > 1.0 ? 1000.0 : 0.0;
}

TEST(Compare, EmittersAreLeftOutOfTheTotalUnlessAskedFor) {
    const FieldFile result = floor_and_lamp(1.25, lamp_alone), reference = floor_and_lamp(1.0, lamp_alone);
    const auto l1 = [](const Comparison& comparison) { return comparison.quantities[0].norms.all.l1; };
    const Comparison without = compare(result, reference);
    EXPECT_NEAR(l1(without).error, 0.25, 8 * eps);
    EXPECT_NEAR(*l1(without).relative(), 0.25, 8 * eps);
    EXPECT_NEAR(without.matching.emitting_area, 1.0, 8 * eps);
    EXPECT_THAT(without.notes, testing::Contains(HasSubstr("emitters, 50 % of the area, are left out")));
    EXPECT_EQ(without.quantities[0].result(without.quantities[0].result.rows() - 1, 0), 1000.0); // the field has them

    CompareOptions all;
    all.with_emitters = true;
    EXPECT_NEAR(l1(compare(result, reference, all)).error, 0.125, 8 * eps);
    EXPECT_NEAR(*l1(compare(result, reference, all)).relative(), 0.25 / 1001.0, 8 * eps);
    EXPECT_EQ(compare(result, reference, all).matching.emitting_area, 0.0);

    // On the reference alone it is enough; if all surfaces emit, they are compared.
    const auto nothing = [](const Vec3&) { return 0.0; };
    const auto everything = [](const Vec3&) { return 1.0; };
    EXPECT_NEAR(l1(compare(floor_and_lamp(1.25, nothing), reference)).error, 0.25, 8 * eps);
    EXPECT_NEAR(l1(compare(floor_and_lamp(1.25, everything), floor_and_lamp(1.0, everything))).error, 0.125, 8 * eps);
}

TEST(Compare, EmittersAreLeftOutOfEveryQuantityThatContainsEmission) {
    // Emission is 1000 on the lamp; irradiance does not contain it and is compared there too.
    for (const auto& [name, counted] :
         {std::pair("luminance", 0.25), {"radiosity_of_lamp", 0.25}, {"irradiance", 0.125}}) {
        FieldFile result = floor_and_lamp(1.25, lamp_alone), reference = floor_and_lamp(1.0, lamp_alone);
        for (FieldFile* field : {&result, &reference}) {
            FieldArray copy = field->point_arrays[0];
            copy.name = name;
            field->point_arrays.push_back(copy);
        }
        CompareOptions options;
        options.arrays = {name};
        EXPECT_NEAR(compare(result, reference, options).quantities[1].norms.all.l1.error, counted, 8 * eps) << name;
    }
}

TEST(Compare, SaysThatEmittersAreIncludedIfNeitherFileTellsThem) {
    const auto unknown = HasSubstr("neither file has an array emission");
    FieldFile result = floor_and_lamp(1.25, lamp_alone), reference = floor_and_lamp(1.0, lamp_alone);
    EXPECT_THAT(compare(result, reference).notes, testing::Not(testing::Contains(unknown)));
    const FieldFile told = result;
    for (FieldFile* field : {&result, &reference}) {
        field->point_arrays.resize(1); // as a .ply has it
    }
    EXPECT_THAT(compare(result, reference).notes, testing::Contains(unknown));
    EXPECT_THAT(compare(told, reference).notes, testing::Not(testing::Contains(unknown)));
    CompareOptions all;
    all.with_emitters = true; // asked for: nothing to say
    EXPECT_THAT(compare(result, reference, all).notes, testing::Not(testing::Contains(unknown)));
}

// ---- nearest surface ------------------------------------------------------------------------------------------

/// The least distance to a triangle, by ternary search for one weight within ternary search for another: distance is
/// convex in both.
double distance_by_search(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto least = [](const std::function<double(double)>& f, double high) {
        double low = 0.0;
        for (int i = 0; i < 80; ++i) {
            const double left = low + (high - low) / 3.0, right = high - (high - low) / 3.0;
            (f(left) < f(right) ? high : low) = f(left) < f(right) ? right : left;
        }
        return f(0.5 * (low + high));
    };
    return least(
        [&](double u) { return least([&](double v) { return (a + u * (b - a) + v * (c - a) - p).norm(); }, 1.0 - u); },
        1.0);
}

TEST(NearestSurface, NearestPointOfATriangleIsNearest) {
    RandomStream stream(1, "triangles");
    for (int i = 0; i < 60; ++i) {
        const Vec3 a = random_point(stream), b = random_point(stream), c = random_point(stream);
        const Vec3 p = 3.0 * random_point(stream) - Vec3::Ones();
        const auto w = nearest_on_triangle(p, a, b, c);
        EXPECT_NEAR(w[0] + w[1] + w[2], 1.0, 4 * eps);
        EXPECT_GE(*std::min_element(w.begin(), w.end()), 0.0);
        const double expected = distance_by_search(p, a, b, c);
        // The search stops at differences of distances of eps: at offsets of its root, and so do distances' values.
        EXPECT_NEAR((w[0] * a + w[1] * b + w[2] * c - p).norm(), expected, 1e-7 * expected);
    }
}

TEST(NearestSurface, NeedlesKeepTheirDigits) {
    // A needle of height 1e-9: above its middle the weights are known.
    const Vec3 a(0, 0, 0), b(1, 0, 0), c(0.25, 1e-9, 0);
    const Vec3 p = 0.25 * a + 0.25 * b + 0.5 * c + Vec3(0, 0, 0.125);
    const auto w = nearest_on_triangle(p, a, b, c);
    EXPECT_NEAR(w[0], 0.25, 1e-6);
    EXPECT_NEAR(w[1], 0.25, 1e-6);
    EXPECT_NEAR(w[2], 0.5, 1e-6);
}

/// What `nearest` promises, by a loop over all triangles.
NearestSurface::Place brute_force(const Mesh& mesh, const NearestSurface::Query& query) {
    const double slack = 64 * eps * std::max(mesh.magnitude(), query.position.cwiseAbs().maxCoeff());
    std::vector<NearestSurface::Place> places;
    double least = std::numeric_limits<double>::infinity();
    const auto distance = [&](Index t, const Vec3& p, std::array<double, 3>& w) {
        w = nearest_on_triangle(p, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
        return (w[0] * mesh.corner(t, 0) + w[1] * mesh.corner(t, 1) + w[2] * mesh.corner(t, 2) - p).norm();
    };
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (mesh.normals[t].dot(query.normal) > perpendicular) {
            NearestSurface::Place place;
            place.triangle = t;
            place.distance = distance(t, query.position, place.weight);
            places.push_back(place);
            least = std::min(least, place.distance);
        }
    }
    std::erase_if(places, [&](const auto& place) { return place.distance > least + slack; });
    double aside = std::numeric_limits<double>::infinity();
    std::array<double, 3> unused{};
    for (const auto& place : places) {
        aside = std::min(aside, distance(place.triangle, query.toward, unused));
    }
    for (const auto& place : places) {
        if (distance(place.triangle, query.toward, unused) <= aside + slack) {
            return place;
        }
    }
    return {};
}

TEST(NearestSurface, AgreesWithALoopOverAllTriangles) {
    RandomStream stream(2, "queries");
    for (const Mesh& mesh :
         {test::icosphere(2), test::box(1.0, 3), test::moved(test::box(1.0, 3, true), 1e-6, {5, 0, -7}),
          test::mobius(20), test::together(test::box(2.0, 2), test::icosphere(1, 0.5))}) {
        const NearestSurface surface(mesh.points, mesh.triangles);
        for (int i = 0; i < 300; ++i) {
            const auto t = static_cast<Index>(stream.below(mesh.triangles.size()));
            NearestSurface::Query query;
            switch (i % 3) {
            case 0: // at a point of the mesh, where many triangles are equally near
                query.position = mesh.corner(t, 0);
                break;
            case 1: // on an edge
                query.position = 0.5 * (mesh.corner(t, 0) + mesh.corner(t, 1));
                break;
            default: // around the mesh
                query.position = mesh.low - 0.2 * (mesh.high - mesh.low) +
                                 1.4 * (mesh.high - mesh.low).cwiseProduct(random_point(stream));
            }
            query.normal =
                i % 5 == 0 ? Vec3((random_point(stream) - Vec3::Constant(0.5)).normalized()) : mesh.normals[t];
            query.toward = query.position + (mesh.at(t, 1.0 / 3.0, 1.0 / 3.0).position - query.position) / 1024.0;
            const auto found = surface.nearest(query), expected = brute_force(mesh, query);
            ASSERT_EQ(found.triangle, expected.triangle) << i;
            EXPECT_EQ(found.distance, expected.distance);
            EXPECT_EQ(found.weight, expected.weight);
        }
    }
}

TEST(NearestSurface, TheSideOfTheQueryCountsWhereTrianglesMeet) {
    // Two coplanar halves of a square that meet in a diagonal, seen from a point on it.
    const Mesh mesh = test::grid(1, 1);
    const NearestSurface surface(mesh.points, mesh.triangles);
    const Vec3 middle(0.5, 0.5, 0.0), up = Vec3::UnitZ();
    EXPECT_EQ(surface.nearest({middle, up, Vec3(0.5 + 1e-3, 0.5 - 1e-3, 0)}).triangle, 0u);
    EXPECT_EQ(surface.nearest({middle, up, Vec3(0.5 - 1e-3, 0.5 + 1e-3, 0)}).triangle, 1u);
    EXPECT_EQ(surface.nearest({middle, -up, middle}).triangle, none);
    EXPECT_EQ(surface.nearest({middle, Vec3::UnitX(), middle}).triangle, none);
}

// ---- comparison -----------------------------------------------------------------------------------------------

TEST(Compare, TheSameFieldHasNoError) {
    const FieldFile field = scalar_field(test::icosphere(2), [](const Vec3& p) { return 2.0 + std::sin(3 * p.x()); });
    const Comparison c = compare(field, field);
    EXPECT_TRUE(c.matching.same_mesh);
    ASSERT_EQ(c.quantities.size(), 1u);
    EXPECT_EQ(c.quantities[0].name, "radiosity_weighted");
    EXPECT_EQ(c.quantities[0].norms.all.linf.error, 0.0);
    EXPECT_EQ(c.quantities[0].norms.all.integral.error, 0.0);
    EXPECT_EQ(c.matching.matched_area, c.matching.area);
}

TEST(Compare, LinearFieldsOnPlanesAgreeAcrossTriangulations) {
    // The faces of a box, cut differently, far from the origin and small: linear in space, so linear in each triangle.
    for (const double scale : {1.0, 1e-6, 1e6}) {
        const Vec3 offset = scale * Vec3(3, -5, 7);
        const Mesh coarse = test::moved(test::box(Vec3(1, 2, 3), 3), scale, offset);
        const Mesh fine = test::moved(test::box(Vec3(1, 2, 3), 7), scale, offset);
        const Function f = [&](const Vec3& p) { return 20.0 + Vec3(1, -2, 0.5).dot(p) / scale; };
        for (const bool swap : {false, true}) {
            const Comparison c = compare(scalar_field(swap ? fine : coarse, f), scalar_field(swap ? coarse : fine, f));
            EXPECT_FALSE(c.matching.same_mesh);
            EXPECT_EQ(c.matching.matched_area, c.matching.area);
            EXPECT_NEAR(c.matching.area, 22.0 * scale * scale, 1e4 * eps * 22.0 * scale * scale); // 600 triangles
            EXPECT_EQ(c.matching.unmatched_vertices, 0u);
            // Places are known to 64 eps times 10 (the coordinates, in units of the box); slopes are at most 2.3, and
            // values up to 50 are rounded a few times.
            EXPECT_LT(c.quantities[0].norms.all.linf.error, (64 * 10 * 2.3 + 8 * 50) * eps);
        }
    }
}

TEST(Compare, KnownErrorsHaveTheirNormsInClosedForm) {
    // On the unit square e = x exactly, in another triangulation; reference 2.
    const Mesh mesh = test::grid(8, 8), other = test::grid(5, 3);
    const FieldFile result = scalar_field(mesh, [](const Vec3& p) { return 2.0 + p.x(); });
    const FieldFile reference = scalar_field(other, [](const Vec3&) { return 2.0; });
    const Comparison c = compare(result, reference);
    const ErrorNorms& norms = c.quantities[0].norms.all;
    const double rounding = 1000 * eps; // 384 terms and the places
    EXPECT_NEAR(norms.area, 1.0, rounding);
    EXPECT_NEAR(norms.l1.error, 0.5, rounding);
    EXPECT_NEAR(norms.l2.error, std::sqrt(1.0 / 3.0), rounding); // the rule is exact for x²
    EXPECT_NEAR(norms.linf.error, 1.0, rounding);
    EXPECT_NEAR(norms.bias.error, 0.5, rounding);
    EXPECT_NEAR(*norms.integral.relative(), 0.25, rounding);
    // The quantile of x by area is the share itself, to one column of points.
    EXPECT_NEAR(norms.percentile95.error, 0.95, 1.0 / 8);
    const FieldFile errors = error_field(c, result, "result.vtp", "reference.vtp");
    for (std::size_t p = 0; p < mesh.points.size(); ++p) {
        const auto row = static_cast<Eigen::Index>(p);
        EXPECT_NEAR(array(errors, "radiosity_weighted_error")(row, 0), mesh.points[p].x(), rounding);
        EXPECT_NEAR(array(errors, "radiosity_weighted_error_absolute")(row, 0), mesh.points[p].x(), rounding);
        EXPECT_NEAR(array(errors, "radiosity_weighted_error_relative")(row, 0), mesh.points[p].x() / 2, rounding);
        EXPECT_LE(array(errors, "distance")(row, 0), rounding);
    }
}

TEST(Compare, RelativeErrorsInTheDarkAreBounded) {
    const Mesh mesh = test::grid(1, 1);
    const FieldFile result = scalar_field(mesh, [](const Vec3&) { return 1.0; });
    const FieldFile dark = scalar_field(mesh, [](const Vec3& p) { return p.x(); }); // mean 1/2
    const Values e = array(error_field(compare(result, dark), result, "", ""), "radiosity_weighted_error_relative");
    EXPECT_NEAR(e(0, 0), 1.0 / (0.01 * 0.5), 1e4 * eps);
    EXPECT_EQ(e(1, 0), 0.0);
    const FieldFile black = scalar_field(mesh, [](const Vec3&) { return 0.0; });
    EXPECT_TRUE(std::isnan(
        array(error_field(compare(result, black), result, "", ""), "radiosity_weighted_error_relative")(0, 0)));
    EXPECT_FALSE(compare(result, black).quantities[0].norms.all.l2.relative().has_value());
}

TEST(Compare, SharpEdgesAndMaterialsKeepTheirSides) {
    // Every face of a box has its own value; vertices belong to one face each, as difusa writes them.
    const auto faces = [](int n) {
        const Mesh box = test::box(1.0, n);
        FieldFile field;
        Values values(static_cast<Eigen::Index>(3 * box.triangles.size()), 1);
        for (Index t = 0; t < box.triangles.size(); ++t) {
            std::array<Index, 3> triangle{};
            for (int k = 0; k < 3; ++k) {
                triangle[static_cast<std::size_t>(k)] = static_cast<Index>(field.points.size());
                const double material = box.at(t, 1.0 / 3.0, 1.0 / 3.0).position.x() < 0.5 ? 0.0 : 10.0;
                values(static_cast<Eigen::Index>(field.points.size()), 0) =
                    1.0 + material + Vec3(1, 2, 3).dot(box.normals[t]);
                field.points.push_back(box.corner(t, k));
            }
            field.triangles.push_back(triangle);
        }
        field.point_arrays.push_back({"radiosity_weighted", "", {}, values});
        return field;
    };
    // 4 and 6 have the edge between the materials, at x = 1/2, in common.
    const Comparison c = compare(faces(4), faces(6));
    EXPECT_LT(c.quantities[0].norms.all.linf.error, 64 * 14 * eps);
}

TEST(Compare, WhatHasNoMatchIsCountedAndNotUsed) {
    // Of the result's two squares one lies on the reference, one far from it; a third one faces the other way.
    const Mesh near = test::grid(4, 4), far = test::moved(test::grid(2, 2), 1.0, {5, 0, 0});
    Mesh away = test::moved(test::grid(2, 2), 2.0, {10, 0, 0});
    test::flip(away);
    const Mesh mesh = test::together(test::together(near, far), away);
    const FieldFile result = scalar_field(mesh, [](const Vec3& p) { return p.x() < 2.0 ? 3.0 : 1e9; });
    const FieldFile reference = scalar_field(test::grid(3, 3), [](const Vec3&) { return 2.0; });
    CompareOptions options;
    options.least_matched = 0.15;
    const Comparison c = compare(result, reference, options);
    EXPECT_NEAR(c.matching.matched_area, 1.0, 64 * eps);
    EXPECT_NEAR(c.matching.too_far_area, 1.0, 64 * eps);
    EXPECT_NEAR(c.matching.turned_away_area, 4.0, 64 * eps);
    EXPECT_EQ(c.matching.unmatched_vertices, 18u);
    EXPECT_NEAR(c.quantities[0].norms.all.linf.error, 1.0, 16 * eps); // weights sum to 1 within rounding
    EXPECT_THAT(c.notes, testing::Contains(HasSubstr("16.6667 % of the result's area is farther than")));
    EXPECT_THAT(c.notes, testing::Contains(HasSubstr("66.6667 % of the result's area faces a direction")));
    EXPECT_THAT(c.notes, testing::Contains(HasSubstr("the surfaces differ")));
    const Values e = array(error_field(c, result, "", ""), "radiosity_weighted_error");
    EXPECT_NEAR(e(0, 0), 1.0, 16 * eps);
    EXPECT_TRUE(std::isnan(e(e.rows() - 1, 0)));
    EXPECT_THAT([&] { compare(result, reference); },
                ThrowsMessage<InputError>(AllOf(HasSubstr("only 16.6667 % of the area of result.vtp lies on reference"),
                                                HasSubstr("same unit"), HasSubstr("--min-match"))));
    options.max_distance = 100.0;
    EXPECT_NEAR(compare(result, reference, options).matching.matched_area, 2.0, 64 * eps);
    EXPECT_THAT([&] { compare(scalar_field(away, [](const Vec3&) { return 1.0; }), reference); },
                ThrowsMessage<InputError>(HasSubstr("no part of result.vtp lies on reference.vtp")));
    options.least_matched = 0.0;
    EXPECT_THAT([&] { compare(scalar_field(away, [](const Vec3&) { return 1.0; }), reference, options); },
                ThrowsMessage<InputError>(HasSubstr("no part of result.vtp lies on reference.vtp")));
}

/// Arrays as a bake writes them, scaled.
FieldFile bake_like(const Mesh& mesh, double scale) {
    FieldFile field = scalar_field(mesh, [&](const Vec3&) { return scale; });
    const auto count = static_cast<Eigen::Index>(mesh.points.size());
    Values rho(count, 3), H(count, 3), B(count, 3);
    for (Eigen::Index v = 0; v < count; ++v) {
        rho.row(v) << 0.5, 0.25, 0.75;
        H.row(v) << scale, 2 * scale, 4 * scale;
        B.row(v) << scale, scale, 2 * scale;
    }
    const std::vector<std::string> rgb{"R", "G", "B"};
    field.point_arrays.push_back({"radiosity", "W/m^2", rgb, B});
    field.point_arrays.push_back({"irradiance_indirect", "W/m^2", rgb, H});
    field.point_arrays.push_back({"reflectance", "", rgb, rho});
    return field;
}

TEST(Compare, TotalAndIndirectLightAreComparedPerChannel) {
    const FieldFile result = bake_like(test::grid(2, 2), 3.0), reference = bake_like(test::grid(3, 3), 2.0);
    CompareOptions options;
    options.arrays = {"irradiance_indirect", "radiosity"};
    const Comparison c = compare(result, reference, options);
    ASSERT_EQ(c.quantities.size(), 3u);
    EXPECT_EQ(c.quantities[0].name, "radiosity");
    EXPECT_EQ(c.quantities[1].name, "radiosity_indirect");
    EXPECT_EQ(c.quantities[2].name, "irradiance_indirect");
    const FieldNorms& indirect = c.quantities[1].norms;
    EXPECT_NEAR(indirect.channel[0].l2.error, 0.5, 64 * eps);
    EXPECT_NEAR(indirect.channel[1].l2.error, 0.5, 64 * eps);
    EXPECT_NEAR(indirect.channel[2].l2.error, 3.0, 64 * eps);
    for (const ComparedQuantity& quantity : c.quantities) {
        EXPECT_NEAR(*quantity.norms.weighted->l1.relative(), 0.5, 64 * eps);
        EXPECT_NEAR(*quantity.norms.all.integral.relative(), 0.5, 64 * eps);
    }
    const FieldFile errors = error_field(c, result, "", "");
    EXPECT_NEAR(array(errors, "radiosity_indirect_error_rgb")(0, 2), 3.0, 64 * eps);
    EXPECT_NEAR(array(errors, "radiosity_error")(0, 0), 0.2126 + 0.7152 + 2 * 0.0722, 64 * eps);
    EXPECT_NEAR(array(errors, "radiosity_error_relative_rgb")(0, 1), 0.5, 64 * eps);

    const auto report = nlohmann::json::parse(report_of(c, "result.vtp", "reference.vtp"));
    EXPECT_EQ(report["schema"], "difusa-comparison");
    EXPECT_EQ(report["schema_version"], 3);
    EXPECT_EQ(report["quantities"][1]["name"], "radiosity_indirect");
    EXPECT_EQ(report["quantities"][1]["channels"][2]["name"], "B");
    EXPECT_EQ(report["quantities"][1]["channels"][2]["l2"]["error"].get<double>(), indirect.channel[2].l2.error);
    EXPECT_THAT(table_of(c), HasSubstr("radiosity_indirect, W/m^2 (weighted)"));
}

TEST(Compare, LuminanceStandsForWhatAFileLacks) {
    const Mesh mesh = test::grid(2, 2);
    FieldFile ply = scalar_field(
        mesh, [](const Vec3&) { return 2.0; }, "quality");
    const Comparison c = compare(bake_like(mesh, 3.0), ply);
    ASSERT_EQ(c.quantities.size(), 1u);
    EXPECT_EQ(c.quantities[0].name, "radiosity_weighted");
    EXPECT_EQ(c.quantities[0].norms.all.bias.error, 1.0);
    EXPECT_THAT(c.notes, testing::Contains(HasSubstr("reference.vtp has no array irradiance_indirect")));
    // A photometric one holds cd/m^2.
    FieldFile candelas = scalar_field(
        mesh, [](const Vec3&) { return 2.0 * 683.0 / std::numbers::pi; }, "luminance");
    candelas.point_arrays.back().unit = "cd/m^2";
    candelas.quality = "luminance";
    EXPECT_NEAR(compare(bake_like(mesh, 3.0), candelas).quantities[0].norms.all.bias.error, 1.0, 64 * eps);
}

TEST(Compare, WhatCannotBeComparedIsRefused) {
    const Mesh mesh = test::grid(2, 2);
    const FieldFile field = bake_like(mesh, 1.0);
    const auto refused = [&](const FieldFile& a, const FieldFile& b, const std::string& name, const char* why) {
        CompareOptions options;
        if (!name.empty()) {
            options.arrays = {name};
        }
        EXPECT_THAT([&] { compare(a, b, options); }, ThrowsMessage<InputError>(HasSubstr(why)));
    };
    refused(field, field, "reflectanse",
            "result.vtp: has no point array 'reflectanse', did you mean 'reflectance'?; it has: radiosity_weighted, "
            "radiosity,");
    refused(field, scalar_field(mesh, [](const Vec3&) { return 1.0; }), "radiosity",
            "reference.vtp: has no point array 'radiosity'");
    const FieldFile other = scalar_field(
        mesh, [](const Vec3&) { return 1.0; }, "pressure");
    refused(other, other, "", "nothing to compare by default");
    EXPECT_EQ(compare(other, other, {{"pressure"}, 0.0}).quantities.size(), 1u);
    refused(field,
            scalar_field(
                mesh, [](const Vec3&) { return 1.0; }, "reflectance"),
            "reflectance", "has 3 components in result.vtp and 1 in reference.vtp");
    FieldFile cloud = field;
    cloud.triangles.clear();
    refused(cloud, field, "", "result.vtp: has 9 points and no triangles");
    FieldFile hole = field;
    std::get<Values>(hole.point_arrays[1].data)(4, 1) = std::numeric_limits<double>::quiet_NaN();
    refused(field, hole, "", "reference.vtp: radiosity is not finite at point 4");
}

TEST(Compare, TheNumberOfThreadsChangesNoBit) {
    const auto f = [](const Vec3& p) { return 2.0 + std::sin(5 * p.x()) * p.y(); };
    const FieldFile result = scalar_field(test::icosphere(3), f), reference = scalar_field(test::icosphere(4), f);
    const auto report = [&](unsigned threads) {
        CompareOptions options;
        return report_of(difusa::compare(result, "a", reference, "b", options, {threads, nullptr}), "a", "b");
    };
    EXPECT_EQ(report(1), report(4));
}

TEST(Compare, InterpolationErrorFallsWithTheSquareOfTheReferencesEdges) {
    // A smooth field on a square: what the coarse reference misses is of second order.
    const Function f = [](const Vec3& p) { return 2.0 + std::sin(3 * p.x()) * std::cos(2 * p.y()); };
    const FieldFile result = scalar_field(test::grid(48, 48), f);
    std::vector<double> h, error;
    for (const int n : {5, 10, 20}) {
        h.push_back(1.0 / n);
        error.push_back(compare(result, scalar_field(test::grid(n, n), f)).quantities[0].norms.all.l2.error);
    }
    EXPECT_NEAR(convergence_order(h, error), 2.0, 0.2);
}

} // namespace
} // namespace difusa::compare_test
