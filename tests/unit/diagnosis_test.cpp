#include <difusa/repair/diagnosis.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diagnosed.h"
#include "meshes.h"
#include "soups.h"

namespace difusa::diagnosis_test {
namespace {

using test::make_soup;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using namespace diagnosed;

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
                HasSubstr("face 0 (line 100) refers to a point before the first"));
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
                AllOf(HasSubstr("none of its 3 faces"), HasSubstr("1 zero-area face: left out (face 0 (line 100)"),
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

TEST(Diagnosis, CanBeInterrupted) {
    struct Stop : Progress {
        bool cancelled() const override { return true; }
    } stop;
    EXPECT_THROW(diagnose(make_soup({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}), Execution{1, &stop}), Interrupted);
}

} // namespace
} // namespace difusa::diagnosis_test
