#include <difusa/repair/diagnosis.h>

#include <difusa/core/error.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <map>
#include <numeric>

#include "meshes.h"
#include "soups.h"

namespace difusa {
namespace {

using test::make_soup;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

using Counts = std::map<std::string, std::size_t>;

Counts counts(const Diagnosis& diagnosis) {
    Counts result;
    for (const Finding& finding : diagnosis.findings) {
        EXPECT_TRUE(result.emplace(finding.code, finding.count).second) << finding.code << " is listed twice";
    }
    return result;
}

const Finding& finding(const Diagnosis& diagnosis, const std::string& code) {
    for (const Finding& each : diagnosis.findings) {
        if (each.code == code) {
            return each;
        }
    }
    throw std::out_of_range(code);
}

/// The message with which the soup is refused; empty if it is not.
std::string refusal(const PolygonSoup& soup) {
    try {
        diagnose(soup);
    } catch (const InputError& error) {
        return error.what();
    }
    return {};
}

/// Points and faces of a mesh with these triangles.
PolygonSoup soup_of(const Mesh& mesh) {
    std::vector<std::vector<Index>> faces;
    for (const auto& t : mesh.triangles) {
        faces.emplace_back(t.begin(), t.end());
    }
    return make_soup(mesh.points, faces);
}

PolygonSoup moved(PolygonSoup soup, const test::Motion& motion) {
    soup.points = motion(soup.points);
    return soup;
}

/// The unit cube as six quads, facing outward.
PolygonSoup cube() {
    return make_soup({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}},
                     {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}});
}

/// The soup with the faces reversed whose bits are set.
PolygonSoup with_reversed(const PolygonSoup& soup, std::uint64_t bits) {
    auto faces = test::faces_of(soup);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        if ((bits >> f & 1U) != 0) {
            std::reverse(faces[f].begin(), faces[f].end());
        }
    }
    return make_soup(soup.points, faces);
}

/// Volume enclosed, positive if the fronts are outside.
double signed_volume(const Mesh& mesh) {
    double volume = 0.0;
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3 origin = mesh.points[0];
        volume += (mesh.points[a] - origin).dot((mesh.points[b] - origin).cross(mesh.points[c] - origin)) / 6.0;
    }
    return volume;
}

// What is left alone ----------------------------------------------------------------------------------------------

TEST(Diagnosis, SoundMeshIsLeftAsItIs) {
    const Mesh ball = test::icosphere(2);
    const DiagnosedMesh result = diagnose(soup_of(ball));
    EXPECT_THAT(result.diagnosis.findings, IsEmpty());
    EXPECT_EQ(result.mesh.triangles, ball.triangles);
    EXPECT_EQ(result.mesh.points, ball.points);
    EXPECT_EQ(result.mesh.original_face, ball.original_face);
    EXPECT_EQ(result.mesh.areas, ball.areas);
    EXPECT_EQ(result.diagnosis.file_faces, 320U);
    EXPECT_EQ(result.diagnosis.file_points, 162U);
}

TEST(Diagnosis, QuadsBecomeTrianglesThatKnowTheirFace) {
    const DiagnosedMesh result = diagnose(cube());
    EXPECT_EQ(counts(result.diagnosis), (Counts{{"polygons", 6}}));
    EXPECT_THAT(result.mesh.original_face, ElementsAre(0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5));
    EXPECT_DOUBLE_EQ(result.mesh.area, 6.0);
    EXPECT_DOUBLE_EQ(signed_volume(result.mesh), 1.0);
}

// What is refused -------------------------------------------------------------------------------------------------

TEST(Diagnosis, IndexOutOfRange) {
    const std::string message = refusal(make_soup({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}));
    EXPECT_THAT(message, AllOf(HasSubstr("scene.obj:101: "), HasSubstr("face 1 (line 101)"), HasSubstr("point 3"),
                               HasSubstr("has 3 points"), HasSubstr("Correct the number")));
    EXPECT_THAT(refusal(make_soup({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, none}})),
                HasSubstr("face 0 (line 100) names a point before the first"));
}

TEST(Diagnosis, CoordinatesThatAreNotFinite) {
    for (const double bad : {nan, infinity, -infinity}) {
        PolygonSoup soup = cube();
        soup.points[6].y() = bad;
        soup.point_line = {1, 2, 3, 4, 5, 6, 7, 8};
        EXPECT_THAT(refusal(soup), AllOf(HasSubstr("point 6 (line 7)"), HasSubstr("face 1 (line 101)"),
                                         HasSubstr("finite number"), HasSubstr("(1, ")));
        // Where no face uses it, it does no harm.
        soup = cube();
        soup.points.emplace_back(0, bad, 0);
        EXPECT_EQ(counts(diagnose(soup).diagnosis), (Counts{{"polygons", 6}, {"unreferenced-points", 1}}));
    }
}

TEST(Diagnosis, CoordinatesWhoseAreasOverflow) {
    EXPECT_THAT(refusal(make_soup({{0, 0, 0}, {1e76, 0, 0}, {0, 1e76, 0}}, {{0, 1, 2}})), HasSubstr("unit of length"));
    EXPECT_DOUBLE_EQ(diagnose(make_soup({{0, 0, 0}, {1e75, 0, 0}, {0, 1e75, 0}}, {{0, 1, 2}})).mesh.area, 5e149);
    EXPECT_DOUBLE_EQ(diagnose(make_soup({{0, 0, 0}, {1e-75, 0, 0}, {0, 1e-75, 0}}, {{0, 1, 2}})).mesh.area, 5e-151);
}

