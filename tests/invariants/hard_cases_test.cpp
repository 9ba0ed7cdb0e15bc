// Scenes in which renderers go wrong, each baked whole and held to a bound that is derived, not tuned.
#include <difusa/bake.h>
#include <difusa/core/error.h>
#include <difusa/discretisation/basis.h>
#include <difusa/import/shapes.h>
#include <difusa/rays/lambert.h>
#include <difusa/rays/visibility.h>
#include <difusa/study/references/bowl.h>
#include <difusa/study/references/form_factors.h>
#include <difusa/study/references/manufactured.h>

#include <scratch_directory.h>
#include <support/plugins.h>
#include <support/rooms.h>
#include <support/sited.h>
#include <support/surface_sampling.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace difusa::hard_cases_test {
namespace {

/// Rounding of a sum over the rays and elements of a site, and of the solver's sweeps.
constexpr double rounding = 1e-12;

std::vector<std::string> engines() {
    return test::plugin_names<Visibility>();
}

/// Quick, with nothing but the field itself.
BakeOptions coarse(double spacing, const std::string& engine = "cgal", std::size_t rays = 64) {
    BakeOptions options;
    options.spacing = spacing;
    options.rays = rays;
    options.visibility = engine;
    options.error_points = 0;
    options.solve.tolerance = 1e-12;
    return options;
}

BakeResult baked(Scene scene, const BakeOptions& options) {
    return bake(test::registry(), std::move(scene), "hard case", options, Execution{1, nullptr});
}

/// A floor on which slender posts stand that cross it, as parts of a machine do.
Mesh floor_with_posts() {
    Mesh mesh = test::grid(1, 1);
    for (int i = 0; i < 5; ++i) {
        for (int j = 0; j < 5; ++j) {
            const Vec3 foot(0.1 + 0.18 * i, 0.07 + 0.19 * j, -0.3);
            mesh = test::together(mesh, box(foot, foot + Vec3(0.06, 0.06, 0.6), 1, Front::outside));
        }
    }
    mesh.material.assign(mesh.triangles.size(), 0);
    return mesh;
}

TEST(HardCases, WhatLiesInsideOfOtherBodiesIsNoErrorOfTheBasis) {
    // A twelfth of the floor is inside of posts, where most of it has no site in sight: no light comes there, the
    // elements vanish, and constants count as represented. Elsewhere the elements sum to 1, and so do their constants.
    BakeOptions options = coarse(0.2);
    options.projection = "corrected";
    const BakeResult result = baked(test::uniform_scene(floor_with_posts(), 0.3, 1.0), options);
    EXPECT_THAT(result.plugins, testing::Contains(testing::Pair("basis", testing::HasSubstr("moving-least-squares"))));
    EXPECT_LE(result.constant_error, 1e-9) << "the tolerance of the projection's solve";
}

/// Sets the material of the triangles `which` holds.
void paint(Scene& scene, const Material& material, const std::function<bool(const SurfacePoint&)>& which) {
    const auto number = static_cast<Index>(scene.materials.size());
    scene.materials.push_back(material);
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        if (which(scene.mesh.at(t, 1.0 / 3, 1.0 / 3))) {
            scene.mesh.material[t] = number;
        }
    }
}

Material material_of(double rho, double E) {
    Material material;
    material.reflectance = Rgb::Constant(rho);
    material.emission = Rgb::Constant(E);
    return material;
}

Scene under_the_sky(Mesh mesh, double rho) {
    Scene scene = test::uniform_scene(std::move(mesh), rho, 0.0);
    scene.sky = Rgb::Ones();
    return scene;
}

/// Largest deviation of the values from `exact`.
double deviation(const Values& values, double exact) {
    return (values.array() - exact).abs().maxCoeff();
}

/// Six standard deviations of the mean of N scrambled stratified samples of a function with values in [0,1] and mean F
/// (variance at most e times that of independent ones, Owen 1997).
double noise(double F, std::size_t N) {
    return 6.0 *
           std::sqrt(std::numbers::e * std::max(F * (1.0 - F), 1.0 / static_cast<double>(N)) / static_cast<double>(N));
}

