// What holds for the diagnosis of every soup.
#include <difusa/core/error.h>
#include <difusa/repair/diagnosis.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diagnosed.h"
#include "meshes.h"
#include "soups.h"

namespace difusa::diagnosis_invariants_test {
namespace {

using test::make_soup;
using namespace diagnosed;

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

} // namespace
} // namespace difusa::diagnosis_invariants_test