TEST(Diagnosis, PolygonThatCrossesItself) {
    PolygonSoup soup = cube();
    soup.add_face(std::vector<Index>{0, 1, 6, 7}, none, 40);
    EXPECT_EQ(refusal(soup), ""); // a plane quad through the cube
    soup.add_face(std::vector<Index>{0, 6, 1, 7}, none, 41);
    EXPECT_THAT(refusal(soup), AllOf(HasSubstr("scene.obj:41: face 7 (line 41) crosses itself near ("),
                                     HasSubstr("order of its corners")));
}

TEST(Diagnosis, MaterialsThatReflectMoreThanAllOrEmitLessThanNothing) {
    const auto with = [](const Rgb& rho, const Rgb& emission, bool used) {
        PolygonSoup soup = cube();
        soup.materials = {Material{"plaster", Rgb::Constant(0.5), Rgb::Zero(), false},
                          Material{"lamp", rho, emission, false}};
        soup.face_material.assign(6, 0);
        soup.face_material[4] = used ? 1 : 0;
        return refusal(soup);
    };
    EXPECT_EQ(with(Rgb(0, 0.5, 1), Rgb(0, 1, 1e9), true), "");
    for (const double bad : {-1e-9, 1.0 + 1e-9, nan, infinity}) {
        EXPECT_THAT(with(Rgb(0.5, 0.5, bad), Rgb::Zero(), true),
                    AllOf(HasSubstr("\"lamp\""), HasSubstr("reflectance"), HasSubstr("face 4 (line 104)")));
        EXPECT_EQ(with(Rgb(0.5, 0.5, bad), Rgb::Zero(), false), "");
    }
    for (const double bad : {-1e-9, nan, infinity}) {
        EXPECT_THAT(with(Rgb::Zero(), Rgb(0, bad, 0), true), AllOf(HasSubstr("\"lamp\""), HasSubstr("emission")));
    }
}

TEST(Diagnosis, NothingLeftSaysWhereTheFacesWent) {
    EXPECT_THAT(refusal(make_soup({{0, 0, 0}, {1, 0, 0}}, {})), HasSubstr("no faces (2 points)"));
    EXPECT_THAT(refusal(make_soup({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, {{0, 1, 2}, {0, 1}, {}})),
                AllOf(HasSubstr("none of the 3 faces"), HasSubstr("1 zero-area face: left out (face 0 (line 100)"),
                      HasSubstr("2 faces with fewer than three distinct corners: left out (face 1 (line 101)")));
}

// What is left out and merged -------------------------------------------------------------------------------------

TEST(Diagnosis, EveryFaceAndPointIsAccountedFor) {
    PolygonSoup soup = cube();
    const std::vector<std::vector<Index>> extra{
        {0, 0, 1},              // 6: two corners
        {2, 2, 2, 2},           // 7: one corner
        {0, 8, 1},              // 8: on a line
        {0, 1, 2, 1},           // 9: there and back
        {6, 7, 4, 5},           // 10: face 1 from another corner
        {1, 2, 3, 0},           // 11: face 0 from behind
        {0, 1, 1, 7},           // 12: triangle with a repeated corner
        {9, 10, 11},            // 13: the same triangle on points of its own
        {0, 1, 13, 1, 6, 7, 0}, // 14: a spike to a point of its own, and a repetition of the first corner
    };
    soup.points.insert(soup.points.end(), {{0.5, 0, 0}, {0, -0.0, 0}, {1, 0, 0}, {0, 1, 1}, {7, 7, 7}, {3, 3, 3}});
    for (const auto& face : extra) {
        soup.add_face(face, none, static_cast<std::uint32_t>(100 + soup.face_count()));
    }
    const DiagnosedMesh result = diagnose(soup);
    const Counts found = counts(result.diagnosis);
    EXPECT_EQ(found.at("too-few-corners"), 2U);
    EXPECT_EQ(found.at("zero-area-faces"), 2U);
    EXPECT_EQ(found.at("duplicate-faces"), 2U); // 10 and 13
    EXPECT_EQ(found.at("two-sided-sheets"), 1U);
    EXPECT_EQ(found.at("repeated-corners"), 2U);
    EXPECT_EQ(found.at("duplicate-points"), 3U);
    EXPECT_EQ(found.at("unreferenced-points"), 1U);
    EXPECT_EQ(found.at("orphaned-points"), 2U); // the middle of face 8, the tip of face 14
    EXPECT_THAT(result.mesh.original_face, ElementsAre(0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 11, 11, 12, 14, 14));
    EXPECT_EQ(result.mesh.points.size(), 8U);
    EXPECT_THAT(finding(result.diagnosis, "duplicate-faces").places,
                ElementsAre("face 10 (line 110) near (0, 0, 1)", "face 13 (line 113) near (0, 0, 0)"));
    EXPECT_THAT(finding(result.diagnosis, "unreferenced-points").places, ElementsAre("point 12 at (7, 7, 7)"));
}

TEST(Diagnosis, SpikesAndRepetitionsAreRemovedWhereverTheFaceStarts) {
    const std::vector<Vec3> points{{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}, {-1, -1, 0}, {-2, -3, 0}};
    std::vector<Index> face{0, 4, 5, 4, 0, 0, 1, 2, 3}; // a spike of two sides at corner 0, which is repeated
    for (std::size_t start = 0; start < face.size(); ++start) {
        const DiagnosedMesh result = diagnose(make_soup(points, {face}));
        EXPECT_EQ(counts(result.diagnosis),
                  (Counts{{"repeated-corners", 1}, {"orphaned-points", 2}, {"polygons", 1}, {"border-edges", 4}}));
        EXPECT_DOUBLE_EQ(result.mesh.area, 2.0);
        std::rotate(face.begin(), face.begin() + 1, face.end());
    }
}

TEST(Diagnosis, NeedlesAreKeptAndLinesAreNotWhateverTheScale) {
    for (const test::Motion& motion : test::motions()) {
        SCOPED_TRACE(motion.name);
        const DiagnosedMesh result = diagnose(moved(make_soup({{0, 0, 0},
                                                               {1, 0, 0},
                                                               {0.5, 1e-6, 0},
                                                               {1.0 / 3, 0, 0},
                                                               {0.1, 0.2, 0.3},
                                                               {0.3, 0.6, 0.9},
                                                               {0.7, 1.4, 2.1}},
                                                              {{0, 1, 2}, {0, 1, 3}, {4, 5, 6}}),
                                                    motion));
        EXPECT_THAT(result.mesh.original_face, ElementsAre(0));
        EXPECT_EQ(counts(result.diagnosis)["zero-area-faces"], 2U);
    }
}

TEST(Diagnosis, PointsMergeOnlyIfExactlyEqual) {
    const double next = std::nextafter(1.0, 2.0);
    const DiagnosedMesh result = diagnose(
        make_soup({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-0.0, 1, 0}, {next, 0, 0}, {1, 1, 0}}, {{0, 1, 2}, {3, 4, 5}}));
    EXPECT_EQ(counts(result.diagnosis)["duplicate-points"], 1U);
    EXPECT_EQ(result.mesh.points.size(), 5U);
    EXPECT_EQ(result.mesh.triangles[1][0], result.mesh.triangles[0][2]);
}