/// A closed scene of constant emission 1 and reflectance rho: B = 1/(1-rho), exactly. Errors of rounding and of the
/// solver's residual grow by 1/(1-rho).
void expect_furnace(const Mesh& mesh, BakeOptions options, double rho = 0.5) {
    const double exact = 1.0 / (1.0 - rho);
    const BakeResult result = baked(test::uniform_scene(mesh, rho, 1.0), options);
    const double bound = (rounding + 10.0 * options.solve.tolerance) * exact * exact;
    EXPECT_LE(deviation(result.solution.irradiance, exact), bound) << "at the sites";
    EXPECT_LE(deviation(result.output.B, exact), bound) << "at the vertices";
    EXPECT_EQ(result.mean_back, 0.0) << "backs are seen";
    EXPECT_EQ(result.solution.energy.escaped.maxCoeff(), 0.0) << "light escapes";
}

/// Two unit squares: z = at facing up, z = at + gap facing down.
Mesh plates(double at, double gap) {
    Mesh upper = test::grid(1, 1, 1.0, 1.0, true);
    return test::together(test::moved(test::grid(1, 1), 1.0, Vec3(0, 0, at)),
                          test::moved(std::move(upper), 1.0, Vec3(0, 0, at + gap)));
}

TEST(HardCases, ParallelPlatesWithAGapThatGoesToZero) {
    // Nothing exceeds the infinite plates (row sums are at most 1). A site at t from a border loses at most g²/(4t²) of
    // its view there; where the sum of it over all rays is below 1e-3, no ray is lost and the infinite plates come out.
    const double E = 1.0, rho_1 = 0.3, rho_2 = 0.8;
    const double B_1 = E / (1.0 - rho_1 * rho_2), B_2 = rho_2 * B_1;
    std::size_t closed = 0;
    for (const std::string& engine : engines()) {
        for (const double gap : {0.1, 1e-2, 1e-4, 1e-6, 1e-9, 1e-12}) {
            SCOPED_TRACE(engine + ", gap " + std::to_string(std::log10(gap)));
            Scene scene = test::uniform_scene(plates(0.0, gap), rho_1, E);
            paint(scene, material_of(rho_2, 0.0), [](const SurfacePoint& x) { return x.normal.z() < 0.0; });
            BakeOptions options = coarse(0.1, engine);
            options.basis = "normalized-radial"; // a partition of unity: nothing overshoots
            const BakeResult result = baked(scene, options);
            double lost = 0.0;
            for (std::size_t j = 0; j < result.sites->size(); ++j) {
                const SurfacePoint& x = result.sites->points[j];
                const double H = result.solution.irradiance(static_cast<Eigen::Index>(j), 0);
                const double infinite = x.normal.z() > 0.0 ? B_2 : B_1;
                EXPECT_GE(H, 0.0);
                EXPECT_LE(H, infinite * (1.0 + 100 * rounding));
                for (int axis = 0; axis < 2; ++axis) {
                    for (const double t : {x.position[axis], 1.0 - x.position[axis]}) {
                        lost += t > 0.0 ? std::min(0.5, gap * gap / (4.0 * t * t)) : 0.5;
                    }
                }
            }
            if (lost * 64.0 > 1e-3) {
                continue;
            }
            ++closed;
            for (std::size_t v = 0; v < result.mesh.vertices.size(); ++v) {
                const double exact = result.mesh.vertices[v].normal.z() > 0.0 ? B_1 : B_2;
                EXPECT_NEAR(result.output.B(static_cast<Eigen::Index>(v), 0), exact, 100 * rounding);
            }
        }
    }
    EXPECT_GE(closed, 2 * engines().size());
}

