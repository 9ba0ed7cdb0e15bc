#include <difusa/core/error.h>
#include <difusa/core/even_sequence.h>
#include <difusa/core/memory.h>
#include <difusa/core/random.h>
#include <difusa/form_factors/blockers.h>
#include <difusa/form_factors/by_rays.h>
#include <difusa/form_factors/closure.h>
#include <difusa/form_factors/form_factors.h>
#include <difusa/rays/brute_force.h>
#include <difusa/rays/direction_pool.h>
#include <difusa/rays/tracer.h>
#include <difusa/study/references/form_factors.h>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <meshes.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace difusa::form_factors_test {
namespace {

/// Surfaces of the given numbers of consecutive triangles.
Surfaces runs(const std::vector<std::size_t>& counts) {
    Surfaces surfaces;
    for (const std::size_t count : counts) {
        surfaces.of.insert(surfaces.of.end(), count, static_cast<Index>(surfaces.size()));
        surfaces.name.push_back("surface " + std::to_string(surfaces.size()));
    }
    return surfaces;
}

FormFactors compute(const Mesh& mesh, const Surfaces& surfaces, double tolerance = 1e-6, unsigned threads = 1) {
    return form_factors(mesh, surfaces, {tolerance}, Execution{threads});
}

/// The rectangle at z = height, facing up or down.
Mesh level(const Rectangle& r, double height, bool up, int n = 1) {
    return test::moved(test::grid(n, n, r.x1 - r.x0, r.y1 - r.y0, !up), 1.0, Vec3(r.x0, r.y0, height));
}

/// The box [-1,1]³ seen from inside around the cube [-1/2,1/2]³ seen from outside: 24 n² triangles.
Mesh room_with_cube(int n) {
    return test::together(test::moved(test::box({2, 2, 2}, n, true), 1.0, Vec3::Constant(-1.0)),
                          test::moved(test::box({1, 1, 1}, n), 1.0, Vec3::Constant(-0.5)));
}

TEST(FormFactorMatrix, SidesOfACube) {
    const Mesh cube = test::box({1, 1, 1}, 2, true);
    const FormFactors F = compute(cube, runs({8, 8, 8, 8, 8, 8}));
    for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t j = 0; j < 6; ++j) {
            const double exact = i == j ? 0.0 : i / 2 == j / 2 ? 0.199824895698387 : 0.200043776075403;
            EXPECT_NEAR(F.at(i, j), exact, 1e-8);
        }
    }
}

TEST(FormFactorMatrix, RowsOfAClosedConvexRoomSumToOne) {
    const Mesh room = test::box({3, 1, 2}, 4, true);
    const FormFactors F = compute(room, surfaces_by_face(room));
    const FormFactorLaws laws = check_laws(F, 1e-6);
    EXPECT_NEAR(laws.least_row_sum, 1.0, 1e-8);
    EXPECT_NEAR(laws.largest_row_sum, 1.0, 1e-8);
    EXPECT_LE(laws.reciprocity, 1e-15);
    EXPECT_EQ(laws.above_tolerance, 0U);
}

TEST(FormFactorMatrix, BlockedSquares) {
    for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
        const Rectangle unit, small{0.0, 0.5, 0.0, 0.5};
        const Mesh mesh =
            test::together(test::together(level(unit, 0.0, true), level(unit, 1.0, false)), level(small, 0.5, true));
        const FormFactors F = compute(mesh, runs({2, 2, 2}), tolerance);
        EXPECT_NEAR(F.at(0, 1), 0.1498686718, tolerance);
        EXPECT_LE(F.rows[0].error[0], tolerance);
    }
}