TEST(Diagnosis, ColoursStayWithTheirCornersWhenPointsMerge) {
    PolygonSoup soup = make_soup({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}},
                                 {{0, 1, 2}, {4, 3, 5}, {0, 2, 1}});
    soup.materials = {Material{"painted", Rgb::Zero(), Rgb::Zero(), true}, Material{"plain", {}, Rgb::Zero(), false}};
    soup.materials[1].reflectance = Rgb::Constant(0.25);
    soup.face_material = {0, 0, 1};
    for (int p = 0; p < 6; ++p) {
        soup.point_reflectance.push_back(Rgb::Constant(0.1 * p));
    }
    const DiagnosedMesh result = diagnose(soup);
    ASSERT_EQ(result.mesh.points.size(), 4U);
    ASSERT_EQ(result.mesh.corner_reflectance.size(), 3U);
    // Each corner has the colour of the point that the file names there.
    for (const std::size_t t : {0U, 1U}) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3& position = result.mesh.points[result.mesh.triangles[t][k]];
            const double colour = result.mesh.corner_reflectance[t][k][0];
            const auto named = static_cast<std::size_t>(std::lround(colour * 10));
            EXPECT_EQ(soup.points[named], position);
            EXPECT_EQ(named >= 3, t == 1);
        }
    }
    soup.point_reflectance[5][1] = 1.5;
    EXPECT_THAT(refusal(soup), AllOf(HasSubstr("point 5"), HasSubstr("face 1"), HasSubstr("\"painted\"")));
    soup.face_material[1] = 1; // then nobody looks at that colour
    EXPECT_EQ(refusal(soup), "");
}

TEST(Diagnosis, ColoursTurnWithTheirFace) {
    PolygonSoup soup = make_soup({{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, 1.2, 0}}, {{0, 1, 2}, {1, 2, 3}});
    soup.materials = {Material{"painted", Rgb::Zero(), Rgb::Zero(), true}};
    soup.face_material = {0, 0};
    soup.point_reflectance = {Rgb::Constant(0), Rgb::Constant(0.1), Rgb::Constant(0.2), Rgb::Constant(0.3)};
    const DiagnosedMesh result = diagnose(soup);
    EXPECT_EQ(counts(result.diagnosis)["inconsistent-orientation"], 1U);
    for (std::size_t t = 0; t < 2; ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_DOUBLE_EQ(result.mesh.corner_reflectance[t][k][0], 0.1 * result.mesh.triangles[t][k]);
        }
    }
}

TEST(Diagnosis, MaterialsAndTheDefault) {
    PolygonSoup soup = cube();
    soup.materials = {Material{"a", {}, Rgb::Zero(), false}, Material{"b", {}, Rgb::Zero(), false}};
    soup.materials[0].reflectance = soup.materials[1].reflectance = Rgb::Constant(0.5);
    soup.face_material = {1, none, 0, none, 1, 1};
    EXPECT_THAT(diagnose(soup).mesh.material, ElementsAre(1, 1, 2, 2, 0, 0, 2, 2, 1, 1, 1, 1));
}