TEST(HardCases, ADihedralCornerFromWideToSharp) {
    // A square that emits, hinged to a black one at the angle theta: the irradiance of each site of the black one is
    // known in closed form (Lambert); what is gathered differs by the noise of N rays.
    constexpr std::size_t N = 256;
    for (const std::string& engine : engines()) {
        for (const double degrees : {170.0, 120.0, 90.0, 60.0, 30.0, 10.0}) {
            SCOPED_TRACE(engine + ", " + std::to_string(degrees));
            const double theta = degrees * std::numbers::pi / 180.0;
            // Hinge on the y axis; the floor lies along +x, the wall turned up from it by theta.
            const Vec3 up(std::cos(theta), 0.0, std::sin(theta));
            Scene scene = test::uniform_scene(
                test::make_mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, up, up + Vec3(0, 1, 0)},
                                {{0, 1, 2}, {0, 2, 3}, {0, 3, 5}, {0, 5, 4}}),
                0.0, 0.0);
            paint(scene, material_of(0.0, 1.0), [](const SurfacePoint& x) { return x.face >= 2; });
            const BakeResult result = baked(scene, coarse(0.1, engine, N));
            for (std::size_t j = 0; j < result.sites->size(); ++j) {
                const SurfacePoint& x = result.sites->points[j];
                if (x.face >= 2) {
                    continue;
                }
                double exact = 0.0;
                for (const Index t : {2, 3}) {
                    const Mesh& mesh = result.scene->mesh;
                    exact += lambert_form_factor(x.position, x.normal, mesh.corner(t, 0), mesh.corner(t, 1),
                                                 mesh.corner(t, 2));
                }
                EXPECT_NEAR(result.solution.irradiance(static_cast<Eigen::Index>(j), 0), exact, noise(exact, N));
            }
        }
    }
}

/// The sharper the wedge, the more bounces: a prism over the triangle with the angle theta at its apex, closed.
TEST(HardCases, AClosedWedgeIsAFurnace) {
    for (const std::string& engine : engines()) {
        for (const double degrees : {170.0, 90.0, 30.0, 10.0, 1.0, 0.01}) {
            SCOPED_TRACE(engine + ", " + std::to_string(degrees));
            const double half = 0.5 * degrees * std::numbers::pi / 180.0, c = std::cos(half), s = std::sin(half);
            Mesh wedge = test::make_mesh(
                {{0, 0, 0}, {c, 0, -s}, {c, 0, s}, {0, 1, 0}, {c, 1, -s}, {c, 1, s}},
                {{0, 2, 1}, {3, 4, 5}, {0, 4, 3}, {0, 1, 4}, {0, 5, 2}, {0, 3, 5}, {1, 5, 4}, {1, 2, 5}});
            const Vec3 middle(0.5 * c, 0.5, 0.0);
            for (Index t = 0; t < wedge.triangles.size(); ++t) {
                ASSERT_EQ(std::signbit((middle - wedge.at(t, 1.0 / 3, 1.0 / 3).position).dot(wedge.normals[t])),
                          std::signbit((middle - wedge.at(0, 1.0 / 3, 1.0 / 3).position).dot(wedge.normals[0])));
            }
            if ((middle - wedge.at(0, 1.0 / 3, 1.0 / 3).position).dot(wedge.normals[0]) < 0.0) {
                test::flip(wedge);
            }
            expect_furnace(wedge, coarse(0.2, engine), 0.8);
        }
    }
}

TEST(HardCases, BoxesThatAbsorbNextToNothing) {
    // GMRES on an operator that is symmetric in the limit, spectrum in [1-rho, 1+rho]: at most sqrt(kappa)/2 ln(2/tol)
    // iterations with kappa = (1+rho)/(1-rho), as conjugate gradients.
    for (const std::string& engine : engines()) {
        for (const double rho : {0.9, 0.99, 0.999}) {
            SCOPED_TRACE(engine + ", " + std::to_string(rho));
            expect_furnace(test::box(1.0, 1, true), coarse(0.15, engine), rho);
            Scene scene = test::uniform_scene(test::l_room(), rho, 0.0);
            paint(scene, material_of(rho, 1.0), [](const SurfacePoint& x) { return x.normal.z() < -0.5; });
            BakeOptions options = coarse(0.25, engine);
            options.solve.tolerance = 1e-8;
            const BakeResult result = baked(scene, options);
            const double kappa = (1.0 + rho) / (1.0 - rho);
            EXPECT_LE(result.solution.solve.iterations, 0.5 * std::sqrt(kappa) * std::log(2.0 / 1e-8));
            EXPECT_GT(result.solution.solve.iterations, 2);
            EXPECT_EQ(result.solution.energy.escaped.maxCoeff(), 0.0);
        }
    }
}