TEST(FormFactorMatrix, BlockersOfAnySizeAndPlace) {
    const Rectangle from{0.0, 1.0, 0.0, 1.0}, to{-0.2, 1.1, 0.1, 0.9};
    const std::vector<std::pair<Rectangle, double>> blockers{{{0.1, 0.15, -1.0, 2.0}, 0.3},
                                                             {{0.45, 0.47, 0.5, 0.52}, 0.9},
                                                             {{0.0, 1.0, 0.0, 0.6}, 0.05},
                                                             {{2.0, 3.0, 2.0, 3.0}, 0.5},
                                                             {{-9.0, 9.0, -9.0, 9.0}, 0.5}};
    for (const auto& [blocker, height] : blockers) {
        const Mesh mesh =
            test::together(test::together(level(from, 0.0, true), level(to, 1.0, false)), level(blocker, height, true));
        const FormFactors F = compute(mesh, runs({2, 2, 2}));
        EXPECT_NEAR(F.at(0, 1), blocked_rectangles(from, to, 1.0, blocker, height), 1e-6) << blocker.x0;
    }
}

/// All that leaves the cube arrives at the walls, so a quarter of what leaves the walls arrives at the cube.
TEST(FormFactorMatrix, CubeInARoom) {
    const FormFactors whole = compute(room_with_cube(1), runs({12, 12}), 1e-4);
    EXPECT_NEAR(whole.at(1, 0), 1.0, 1e-4);
    EXPECT_NEAR(whole.at(0, 1), 0.25, 1e-4);
    EXPECT_NEAR(whole.row_sum(0), 1.0, 2e-4);
    EXPECT_EQ(whole.at(1, 1), 0.0);
    const Mesh mesh = room_with_cube(2);
    const FormFactors F = compute(mesh, surfaces_by_face(mesh), 1e-5);
    const FormFactorLaws laws = check_laws(F, 1e-5);
    EXPECT_NEAR(laws.least_row_sum, 1.0, 1e-4);
    EXPECT_NEAR(laws.largest_row_sum, 1.0, 1e-4);
}

TEST(FormFactorMatrix, AdditivityAndSubdivision) {
    const Rectangle unit, small{0.2, 0.7, 0.1, 0.8};
    const Mesh mesh =
        test::together(test::together(level(unit, 0.0, true, 2), level(unit, 1.0, false, 2)), level(small, 0.4, true));
    const FormFactors coarse = compute(mesh, runs({8, 8, 2})), fine = compute(mesh, surfaces_by_face(mesh));
    double into_parts = 0.0, from_parts = 0.0;
    for (std::size_t i = 0; i < 8; ++i) {
        for (std::size_t j = 8; j < 16; ++j) {
            from_parts += mesh.areas[i] * fine.at(i, j);
            into_parts += mesh.areas[j] * fine.at(j, i);
        }
    }
    EXPECT_NEAR(from_parts, coarse.at(0, 1), 8e-6);
    EXPECT_NEAR(into_parts, coarse.at(1, 0), 8e-6);
}

TEST(FormFactorMatrix, SameBitsForAnyNumberOfThreads) {
    const Mesh mesh = room_with_cube(1);
    const FormFactors one = compute(mesh, surfaces_by_face(mesh), 1e-5, 1);
    const FormFactors three = compute(mesh, surfaces_by_face(mesh), 1e-5, 3);
    for (std::size_t i = 0; i < one.size(); ++i) {
        EXPECT_EQ(one.rows[i].column, three.rows[i].column);
        EXPECT_EQ(one.rows[i].factor, three.rows[i].factor);
        EXPECT_EQ(one.rows[i].error, three.rows[i].error);
    }
}

TEST(FormFactorMatrix, DoesNotDependOnScale) {
    const Mesh mesh = room_with_cube(1);
    const FormFactors F = compute(mesh, runs({12, 12}), 1e-3);
    for (const double scale : {1e-8, 1e8}) {
        const Mesh other = test::moved(mesh, scale, scale * Vec3(0.3, 0.2, 0.1));
        EXPECT_NEAR(compute(other, runs({12, 12}), 1e-3).at(0, 1), F.at(0, 1), 2e-3);
    }
}

/// Directions distributed as the cosine, in `count` strata of the square.
class CosineLattice final : public Directions {
  public:
    DirectionSet make(std::size_t count, RandomStream) const override {
        DirectionSet set;
        for (std::size_t k = 0; k < count; ++k) {
            const auto [u, v] = even_point<2>(k, {0.5, 0.5});
            const double radius = std::sqrt(u), angle = 2.0 * std::numbers::pi * v;
            set.direction.emplace_back(radius * std::cos(angle), radius * std::sin(angle), std::sqrt(1.0 - u));
            set.weight.push_back(1.0 / static_cast<double>(count));
        }
        return set;
    }
};