TEST(Diagnosis, PartsOfAFaceThatAnotherCoversAgain) {
    // Cut along its shorter diagonal, the quad has the triangle as a half.
    const DiagnosedMesh result =
        diagnose(make_soup({{0, 0, 0}, {1, 0, 0}, {1.5, 1, 0}, {0, 1, 0}}, {{1, 3, 0}, {0, 1, 2, 3}}));
    EXPECT_EQ(counts(result.diagnosis)["duplicate-pieces"], 1U);
    EXPECT_THAT(result.mesh.original_face, ElementsAre(0, 1));
    EXPECT_DOUBLE_EQ(result.mesh.area, 1.25);
}

TEST(Diagnosis, DuplicatesAreFoundFromAnyCorner) {
    // A square has two equal diagonals: copies must be cut alike to be recognised.
    const std::vector<Vec3> square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    for (Index start = 0; start < 4; ++start) {
        const std::vector<Index> same{start, (start + 1) % 4, (start + 2) % 4, (start + 3) % 4};
        const std::vector<Index> behind(same.rbegin(), same.rend());
        EXPECT_EQ(counts(diagnose(make_soup(square, {{0, 1, 2, 3}, same})).diagnosis)["duplicate-faces"], 1U);
        const DiagnosedMesh sheet = diagnose(make_soup(square, {{0, 1, 2, 3}, behind}));
        EXPECT_EQ(counts(sheet.diagnosis),
                  (Counts{{"two-sided-sheets", 1}, {"polygons", 2}, {"non-manifold-edges", 1}}));
        EXPECT_DOUBLE_EQ(sheet.mesh.area, 2.0);
        EXPECT_DOUBLE_EQ(sheet.mesh.normals[0].z(), 1.0);
        EXPECT_DOUBLE_EQ(sheet.mesh.normals[2].z(), -1.0);
    }
}

// Polygons --------------------------------------------------------------------------------------------------------

TEST(Diagnosis, ConcaveAndNonPlanarPolygonsAreNamed) {
    const DiagnosedMesh result =
        diagnose(make_soup({{0, 0, 0}, {3, 0, 0}, {1, 1, 0}, {0, 3, 0}, {0, 0, 5}, {1, 0, 5.5}, {1, 1, 5}, {0, 1, 5.5}},
                           {{0, 1, 2, 3}, {4, 5, 6, 7}}));
    EXPECT_EQ(counts(result.diagnosis)["concave-polygons"], 1U);
    EXPECT_THAT(finding(result.diagnosis, "concave-polygons").places, ElementsAre("face 0 (line 100) near (0, 0, 0)"));
    EXPECT_EQ(counts(result.diagnosis)["non-planar-polygons"], 1U);
    EXPECT_THAT(finding(result.diagnosis, "non-planar-polygons").places,
                ElementsAre("face 1 (line 101) near (0, 0, 5)"));
    EXPECT_DOUBLE_EQ(result.mesh.areas[0] + result.mesh.areas[1], 3.0);
}

// Orientation -----------------------------------------------------------------------------------------------------

TEST(Diagnosis, CubeWithAnyFacesReversedIsRestored) {
    for (std::uint64_t bits = 0; bits < 64; ++bits) {
        SCOPED_TRACE(bits);
        const PolygonSoup soup = with_reversed(cube(), bits);
        const auto reversed = static_cast<std::size_t>(std::popcount(bits));
        // The majority decides; of three against three, the first face.
        const bool inward = reversed > 3 || (reversed == 3 && (bits & 1U) != 0);
        for (const test::Motion& motion : test::motions()) {
            SCOPED_TRACE(motion.name);
            const DiagnosedMesh result = diagnose(moved(soup, motion));
            EXPECT_EQ(counts(result.diagnosis)["inconsistent-orientation"], inward ? 6 - reversed : reversed);
            const double volume = std::pow(motion.scale, 3);
            EXPECT_NEAR(signed_volume(result.mesh), inward ? -volume : volume, 1e-8 * volume);
            EXPECT_EQ(counts(result.diagnosis).count("border-edges"), 0U);
        }
    }
}

TEST(Diagnosis, BallWithRandomFacesReversedIsRestored) {
    const Mesh ball = test::icosphere(3);
    for (std::uint64_t i = 0; i < 10; ++i) {
        RandomStream random(4, "reversed", i);
        std::vector<std::vector<Index>> faces;
        std::vector<double> areas;
        double reversed_area = 0.0;
        std::size_t reversed = 0;
        for (std::size_t t = 0; t < ball.triangles.size(); ++t) {
            faces.emplace_back(ball.triangles[t].begin(), ball.triangles[t].end());
            if (random.below(2) == 0) {
                std::swap(faces.back()[0], faces.back()[1]);
                reversed_area += ball.areas[t];
                ++reversed;
            }
        }
        const DiagnosedMesh result = diagnose(make_soup(ball.points, faces));
        const bool inward = reversed_area > 0.5 * ball.area;
        EXPECT_NEAR(signed_volume(result.mesh), (inward ? -1 : 1) * signed_volume(ball), 1e-12);
        EXPECT_EQ(counts(result.diagnosis),
                  (Counts{{"inconsistent-orientation", inward ? faces.size() - reversed : reversed}}));
    }
}