/// The inward normal of the box' face that is nearest to x.
Vec3 face_normal(const Vec3& size, const Vec3& x) {
    Vec3 normal = Vec3::UnitX();
    double least = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {1.0, -1.0}) {
            const double distance = side > 0.0 ? x[axis] : size[axis] - x[axis];
            if (distance < least) {
                least = distance;
                normal = side * Vec3::Unit(axis);
            }
        }
    }
    return normal;
}

TEST(HardCases, BoxesThatAbsorbNextToNothingAndAreNotUniform) {
    // A radiosity is chosen, its emission follows (references/manufactured.h). With h = K B the exact irradiance, Q h
    // its interpolation from the sites and K~ the mean over N rays, the error e of the baked irradiance at the sites
    // obeys
    //     e = r + rho K~ Q e,   r = (K~ - K) B + rho K~ (Q h - h).
    // So |e| <= max |r| + rho/(1-rho) max |K~ Q r|. Here r is the noise of N rays and the error of interpolation, both
    // largest at some site; K~ Q averages them over the other sites, among which 32 sets of directions are independent,
    // so that of the noise 1/√32 is left and of the interpolation its mean. Max and mean of |Q h - h| are taken at
    // random points.
    constexpr std::size_t N = 32;
    constexpr double tolerance = 1e-4; // of E, grown by 1/(1-rho)
    const Vec3 size(1.0, 1.2, 0.8);
    for (const double rho : {0.9, 0.99}) {
        SCOPED_TRACE(rho);
        const double amplitude = (1.0 - rho) / (1.0 + rho); // as large as E >= 0 allows
        const auto B = ManufacturedBox::waves(size, 1.0, amplitude, 1.0);
        const ManufacturedBox exact(size, rho, B, tolerance);
        Scene scene = test::uniform_scene(test::box(size, 1, true), rho, 1.0);
        scene.materials[0].emission_pattern = [&](const Vec3& x) { return exact.at(x, face_normal(size, x)).E; };
        const BakeResult result = baked(scene, coarse(0.35, "cgal", N));
        Values h(static_cast<Eigen::Index>(result.sites->size()), 1);
        for (std::size_t j = 0; j < result.sites->size(); ++j) {
            const SurfacePoint& x = result.sites->points[j];
            h(static_cast<Eigen::Index>(j), 0) = exact.at(x.position, x.normal).H;
        }
        double largest = 0.0, mean = 0.0;
        constexpr int probes = 200;
        BasisRow row;
        for (const SurfacePoint& x : test::random_points(scene.mesh, probes, RandomStream(5, "probes"))) {
            result.system->discretisation().basis->evaluate(x, row);
            double value = 0.0;
            for (std::size_t k = 0; k < row.element.size(); ++k) {
                value += row.weight[k] * h(row.element[k], 0);
            }
            const double miss = std::abs(value - exact.at(x.position, x.normal).H);
            largest = std::max(largest, miss);
            mean += miss / probes;
        }
        // B lies within 1 ± amplitude, a variance of at most amplitude².
        const double spread = 6.0 * amplitude * std::sqrt(std::numbers::e / static_cast<double>(N));
        const double bound = tolerance / (1.0 - rho) + spread + rho * largest +
                             rho / (1.0 - rho) * (spread / std::sqrt(32.0) + rho * mean);
        const double error = (result.solution.irradiance - h).cwiseAbs().maxCoeff();
        EXPECT_LE(error, bound);
        EXPECT_GT(error, 0.0);
        EXPECT_LT(bound, 0.5) << "half of the radiosity: the bound says something";
    }
}