/// A box seen from inside, around a small two-sided triangle near one of its walls.
Mesh room_with_sheet(std::uint64_t seed) {
    RandomStream stream(seed, "sheet");
    const auto between = [&](double low, double high) { return low + (high - low) * stream.uniform(); };
    const auto of_any_size = [&](double low, double high) { return std::pow(10.0, between(low, high)); };
    const Vec3 room(between(0.5, 1.5), between(0.5, 1.5), between(1.0, 3.0));
    Vec3 centre(between(0.1, 0.9) * room.x(), between(0.1, 0.9) * room.y(), between(0.1, 0.9) * room.z());
    centre[static_cast<Eigen::Index>(stream.below(3))] = of_any_size(-2.5, -0.7);
    const double size = of_any_size(-2.0, -1.0);
    std::vector<Vec3> corners;
    while (corners.size() < 3) {
        const Vec3 corner = centre + size * Vec3(between(-1, 1), between(-1, 1), between(-1, 1));
        if ((corner.array() > 1e-3).all() && (corner.array() < room.array() - 1e-3).all()) {
            corners.push_back(corner);
        }
    }
    return test::together(test::box(room, 1, true), test::make_mesh(corners, {{0, 1, 2}, {2, 1, 0}}));
}

/// Rules of few points may miss the sheet's shadow, or agree by accident where triangles share an edge. Where each
/// factor is within the tolerance, a row sum is within as many times that as it has factors.
TEST(FormFactorMatrix, RowSumsAroundASmallSheetAreWithinTheTolerance) {
    constexpr double tolerance = 1e-5;
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        const Mesh mesh = room_with_sheet(seed);
        const std::vector<std::size_t> each(mesh.triangles.size(), 1);
        const FormFactors F = compute(mesh, runs(each), tolerance);
        for (std::size_t i = 0; i < F.size(); ++i) {
            EXPECT_NEAR(F.row_sum(i), 1.0, tolerance * static_cast<double>(F.size()))
                << "seed " << seed << ", triangle " << i;
        }
    }
}

/// A naive twin: what rays hit first, found by testing every triangle. Rows of a closed surface sum to 1 exactly.
TEST(FormFactorMatrix, AgreesWithRays) {
    const Mesh mesh = room_with_cube(1);
    BruteForceVisibility engine;
    engine.build(mesh);
    const DirectionPool pool(CosineLattice(), 256, 1);
    const Surfaces surfaces = surfaces_by_face(mesh);
    const FormFactors rays = form_factors_by_rays(Tracer(mesh, engine), surfaces, pool, 64, 1, Execution{1});
    EXPECT_THROW(form_factors_by_rays(Tracer(mesh, engine), surfaces, pool, 1, 1, Execution{1}), UsageError);
    const FormFactors F = compute(mesh, surfaces, 1e-3);
    double squares = 0.0;
    for (std::size_t i = 0; i < F.size(); ++i) {
        EXPECT_NEAR(rays.row_sum(i), 1.0, 1e-12);
        for (std::size_t j = 0; j < F.size(); ++j) {
            EXPECT_NEAR(F.at(i, j), rays.at(i, j), 0.03) << i << " " << j; // a point in 64 stands for 0.016
            squares += std::pow(F.at(i, j) - rays.at(i, j), 2);
        }
    }
    EXPECT_LE(std::sqrt(squares) / static_cast<double>(F.size()), 0.004);
}