TEST(Diagnosis, AreaDecidesNotTheNumberOfFaces) {
    // Ten thin strips against one wide face.
    std::vector<Vec3> points{{-100, 0, 0}, {-100, 1, 0}};
    std::vector<std::vector<Index>> faces;
    for (Index i = 0; i <= 10; ++i) {
        points.emplace_back(i, 0, 0);
        points.emplace_back(i, 1, 0);
    }
    faces.push_back({0, 2, 3, 1});
    for (Index i = 1; i <= 10; ++i) {
        faces.push_back({2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2}); // facing down
    }
    const DiagnosedMesh result = diagnose(make_soup(points, faces));
    EXPECT_EQ(counts(result.diagnosis)["inconsistent-orientation"], 10U);
    for (const Vec3& normal : result.mesh.normals) {
        EXPECT_DOUBLE_EQ(normal.z(), 1.0);
    }
}

TEST(Diagnosis, OrientationStopsAtEdgesOfThreeFaces) {
    Mesh book = test::book(3);
    std::swap(book.triangles[0][1], book.triangles[0][2]); // both triangles of one page
    std::swap(book.triangles[1][1], book.triangles[1][2]);
    const DiagnosedMesh result = diagnose(soup_of(book));
    EXPECT_EQ(counts(result.diagnosis), (Counts{{"non-manifold-edges", 1}, {"border-edges", 9}}));
    EXPECT_THAT(finding(result.diagnosis, "non-manifold-edges").places,
                ElementsAre("face 1 (line 101) near (0, 0, 0.5)"));
    EXPECT_EQ(result.mesh.triangles, book.triangles);
}

TEST(Diagnosis, MoebiusStripIsReportedAndLeftAlone) {
    for (const int segments : {5, 6, 50}) {
        const Mesh strip = test::mobius(segments);
        const DiagnosedMesh result = diagnose(soup_of(strip));
        const auto borders = static_cast<std::size_t>(2 * segments);
        EXPECT_EQ(counts(result.diagnosis), (Counts{{"one-sided-pieces", 1}, {"border-edges", borders}}));
        EXPECT_EQ(result.mesh.triangles, strip.triangles);
    }
    // Two strips are two pieces.
    const Mesh two = test::together(test::mobius(7), test::moved(test::mobius(9), 1.0, Vec3(5, 0, 0)));
    EXPECT_EQ(counts(diagnose(soup_of(two)).diagnosis)["one-sided-pieces"], 2U);
}

// Topology --------------------------------------------------------------------------------------------------------

TEST(Diagnosis, EulerCountOfBorders) {
    const DiagnosedMesh result = diagnose(soup_of(test::grid(7, 4)));
    EXPECT_EQ(counts(result.diagnosis), (Counts{{"border-edges", 22}}));
}

TEST(Diagnosis, TouchingTipsAreNonManifoldVertices) {
    const DiagnosedMesh result =
        diagnose(make_soup({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}}, {{0, 1, 2}, {0, 3, 4}}));
    EXPECT_EQ(counts(result.diagnosis), (Counts{{"non-manifold-vertices", 1}, {"border-edges", 6}}));
    EXPECT_THAT(finding(result.diagnosis, "non-manifold-vertices").places,
                ElementsAre("face 0 (line 100) near (0, 0, 0)"));
    EXPECT_EQ(finding(result.diagnosis, "border-edges").message(),
              "6 border edges (face 0 (line 100) near (0.5, 0, 0); face 0 (line 100) near (0.5, 0.5, 0); face 1 (line "
              "101) near (-0.5, 0, 0); ...)");
}

// Identities ------------------------------------------------------------------------------------------------------

TEST(Diagnosis, VerdictsDoNotDependOnTheOrderOfFaces) {
    PolygonSoup soup = with_reversed(cube(), 0b000100);
    for (const auto& face : std::vector<std::vector<Index>>{{0, 0, 1}, {6, 7, 4, 5}, {1, 2, 3, 0}, {0, 1, 0}}) {
        soup.add_face(face, none, 0);
    }
    const Counts expected = counts(diagnose(soup).diagnosis);
    auto faces = test::faces_of(soup);
    RandomStream random(5, "order");
    for (int round = 0; round < 100; ++round) {
        for (std::size_t i = faces.size(); i > 1; --i) {
            std::swap(faces[i - 1], faces[random.below(i)]);
        }
        EXPECT_EQ(counts(diagnose(make_soup(soup.points, faces)).diagnosis), expected);
    }
}