TEST(HardCases, AShelfJustAboveATable) {
    // A shelf's back shades the table: a site under it sees of the sky what the shelf, a rectangle straight above,
    // leaves of it. The shelf itself sees all the sky.
    constexpr std::size_t N = 256;
    for (const std::string& engine : engines()) {
        for (const double gap : {0.1, 1e-3, 1e-6, 1e-9}) {
            SCOPED_TRACE(engine + ", gap " + std::to_string(std::log10(gap)));
            const BakeResult result = baked(under_the_sky(test::shelf_over_table(gap), 0.6), coarse(0.06, engine, N));
            std::size_t under = 0;
            for (std::size_t j = 0; j < result.sites->size(); ++j) {
                const SurfacePoint& x = result.sites->points[j];
                const double H = result.solution.irradiance(static_cast<Eigen::Index>(j), 0);
                if (x.position.z() > 0.0) {
                    EXPECT_NEAR(H, 1.0, rounding);
                    continue;
                }
                const Rectangle shelf{0.25 - x.position.x(), 0.75 - x.position.x(), 0.25 - x.position.y(),
                                      0.75 - x.position.y()};
                const double exact = 1.0 - element_to_rectangle(shelf, gap);
                EXPECT_NEAR(H, exact, noise(std::clamp(exact, 0.0, 1.0), N));
                under += shelf.x0 < 0.0 && shelf.x1 > 0.0 && shelf.y0 < 0.0 && shelf.y1 > 0.0 ? 1 : 0;
            }
            EXPECT_GT(under, 20U);
            for (std::size_t v = 0; v < result.mesh.vertices.size(); ++v) {
                if (result.mesh.vertices[v].position.z() > 0.0) {
                    EXPECT_NEAR(result.output.H(static_cast<Eigen::Index>(v), 0), 1.0, rounding)
                        << "the table's shade on the shelf";
                }
            }
        }
    }
}

TEST(HardCases, FacesThatLieInOnePlace) {
    for (const std::string& engine : engines()) {
        // Squares in one plane that overlap by half, and one that lies on both: all of the sky, everywhere.
        Mesh sheets = test::together(test::grid(1, 1), test::moved(test::grid(2, 2), 1.0, Vec3(0.5, 0, 0)));
        sheets = test::together(sheets, test::moved(test::grid(3, 1), 0.5, Vec3(0.3, 0.2, 0)));
        const BakeResult open = baked(under_the_sky(sheets, 0.5), coarse(0.1, engine));
        EXPECT_LE(deviation(open.solution.irradiance, 1.0), rounding) << engine;
        EXPECT_LE(deviation(open.output.H, 1.0), rounding) << engine;
        // A closed box with a second floor on part of its floor, and with every face twice.
        const Mesh box = test::box(1.0, 1, true);
        expect_furnace(test::together(box, test::moved(test::grid(2, 2), 0.5, Vec3(0.2, 0.3, 0))),
                       coarse(0.15, engine));
        expect_furnace(test::together(box, box), coarse(0.15, engine));
    }
}

TEST(HardCases, FacesGivenTwiceCountOnce) {
    const test::ScratchDirectory directory;
    const auto write = [&](const char* name, const char* faces) {
        std::ofstream(directory / name) << "OFF\n4 " << faces;
        return directory / name;
    };
    const char* const points = " 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    const auto once = write("once.off", ("2" + std::string(points) + "3 0 1 2\n3 0 2 3\n").c_str());
    const auto twice = write("twice.off", ("4" + std::string(points) + "3 0 1 2\n3 0 2 3\n3 1 2 0\n3 3 0 2\n").c_str());
    const BakeOptions options = coarse(0.1);
    const BakeResult a = bake(test::registry(), once, options, Execution{1, nullptr});
    const BakeResult b = bake(test::registry(), twice, options, Execution{1, nullptr});
    EXPECT_EQ(a.output.B, b.output.B);
    EXPECT_EQ(b.scene->mesh.triangles.size(), 2U);
}

/// A closed cone of 2 `slices` triangles that all meet in the apex or in the middle of the base, seen from inside.
Mesh cone(int slices) {
    std::vector<Vec3> points{{0, 0, 1}, {0, 0, 0}};
    std::vector<std::array<Index, 3>> triangles;
    for (int k = 0; k < slices; ++k) {
        const double angle = 2.0 * std::numbers::pi * k / slices;
        points.emplace_back(std::cos(angle), std::sin(angle), 0.0);
        const auto here = static_cast<Index>(k + 2), next = static_cast<Index>((k + 1) % slices + 2);
        triangles.push_back({0, next, here});
        triangles.push_back({1, here, next});
    }
    return test::make_mesh(std::move(points), std::move(triangles));
}