TEST(Surfaces, AreFacesMaterialsOrGroups) {
    Mesh mesh = test::grid(2, 1);
    mesh.original_face = {0, 0, 1, 1};
    mesh.material = {2, 2, 0, 1};
    std::vector<Material> materials(3);
    materials[0].name = "steel";
    materials[1].name = "brass";
    materials[1].light_group = materials[2].light_group = "metal";
    using Names = std::vector<std::string>;
    const Surfaces faces = surfaces_by_face(mesh), named = surfaces_by_material(mesh, materials),
                   groups = surfaces_by_group(mesh, materials);
    EXPECT_EQ(faces.name, (Names{"0", "1"}));
    EXPECT_EQ(faces.areas(mesh), (std::vector<double>{0.5, 0.5}));
    EXPECT_EQ(named.name, (Names{"steel", "brass", "material 2"}));
    EXPECT_EQ(named.of, (std::vector<Index>{2, 2, 0, 1}));
    EXPECT_EQ(groups.name, (Names{"steel", "metal"}));
    EXPECT_EQ(groups.of, (std::vector<Index>{1, 1, 0, 1}));
}

TEST(FormFactorMatrix, RefusesATolerance) {
    const Mesh mesh = test::grid(1, 1);
    EXPECT_THROW(compute(mesh, surfaces_by_face(mesh), 0.0), UsageError);
    EXPECT_THROW(compute(mesh, surfaces_by_face(mesh), std::nan("")), UsageError);
}

/// How many pairs see each other is known only as they are computed: the limit counts those above 0.
TEST(FormFactorMatrix, RefusesMoreFactorsThanMemoryHolds) {
    const Mesh cube = test::box({1, 1, 1}, 2, true);
    Execution limited{1};
    limited.most_memory = 1.0; // less than the process holds: nothing is left
    EXPECT_THROW(form_factors(cube, surfaces_by_face(cube), {}, limited), ResourceError);
    const Mesh sheet = test::grid(1, 1); // sees nothing, which takes no memory
    EXPECT_EQ(form_factors(sheet, surfaces_by_face(sheet), {}, limited).nonzeros(), 0U);
}

/// Floor, ceiling and back of a shelf of depth 1, b apart and `length` long; each of n by 1 rectangles.
Mesh long_shelf(double b, double length) {
    const Mesh floor = test::make_mesh({{0, 0, 0}, {1, 0, 0}, {1, length, 0}, {0, length, 0}}, {{0, 1, 2}, {0, 2, 3}});
    const Mesh back = test::make_mesh({{0, 0, 0}, {0, length, 0}, {0, length, b}, {0, 0, b}}, {{0, 1, 2}, {0, 2, 3}});
    const Mesh ceiling =
        test::make_mesh({{0, 0, b}, {0, length, b}, {1, length, b}, {1, 0, b}}, {{0, 1, 2}, {0, 2, 3}});
    return test::together(test::together(floor, back), ceiling);
}