/// What mesh.h promises.
void expect_invariants(const Mesh& mesh, std::size_t file_faces) {
    ASSERT_FALSE(mesh.triangles.empty());
    EXPECT_EQ(mesh.original_face.size(), mesh.triangles.size());
    EXPECT_EQ(mesh.material.size(), mesh.triangles.size());
    EXPECT_TRUE(std::is_sorted(mesh.original_face.begin(), mesh.original_face.end()));
    EXPECT_LT(mesh.original_face.back(), file_faces);
    std::vector<char> named(mesh.points.size(), 0);
    for (const auto& triangle : mesh.triangles) {
        for (const Index corner : triangle) {
            ASSERT_LT(corner, mesh.points.size());
            named[corner] = 1;
        }
    }
    EXPECT_EQ(std::count(named.begin(), named.end(), 0), 0);
    EXPECT_THAT(mesh.areas, testing::Each(testing::Gt(0.0)));
    for (const Vec3& normal : mesh.normals) {
        EXPECT_NEAR(normal.norm(), 1.0, 1e-12);
    }
    std::vector<std::array<double, 3>> places;
    for (const Vec3& point : mesh.points) {
        EXPECT_TRUE(point.allFinite());
        places.push_back({point.x() + 0.0, point.y() + 0.0, point.z() + 0.0});
    }
    std::sort(places.begin(), places.end());
    EXPECT_EQ(std::adjacent_find(places.begin(), places.end()), places.end());
}

/// Nothing disappears uncounted.
void expect_accounts(const DiagnosedMesh& result) {
    Counts found = counts(result.diagnosis);
    std::vector<Index> faces = result.mesh.original_face;
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    EXPECT_EQ(result.diagnosis.file_faces,
              faces.size() + found["too-few-corners"] + found["zero-area-faces"] + found["duplicate-faces"]);
    EXPECT_EQ(result.diagnosis.file_points, result.mesh.points.size() + found["duplicate-points"] +
                                                found["unreferenced-points"] + found["orphaned-points"]);
    for (const Finding& each : result.diagnosis.findings) {
        EXPECT_GT(each.count, 0U);
        EXPECT_EQ(each.places.size(), std::min<std::size_t>(each.count, 3));
    }
}

TEST(Diagnosis, RandomSoupsGiveAMeshOrAnInputError) {
    // Few places, so that everything coincides and crosses; each kind of soup must both pass and fail often enough.
    int meshes = 0, refused = 0;
    for (std::uint64_t i = 0; i < 3000; ++i) {
        SCOPED_TRACE(i);
        RandomStream random(1, "soup", i);
        const std::uint64_t grid = 2 + random.below(4), most_corners = 2 + random.below(5);
        const double scale = std::pow(10.0, static_cast<double>(random.below(13)) - 6.0);
        const double offset = random.below(3) == 0 ? 1e6 * scale : 0.0;
        const bool flat = random.below(2) == 0, noisy = random.below(3) == 0, hostile = random.below(6) == 0;
        std::vector<Vec3> points;
        for (std::uint64_t p = 0, n = 1 + random.below(20); p < n; ++p) {
            const auto coordinate = [&] {
                return offset + scale * (static_cast<double>(random.below(grid)) + (noisy ? random.uniform() : 0.0));
            };
            points.emplace_back(coordinate(), coordinate(), flat ? 0.0 : coordinate());
            if (hostile && random.below(8) == 0) {
                points.back()[static_cast<Eigen::Index>(random.below(3))] =
                    std::array{nan, infinity, -0.0, 1e300, 5e-324}[random.below(5)];
            }
        }
        std::vector<std::vector<Index>> faces(random.below(25));
        for (auto& face : faces) {
            face.resize(random.below(most_corners + 1));
            for (Index& corner : face) {
                corner = static_cast<Index>(random.below(points.size() + (hostile ? 1 : 0)));
            }
        }
        const PolygonSoup soup = make_soup(points, faces);
        try {
            const DiagnosedMesh result = diagnose(soup);
            expect_invariants(result.mesh, faces.size());
            expect_accounts(result);
            ++meshes;
        } catch (const InputError& error) {
            EXPECT_THAT(error.what(), testing::StartsWith("scene.obj:"));
            ++refused;
        }
    }
    EXPECT_GT(meshes, 500);
    EXPECT_GT(refused, 500);
}

TEST(Diagnosis, ScalingByAPowerOfTwoChangesNoBit) {
    for (std::uint64_t i = 0; i < 200; ++i) {
        RandomStream random(2, "soup", i);
        std::vector<Vec3> points;
        for (int p = 0; p < 12; ++p) {
            points.emplace_back(random.uniform(), random.uniform(), 0.1 * random.uniform());
        }
        std::vector<std::vector<Index>> faces(6);
        for (auto& face : faces) {
            for (std::uint64_t k = 0, n = 3 + random.below(2); k < n; ++k) {
                face.push_back(static_cast<Index>(random.below(12)));
            }
        }
        const PolygonSoup soup = make_soup(points, faces);
        const auto verdict = [&](double scale) -> std::string {
            try {
                const DiagnosedMesh result = diagnose(moved(soup, {"", scale, Eigen::Matrix3d::Identity(), {0, 0, 0}}));
                std::string text;
                for (const Finding& each : result.diagnosis.findings) {
                    text += each.code + std::to_string(each.count) + " ";
                }
                for (const auto& [a, b, c] : result.mesh.triangles) {
                    text += std::to_string(a) + "," + std::to_string(b) + "," + std::to_string(c) + " ";
                }
                return text;
            } catch (const InputError&) {
                return "refused";
            }
        };
        const std::string expected = verdict(1.0);
        EXPECT_EQ(verdict(0x1p-20), expected);
        EXPECT_EQ(verdict(0x1p20), expected);
    }
}