TEST(HardCases, NeedlesThatMeetInOnePoint) {
    for (const std::string& engine : engines()) {
        expect_furnace(cone(1000), coarse(0.25, engine), 0.8); // a 160th as wide as long
    }
}

TEST(HardCases, OneTriangle) {
    // Under the sky it sees all of it, whatever the spacing; one site carries it if that is larger than the triangle.
    for (const std::string& engine : engines()) {
        for (const double spacing : {0.05, 0.5, 100.0}) {
            const Mesh mesh = test::make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
            const BakeResult result = baked(under_the_sky(mesh, 0.25), coarse(spacing, engine));
            EXPECT_LE(deviation(result.output.B, 0.25), rounding) << engine << " " << spacing;
            if (spacing > 2.0) {
                EXPECT_EQ(result.sites->size(), 1U);
            }
        }
    }
}

TEST(HardCases, AnySizeAnywhere) {
    // A furnace a million times larger or smaller, and as far from the origin as a million times its size (coordinates
    // then have ten digits left).
    RandomStream random(3, "motions");
    for (const std::string& engine : engines()) {
        for (const double scale : {1e-6, 1.0, 1e6}) {
            for (const double far : {0.0, 1e3, 1e6}) {
                SCOPED_TRACE(engine + ", scale " + std::to_string(std::log10(scale)) + ", far " + std::to_string(far));
                const Mesh room = test::transformed(test::l_room(), test::random_rotation(random), scale,
                                                    scale * far * Vec3(1, -0.7, 0.4));
                expect_furnace(room, coarse(0.3 * scale, engine));
            }
        }
    }
}

TEST(HardCases, AHugeTriangleBesideTenThousandTinyOnes) {
    // A box of two triangles a side but for the floor: 9800 cells that shrink with the fourth power towards a corner,
    // the smallest 4e-8 wide.
    Mesh floor = test::grid(70, 70);
    for (Vec3& p : floor.points) {
        p = Vec3(std::pow(p.x(), 4), std::pow(p.y(), 4), 0.0);
    }
    Mesh box = test::box(1.0, 1, true);
    for (std::size_t t = box.triangles.size(); t-- > 0;) { // its own floor
        if (box.normals[t].z() > 0.5) {
            box.triangles.erase(box.triangles.begin() + static_cast<std::ptrdiff_t>(t));
        }
    }
    const Mesh room = test::together(test::make_mesh(box.points, box.triangles), floor);
    ASSERT_EQ(room.triangles.size(), 9810U);
    for (const std::string& engine : engines()) {
        expect_furnace(room, coarse(0.2, engine));
    }
}

/// The inside of the cap of the unit sphere up to the angle `beta` from its lowest point.
Mesh bowl(double beta, int rings, int slices) {
    std::vector<Vec3> points{{0, 0, -1}};
    std::vector<std::array<Index, 3>> triangles;
    for (int r = 1; r <= rings; ++r) {
        const double a = beta * r / rings;
        for (int k = 0; k < slices; ++k) {
            const double b = 2.0 * std::numbers::pi * k / slices;
            points.emplace_back(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), -std::cos(a));
        }
    }
    const auto at = [&](int r, int k) { return static_cast<Index>(1 + (r - 1) * slices + k % slices); };
    for (int k = 0; k < slices; ++k) {
        triangles.push_back({0, at(1, k), at(1, k + 1)});
        for (int r = 1; r < rings; ++r) {
            triangles.push_back({at(r, k), at(r + 1, k), at(r + 1, k + 1)});
            triangles.push_back({at(r, k), at(r + 1, k + 1), at(r, k + 1)});
        }
    }
    return test::make_mesh(std::move(points), std::move(triangles));
}