/// L 33-34: the closed forms of the infinite shelf are approached as the inverse of the length, and so is the light in
/// the four cases of the slide.
TEST(Shelf, IsApproachedAsItGetsLong) {
    struct Case {
        Eigen::Vector3d E, rho;
    };
    const std::array<Case, 4> cases{{{{1, 0, 0}, {0, 0.5, 0.5}},
                                     {{1, 0, 0}, {0.5, 0.5, 0.5}},
                                     {{0, 1, 0}, {0.5, 0, 0.5}},
                                     {{1, 1, 0}, {0.5, 0.5, 0.5}}}};
    for (const double g : {0.5, 1.0, 2.0}) {
        const ShelfFormFactors exact = shelf(1.0, g);
        Eigen::Matrix3d infinite;
        infinite << 0, exact.AB, exact.AC, exact.BA, 0, exact.BA, exact.AC, exact.AB, 0;
        std::array<double, 2> error{};
        for (std::size_t k = 0; k < 2; ++k) {
            const FormFactors F = compute(long_shelf(g, k == 0 ? 500.0 : 1000.0), runs({2, 2, 2}), 1e-9);
            Eigen::Matrix3d finite;
            for (std::size_t i = 0; i < 3; ++i) {
                for (std::size_t j = 0; j < 3; ++j) {
                    finite(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = F.at(i, j);
                }
            }
            error[k] = (finite - infinite).cwiseAbs().maxCoeff();
            for (const Case& light : cases) {
                const auto solve = [&](const Eigen::Matrix3d& matrix) {
                    return Eigen::Vector3d((Eigen::Matrix3d::Identity() - light.rho.asDiagonal() * matrix).inverse() *
                                           light.E);
                };
                // Each bounce loses at most the same share; the series of bounces sums to at most 2 here.
                EXPECT_LE((solve(finite) - solve(infinite)).cwiseAbs().maxCoeff(), 4.0 * 3.0 * error[k]);
            }
        }
        EXPECT_NEAR(error[0] / error[1], 2.0, 0.05) << g;
        EXPECT_LE(error[1], 1e-3);
    }
}

TEST(Blockers, AreFewAndLarge) {
    const Mesh mesh = room_with_cube(4);
    const std::vector<Blocker> blockers = blockers_of(mesh, flat_parts(mesh));
    ASSERT_EQ(blockers.size(), 6U) << "the walls have everything on one side; each side of the cube is one square";
    for (const Blocker& blocker : blockers) {
        EXPECT_EQ(blocker.polygon.size(), 4U);
        EXPECT_NEAR(blocker.polygon.area_vector().norm(), 1.0, 1e-15);
    }
}

/// A plate with a hole is cut into convex pieces that cover it once.
TEST(Blockers, CoverPlatesWithHoles) {
    Mesh plate = test::grid(3, 3, 3.0, 3.0);
    plate.triangles.erase(plate.triangles.begin() + 8, plate.triangles.begin() + 10); // the middle cell
    plate.material.resize(plate.triangles.size());
    plate.original_face.resize(plate.triangles.size());
    plate.derive();
    const Mesh mesh = test::together(plate, test::moved(test::box({1, 1, 1}), 1.0, Vec3(1, 1, -0.5)));
    double area = 0.0;
    std::size_t count = 0;
    for (const Blocker& blocker : blockers_of(mesh, flat_parts(mesh))) {
        if (std::abs(blocker.plane.height(Vec3(0, 0, 0))) < 1e-12 && blocker.plane.normal.z() > 0.5) {
            area += blocker.polygon.area_vector().norm();
            ++count;
        }
    }
    EXPECT_NEAR(area, 8.0, 1e-12);
    EXPECT_LE(count, 8U);
}

TEST(Closure, MakesAllLawsHold) {
    const Mesh mesh = room_with_cube(2);
    FormFactors F = compute(mesh, surfaces_by_face(mesh), 1e-3);
    RandomStream stream(5, "closure");
    for (FormFactors::Row& row : F.rows) {
        for (double& factor : row.factor) {
            factor *= 1.0 + 0.01 * (stream.uniform() - 0.5);
        }
    }
    const FormFactors before = F;
    const ClosureCorrection correction = enforce_closure(F);
    const FormFactorLaws laws = check_laws(F, 1.0);
    EXPECT_NEAR(laws.least_row_sum, 1.0, 1e-12);
    EXPECT_NEAR(laws.largest_row_sum, 1.0, 1e-12);
    EXPECT_LE(laws.reciprocity, 1e-15);
    double largest = 0.0;
    for (std::size_t i = 0; i < F.size(); ++i) {
        for (std::size_t e = 0; e < F.rows[i].column.size(); ++e) {
            EXPECT_GE(F.rows[i].factor[e], 0.0);
            largest = std::max(largest, std::abs(F.rows[i].factor[e] - before.at(i, F.rows[i].column[e])));
        }
    }
    EXPECT_DOUBLE_EQ(correction.largest, largest);
    EXPECT_LE(correction.largest_relative, 0.05);
}

TEST(Closure, RefusesWhatIsOpen) {
    const Mesh shelf = long_shelf(1.0, 2.0);
    FormFactors F = compute(shelf, runs({2, 2, 2}));
    EXPECT_THROW(enforce_closure(F), InputError);
    try {
        enforce_closure(F, {"wall", "shelf", "lamp"});
        FAIL();
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("surface \"wall\" sum to"), std::string::npos) << error.what();
    }
}

} // namespace
} // namespace difusa::form_factors_test
