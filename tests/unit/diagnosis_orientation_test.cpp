// Fronts, borders and vertices where faces do not make a surface.
#include <difusa/repair/diagnosis.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diagnosed.h"
#include "meshes.h"
#include "soups.h"
#include "support/sanitized.h"

namespace difusa::diagnosis_orientation_test {
namespace {

using test::make_soup;
using testing::ElementsAre;
using namespace diagnosed;

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

TEST(Diagnosis, ManyFacesAroundOneVertexOrEdge) {
    // Quadratic work would take hours here, and minutes under the sanitizers.
    const Index n = test::sanitized() ? 30000 : 300000;
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

} // namespace
} // namespace difusa::diagnosis_orientation_test