TEST(HardCases, AnOpenMeshUnderTheSky) {
    // The bowl's irradiance is known. The sky that a site sees is the mean of N rays that miss or hit; what is
    // reflected averages over the sites, of which 32 have independent rays. The facets turn by 7.5° at most: 1 -
    // cos 7.5° of the light goes astray.
    constexpr std::size_t N = 2048;
    const double rho = 0.5;
    for (const std::string& engine : engines()) {
        for (const double beta : {0.5, 1.0, 1.5}) {
            const Bowl exact({beta, rho, Vec3::UnitZ(), 0.0, 1.0});
            const BakeResult result = baked(under_the_sky(bowl(beta, 12, 48), rho), coarse(0.2, engine, N));
            const double tolerance = noise(exact.share(), N) * (1.0 + rho / (1.0 - rho) / std::sqrt(32.0)) + 1.0 -
                                     std::cos(7.5 * std::numbers::pi / 180.0);
            for (std::size_t j = 0; j < result.sites->size(); ++j) {
                const SurfacePoint& x = result.sites->points[j];
                EXPECT_NEAR(result.solution.irradiance(static_cast<Eigen::Index>(j), 0),
                            exact.at(x.position, x.normal).H, tolerance)
                    << engine << " " << beta;
            }
        }
    }
}

/// Between plates that absorb hardly anything and nearly touch, negative weights of the default basis make light
/// grow. Too few iterations are another matter: they are no reason to change the basis.
TEST(HardCases, TheDefaultBasisGivesWayWhereBouncesDoNotDieOut) {
    const Scene scene = under_the_sky(plates(0.0, 1e-4), 0.9999);
    const auto notes_of = [&](const BakeOptions& options, std::optional<BakeResult>& result) {
        Journal journal;
        try {
            result = bake(test::registry(), scene, "plates", options, Execution{1, nullptr, &journal});
        } catch (const NotConverged&) {
            result.reset();
        }
        return journal.notes();
    };
    const auto gives_way = testing::Contains(testing::HasSubstr("normalized-radial is used"));
    BakeOptions options = coarse(0.1), sure = options;
    sure.basis = "normalized-radial";
    std::optional<BakeResult> result, expected;
    EXPECT_THAT(notes_of(options, result), gives_way);
    EXPECT_THAT(notes_of(sure, expected), testing::Not(gives_way));
    ASSERT_TRUE(result && expected);
    EXPECT_EQ(result->output.B, expected->output.B);
    EXPECT_EQ(result->plugins, expected->plugins);

    options = coarse(0.1);
    options.solve.max_iterations = 0;
    Scene open = under_the_sky(plates(0.0, 1.0), 0.5);
    Journal journal;
    EXPECT_THROW(bake(test::registry(), std::move(open), "plates", options, Execution{1, nullptr, &journal}),
                 NotConverged);
    EXPECT_THAT(journal.notes(), testing::Not(gives_way));
}

TEST(HardCases, AMobiusStrip) {
    // One-sided, so it cannot be turned to face one way; every site sees sky, fronts and backs. Nothing is brighter
    // than under the open sky: H <= sky (row sums and what the sky adds are at most 1), and none is negative.
    for (const std::string& engine : engines()) {
        BakeOptions options = coarse(0.12, engine);
        options.basis = "normalized-radial"; // a partition of unity: nothing overshoots,
        options.projection = "natural";      // with its own coefficients
        const BakeResult result = baked(under_the_sky(test::mobius(60), 0.9), options);
        EXPECT_GE(result.output.H.minCoeff(), 0.0);
        EXPECT_LE(result.output.H.maxCoeff(), 1.0 + rounding);
        EXPECT_GT(result.mean_back, 0.0);
        // Almost flat where it turns over (its width is small beside the circle): most of it sees most of the sky.
        EXPECT_GT(result.output.H.mean(), 0.5);
    }
}

TEST(HardCases, FewerSitesThanNeighboursAskedFor) {
    for (const std::string& engine : engines()) {
        for (const int neighbours : {1, 10, 1000}) {
            for (const std::string& basis : test::plugin_names<Basis>()) {
                if (!test::plugin<Basis>(basis)->sums_to_one()) {
                    continue;
                }
                SCOPED_TRACE(engine + ", " + basis + ", " + std::to_string(neighbours));
                BakeOptions options = coarse(0.8, engine);
                options.neighbours = neighbours;
                options.basis = basis;
                expect_furnace(test::box(1.0, 1, true), options);
            }
        }
    }
}

} // namespace
} // namespace difusa::hard_cases_test