TEST(Diagnosis, ManyFacesAroundOneVertexOrEdge) {
    // Quadratic work would take hours here.
    constexpr Index n = 300000;
    std::vector<Vec3> fan{{0, 0, 1}}, edge{{0, 0, 0}, {0, 0, 1}};
    std::vector<std::vector<Index>> fan_faces, edge_faces;
    for (Index i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * i / n;
        fan.emplace_back(std::cos(angle), std::sin(angle), 0.0);
        edge.emplace_back(std::cos(angle), std::sin(angle), 0.0);
        fan_faces.push_back({0, i + 1, (i + 1) % n + 1});
        edge_faces.push_back({0, 1, i + 2});
    }
    EXPECT_EQ(counts(diagnose(make_soup(fan, fan_faces)).diagnosis),
              (Counts{{"border-edges", n}, {"crossing-faces-unknown", 1}}));
    EXPECT_EQ(counts(diagnose(make_soup(edge, edge_faces)).diagnosis),
              (Counts{{"non-manifold-edges", 1}, {"border-edges", 2 * n}, {"crossing-faces-unknown", 1}}));
}

TEST(Diagnosis, FacesThatCross) {
    const std::vector<Vec3> floor{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
    const auto with_wall = [&](double low, double lean) {
        std::vector<Vec3> points = floor;
        for (const Vec3& p : {Vec3(0.75 + lean * low, 0.5, low), Vec3(0.75 + lean * low, 1.5, low),
                              Vec3(0.75 + lean, 1.5, 1), Vec3(0.75 + lean, 0.5, 1)}) {
            points.push_back(p);
        }
        return diagnose(make_soup(points, {{0, 1, 2, 3}, {4, 5, 6, 7}})).diagnosis;
    };
    for (const double lean : {0.0, 0.5}) {
        // One pair of faces, although several of their triangles cross.
        const Diagnosis through = with_wall(-0.25, lean);
        EXPECT_EQ(counts(through)["crossing-faces"], 1U);
        EXPECT_THAT(finding(through, "crossing-faces").places,
                    ElementsAre(HasSubstr("face 0 (line 100) and face 1 (line 101) near (0.75, ")));
        EXPECT_FALSE(finding(through, "crossing-faces").repaired);
        EXPECT_EQ(counts(with_wall(0.0, lean)).count("crossing-faces"), 0U) << "stands on it";
        EXPECT_EQ(counts(with_wall(0.25, lean)).count("crossing-faces"), 0U) << "above it";
    }
    // Overlaps in one plane, neighbours at an edge or a vertex, and a vertex from which a triangle does cross another.
    const auto crossings = [](const std::vector<Vec3>& points, const std::vector<std::vector<Index>>& faces) {
        return counts(diagnose(make_soup(points, faces)).diagnosis)["crossing-faces"];
    };
    EXPECT_EQ(crossings({{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, 0, 0}, {3, 0, 0}, {1, 2, 0}}, {{0, 1, 2}, {3, 4, 5}}),
              0U);
    EXPECT_EQ(crossings({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2}, {1, 0, 3}}), 0U);
    EXPECT_EQ(crossings({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 1}, {-1, 0, -1}}, {{0, 1, 2}, {0, 3, 4}}), 0U);
    EXPECT_EQ(crossings({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1}, {1, 1, -1}}, {{0, 1, 2}, {0, 3, 4}}), 1U);
}

// Textures and double-sided materials -----------------------------------------------------------------------------

std::shared_ptr<const Texture> even_texture(float value) {
    return std::make_shared<const Texture>(Image{1, 1, {{value, value, value}}});
}

TEST(Diagnosis, TextureCoordinatesStayWithTheirCorners) {
    // A quad that is cut, a face that is turned over, and one whose material has no texture. Each corner's coordinates
    // are its x and y plus ten times its face, so that a mix-up shows.
    PolygonSoup soup = make_soup({{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {4, 0, 0}, {2, 0, 0}, {9, 9, 1}},
                                 {{3, 0, 1, 2}, {5, 2, 4}, {0, 1, 6}});
    Material picture{"picture", Rgb::Constant(0.5), Rgb::Zero()}, plain{"plain", Rgb::Constant(0.5), Rgb::Zero()};
    picture.reflectance_texture = even_texture(1.0F);
    soup.materials = {picture, plain};
    soup.face_material = {0, 0, 1};
    for (std::size_t f = 0; f < soup.face_count(); ++f) {
        for (const Index p : soup.face(f)) {
            soup.corner_texture.push_back(soup.points[p].head<2>().array() + 10.0 * static_cast<double>(f));
        }
    }
    soup.corner_texture[9] = {nan, nan}; // of the face without a texture: nobody looks
    const DiagnosedMesh result = diagnose(soup);
    EXPECT_EQ(counts(result.diagnosis)["inconsistent-orientation"], 1U);
    ASSERT_EQ(result.mesh.corner_texture.size(), 4U);
    for (std::size_t t = 0; t < 3; ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3& position = result.mesh.points[result.mesh.triangles[t][k]];
            EXPECT_EQ(result.mesh.corner_texture[t][k],
                      TextureCoordinates(position.head<2>().array() + 10.0 * result.mesh.original_face[t]));
        }
    }
    for (const TextureCoordinates& none_here : result.mesh.corner_texture[3]) {
        EXPECT_EQ(none_here, TextureCoordinates(0, 0));
    }
    soup.corner_texture[1] = {nan, 0};
    EXPECT_THAT(refusal(soup), AllOf(HasSubstr("face 0"), HasSubstr("texture coordinates"), HasSubstr("\"picture\"")));
    soup.corner_texture.clear();
    EXPECT_THAT(refusal(soup), HasSubstr("texture coordinates"));
}

TEST(Diagnosis, ATextureMayNotReflectMoreThanAll) {
    PolygonSoup soup = make_soup({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
    Material material{"snow", Rgb::Constant(0.5), Rgb::Zero()};
    soup.face_material = {0};
    soup.corner_texture.assign(3, TextureCoordinates::Zero());
    material.reflectance_texture = even_texture(2.0F);
    soup.materials = {material};
    EXPECT_EQ(refusal(soup), "");
    soup.materials[0].reflectance_texture = even_texture(2.5F);
    EXPECT_THAT(refusal(soup), AllOf(HasSubstr("\"snow\""), HasSubstr("1.25")));
}

/// Two triangles that make a roof, the second material double-sided.
PolygonSoup roof() {
    PolygonSoup soup =
        make_soup({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0.25}, {5, -1, 0}}, {{0, 1, 2}, {2, 1, 3}, {0, 4, 1}});
    soup.materials = {Material{"one", Rgb::Constant(0.5), Rgb::Zero()},
                      Material{"two", Rgb::Constant(0.5), Rgb::Zero()}};
    soup.materials[1].double_sided = true;
    soup.face_material = {1, 1, 0};
    return soup;
}

TEST(Diagnosis, DoubleSidedFacesGetBacksThatAreFronts) {
    PolygonSoup soup = roof();
    soup.materials[1].vertex_colours = true;
    for (std::size_t p = 0; p < soup.points.size(); ++p) {
        soup.point_reflectance.push_back(Rgb::Constant(0.1 * static_cast<double>(p)));
    }
    const DiagnosedMesh result = diagnose(soup);
    const Mesh& mesh = result.mesh;
    EXPECT_EQ(counts(result.diagnosis), (Counts{{"double-sided-faces", 2}, {"border-edges", 5}}));
    EXPECT_FALSE(finding(result.diagnosis, "double-sided-faces").repaired);
    ASSERT_EQ(mesh.triangles.size(), 5U);
    EXPECT_THAT(mesh.original_face, ElementsAre(0, 1, 2, 0, 1));
    EXPECT_THAT(mesh.material, ElementsAre(1, 1, 0, 1, 1));
    for (const auto& [front, back] : {std::pair{0U, 3U}, std::pair{1U, 4U}}) {
        EXPECT_EQ(mesh.normals[back], -mesh.normals[front]);
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_EQ(mesh.triangles[back][k], mesh.triangles[front][(3 - k) % 3]);
            EXPECT_EQ(mesh.corner_reflectance[back][k][0], 0.1 * mesh.triangles[back][k]);
        }
    }
    // Each side is one region, and the two are apart.
    EXPECT_EQ(mesh.region[0], mesh.region[1]);
    EXPECT_EQ(mesh.region[3], mesh.region[4]);
    EXPECT_NE(mesh.region[0], mesh.region[3]);
}

TEST(Diagnosis, BacksThatTheFileHasAreNotAddedAgain) {
    PolygonSoup soup = roof();
    auto faces = test::faces_of(soup);
    faces.push_back({3, 1, 2}); // the back of face 1
    PolygonSoup both = make_soup(soup.points, faces);
    both.materials = soup.materials;
    both.face_material = {1, 1, 0, 1};
    const DiagnosedMesh result = diagnose(both);
    EXPECT_EQ(result.mesh.triangles.size(), 5U);
    EXPECT_EQ(result.mesh.original_face.back(), 0U);
    EXPECT_EQ(counts(result.diagnosis)["duplicate-faces"], 0U);
    // The back may be of another material: then it is that.
    both.face_material[3] = 0;
    EXPECT_EQ(diagnose(both).mesh.triangles.size(), 5U);
}

TEST(Diagnosis, PlacesAreNamedByTheFilesOfAScene) {
    PolygonSoup soup = make_soup({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}},
                                 {{0, 1, 2}, {3, 4, 5}, {3, 3, 5}});
    soup.file = "scene.json";
    soup.parts = {{"a.obj", 0, 0}, {"empty.obj", 1, 3}, {"b.obj", 1, 3}};
    const DiagnosedMesh result = diagnose(soup);
    EXPECT_THAT(finding(result.diagnosis, "too-few-corners").places[0], HasSubstr("face 1 (line 102) of b.obj near"));
    ASSERT_EQ(result.diagnosis.parts.size(), 3U);
    soup.points[4][2] = nan;
    EXPECT_THAT(refusal(soup),
                AllOf(HasSubstr("b.obj:101: point 1 of b.obj"), HasSubstr("face 0 (line 101) of b.obj")));
}

} // namespace
} // namespace difusa
