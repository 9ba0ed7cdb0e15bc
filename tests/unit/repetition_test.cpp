// Symmetry planes and periods: which fit together, where the images are, and rays among them against a mesh that has
// all of the images.
#include <difusa/core/random.h>
#include <difusa/core/text.h>
#include <difusa/mesh/mesh.h>
#include <difusa/rays/brute_force.h>
#include <difusa/rays/unfolded_visibility.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <support/plugins.h>
#include <support/refusal.h>
#include <support/unfolded.h>

#include <cmath>
#include <numbers>

namespace difusa::repetition_test {
namespace {

using test::at_angle;
using test::plane;
using testing::AllOf;
using testing::HasSubstr;

constexpr double pi = std::numbers::pi;

/// A small square at (x, y), between 0.5 and 0.6 high.
Mesh square_at(double x, double y) {
    return rectangle(Vec3(x - 0.1, y - 0.1, 0.5), Vec3(0.2, 0, 0), Vec3(0, 0.2, 0.1));
}

Mesh settled(Mesh mesh, Repetition repetition) {
    mesh.repetition = std::move(repetition);
    settle_repetition(mesh);
    return mesh;
}

std::size_t image_count(Repetition repetition, std::size_t depth, const Vec3& at = Vec3(1.0, 0.3, 0.5)) {
    return settled(square_at(at.x(), at.y()), std::move(repetition)).repetition.images(depth).size();
}

TEST(Repetition, HasAsManyImagesAsItsPlanesAndPeriodsAllow) {
    EXPECT_EQ(image_count({}, 5), 1U);
    EXPECT_EQ(image_count(test::repeated({plane({0, 1, 0})}, {}), 5), 2U);
    EXPECT_EQ(image_count(test::repeated({plane({0, 1, 0}), plane({1, 0, 0})}, {}), 5), 4U);
    EXPECT_EQ(image_count(test::repeated({plane({0, 1, 0}), plane({1, 0, 0}), plane({0, 0, 1})}, {}), 5), 8U);
    for (const int n : {3, 4, 5}) { // the square is at 17 degrees
        EXPECT_EQ(image_count(test::repeated({plane({0, 1, 0}), plane(at_angle(pi / n))}, {}), 5),
                  2U * static_cast<unsigned>(n));
    }
    EXPECT_EQ(image_count(test::repeated({plane({0, 1, 0}), plane(at_angle(pi / 3)), plane({0, 0, 1})}, {}), 5), 12U);
    EXPECT_EQ(image_count(test::repeated({plane({0, 1, 0}), plane({0, -1, 0}, {0, 2, 0})}, {}), 5), 11U);
    EXPECT_EQ(image_count(test::repeated({}, {Vec3(0, 3, 0)}), 5), 11U);
    EXPECT_EQ(image_count(test::repeated({plane({1, 0, 0})}, {Vec3(0, 3, 0), Vec3(0, 0, 2)}), 2), 50U);
}

TEST(Repetition, ImagesOfAWedgeAreDistinctAndClosed) {
    const Mesh mesh = settled(square_at(1.0, 0.3), test::repeated({plane({0, 1, 0}), plane(at_angle(pi / 3))}, {}));
    const auto images = mesh.repetition.images(0);
    const Vec3 p(1.0, 0.3, 0.5);
    std::size_t reflections = 0;
    for (std::size_t i = 0; i < images.size(); ++i) {
        reflections += images[i].reflects() ? 1 : 0;
        for (std::size_t j = 0; j < i; ++j) {
            EXPECT_GT((images[i](p) - images[j](p)).norm(), 0.1);
        }
        // Reflected once more, each is another of them.
        const Vec3 again = mesh.repetition.walls[1].back(images[i](p));
        EXPECT_TRUE(std::any_of(images.begin(), images.end(),
                                [&](const Repetition::Image& image) { return (image(p) - again).norm() < 1e-12; }));
    }
    EXPECT_EQ(reflections, 3U);
}

TEST(Repetition, PlanesAreBroughtToTheAngleThatSixDigitsMean) {
    const Mesh mesh = settled(square_at(1.0, 0.3), test::repeated({plane({0, 1, 0}), plane({0.866025, -0.5, 0})}, {}));
    EXPECT_NEAR(mesh.repetition.walls[0].normal.dot(mesh.repetition.walls[1].normal), -0.5, 1e-15);
    EXPECT_EQ(mesh.repetition.walls[0].normal, Vec3(0, 1, 0));
}

TEST(Repetition, RefusesWhatDoesNotFitTogether) {
    const auto refusal = [](Repetition repetition, const Vec3& at = Vec3(1.0, 0.3, 0.5)) {
        return test::refusal_of([&] { settled(square_at(at.x(), at.y()), std::move(repetition)); }, "repetition");
    };
    EXPECT_THAT(refusal(test::repeated({plane({0, 1, 0}), plane(at_angle(0.4 * pi))}, {})), HasSubstr("72 degrees"));
    EXPECT_THAT(refusal(test::repeated({plane({0, 1, 0}), plane(at_angle(0.7 * pi))}, {})), HasSubstr("126 degrees"));
    for (const double off : {2e-5, 1e-4, 1e-2}) {
        EXPECT_THAT(refusal(test::repeated({plane({0, 1, 0}), plane({off, -1, 0}, {0, 2, 0})}, {})),
                    HasSubstr("nearly parallel"));
    }
    EXPECT_NO_THROW(settled(square_at(3.0, 0.13), test::repeated({plane({0, 1, 0}), plane(at_angle(pi / 36))}, {})));
    EXPECT_THAT(refusal(test::repeated({plane({0, 1, 0}), plane({0, 1, 0}, {0, 0.1, 0})}, {})),
                HasSubstr("face the same way"));
    EXPECT_THAT(refusal(test::repeated({plane({0, 1, 0}), plane({0, -1, 0}, {0, -1, 0})}, {})), HasSubstr("face away"));
    EXPECT_THAT(refusal(test::repeated({plane({0, 1, 0}), plane(at_angle(pi / 3)), plane(at_angle(pi / 6))}, {})),
                HasSubstr("only two planes"));
    EXPECT_THAT(refusal(test::repeated({plane({0, 1, 0})}, {Vec3(0, 3, 0)})), HasSubstr("half a period"));
    EXPECT_THAT(refusal(test::repeated({plane({0, 1, 0})}, {Vec3(0, 3, 1)})),
                HasSubstr("not at right angles to the normal"));
    EXPECT_THAT(refusal(test::repeated({}, {Vec3(0, 3, 0), Vec3(1, 3, 0)})),
                HasSubstr("not at right angles to period 1"));
    EXPECT_THAT(refusal(test::repeated({}, {Vec3(0, 0, 0)})), HasSubstr("no length"));
    // Geometry on the wrong side, and too long for the period.
    EXPECT_THAT(refusal(test::repeated({plane({0, 1, 0}, {0, 0.25, 0})}, {})),
                AllOf(HasSubstr("face 0 reaches (0.9, 0.2, 0.5), 0.05 m behind symmetry plane 1")));
    EXPECT_THAT(refusal(test::repeated({}, {Vec3(0, 0.15, 0)})),
                AllOf(HasSubstr("0.2 m from"), HasSubstr("which is 0.15 m long")));
}

TEST(Repetition, AFaceMayTouchAPlaneAndFillAPeriod) {
    Mesh mesh = square_at(1.0, 0.3);
    EXPECT_NO_THROW(settled(mesh, test::repeated({plane({0, 1, 0}, {0, 0.2, 0})}, {})));
    EXPECT_NO_THROW(settled(mesh, test::repeated({}, {Vec3(0, 0.2, 0)})));
    EXPECT_FALSE(settled(box(Vec3::Zero(), Vec3::Ones(), 1, Front::inside), test::repeated({}, {Vec3(0, 1, 0)})).convex)
        << "the unfolded surface is not";
}

// ---- rays against a mesh that has all images ------------------------------------------------------------------

/// Triangles anywhere in a part of a wedge, slab or period.
template <class Accept> Mesh clutter(const Accept& accept) {
    RandomStream random(11, "clutter");
    const auto anywhere = [&] { return Vec3(2.0 * random.uniform(), 2.0 * random.uniform(), random.uniform()); };
    Mesh mesh;
    while (mesh.triangles.size() < 12) {
        const Vec3 a = anywhere(), b = a + 0.5 * (anywhere() - Vec3(1, 1, 0.5)),
                   c = a + 0.5 * (anywhere() - Vec3(1, 1, 0.5));
        if (accept(a) && accept(b) && accept(c)) {
            const auto first = static_cast<Index>(mesh.points.size());
            mesh.points.insert(mesh.points.end(), {a, b, c});
            mesh.triangles.push_back({first, first + 1, first + 2});
        }
    }
    mesh.original_face.resize(mesh.triangles.size());
    mesh.material.resize(mesh.triangles.size());
    mesh.derive();
    return mesh;
}

struct Case {
    const char* name;
    Repetition repetition;
    std::size_t depth; ///< of the images that are made
    double reach;      ///< rays that go no farther stay among them
};

std::vector<Case> cases() {
    return {{"one plane", test::repeated({plane({0, 1, 0})}, {}), 0, 1e3},
            {"90 degrees", test::repeated({plane({0, 1, 0}), plane({1, 0, 0})}, {}), 0, 1e3},
            {"60 degrees", test::repeated({plane({0, 1, 0}), plane(at_angle(pi / 3))}, {}), 0, 1e3},
            {"45 degrees and a floor",
             test::repeated({plane({0, 1, 0}), plane(at_angle(pi / 4)), plane({0, 0, 1})}, {}), 0, 1e3},
            {"parallel", test::repeated({plane({0, 1, 0}), plane({0, -1, 0}, {0, 2, 0})}, {}), 12, 20.0},
            {"period", test::repeated({}, {Vec3(0, 2.5, 0)}), 12, 20.0},
            {"period and plane", test::repeated({plane({1, 0, 0})}, {Vec3(0, 2.5, 0)}), 12, 20.0},
            {"lattice", test::repeated({}, {Vec3(2.5, 0, 0), Vec3(0, 2.5, 0)}), 6, 10.0}};
}

Mesh cell(const Repetition& repetition) {
    return settled(clutter([&](const Vec3& p) {
                       return std::all_of(
                                  repetition.planes.begin(), repetition.planes.end(),
                                  [&](const Repetition::Plane& at) { return at.normal.dot(p - at.point) > 0.01; }) &&
                              p.y() > 0.0 && p.y() < 2.4 && p.x() > -0.1 && p.x() < 2.3;
                   }),
                   repetition);
}

class UnfoldedEngines : public testing::TestWithParam<std::string> {};

TEST_P(UnfoldedEngines, FindWhatAMeshOfAllImagesFinds) {
    for (const Case& c : cases()) {
        SCOPED_TRACE(c.name);
        const Mesh mesh = cell(c.repetition), whole = test::unfolded(mesh, c.depth), near = test::unfolded(mesh, 2);
        const auto folded = built_over(mesh, test::plugin<Visibility>(GetParam()));
        BruteForceVisibility twin;
        twin.build(whole);
        RandomStream random(5, c.name);
        const auto anywhere = [&](double size) {
            return Vec3(size * (random.uniform() - 0.5), size * (random.uniform() - 0.5),
                        size * (random.uniform() - 0.5));
        };
        std::size_t beyond = 0;
        for (int i = 0; i < 400; ++i) {
            // From faces of the cell, and from anywhere, also behind planes and in other periods.
            Ray ray{anywhere(6.0), anywhere(2.0), none};
            if (i % 2 == 0) {
                ray.face = static_cast<Index>(random.below(mesh.triangles.size()));
                ray.origin = mesh.at(ray.face, 0.3, 0.3).position;
            }
            if (i % 4 < 2) { // towards an image
                const auto to = static_cast<Index>(random.below(near.triangles.size()));
                ray.direction = near.at(to, 0.3, 0.4).position - ray.origin;
            }
            Hit here, there;
            folded->first_hits({&ray, 1}, {&here, 1});
            twin.first_hits({&ray, 1}, {&there, 1});
            if (here.t * ray.direction.norm() > c.reach || there.t * ray.direction.norm() > c.reach) {
                continue;
            }
            const auto count = static_cast<Index>(mesh.triangles.size());
            ASSERT_EQ(here.face, there.face == none ? none : there.face % count) << i;
            EXPECT_FALSE(here.cut_off);
            if (here.face != none) {
                beyond += there.face >= count ? 1 : 0;
                EXPECT_EQ(here.front, there.front);
                EXPECT_NEAR(here.t, there.t, 1e-10 * (1.0 + there.t));
            }
            const Segment segment{ray.origin, Vec3(ray.origin + 3.0 * ray.direction), ray.face, none};
            std::uint8_t blocked = 0, expected = 0;
            folded->occluded({&segment, 1}, {&blocked, 1});
            twin.occluded({&segment, 1}, {&expected, 1});
            EXPECT_EQ(blocked, expected) << i;
        }
        EXPECT_GT(beyond, 50U) << "of 400 rays";
    }
}

INSTANTIATE_TEST_SUITE_P(Engines, UnfoldedEngines, testing::ValuesIn(test::plugin_names<Visibility>()));

TEST(UnfoldedVisibility, SegmentsEndOnImagesOfFaces) {
    for (const Case& c : cases()) {
        SCOPED_TRACE(c.name);
        const Mesh mesh = cell(c.repetition), whole = test::unfolded(mesh, 1);
        const auto folded = built_over(mesh, test::plugin<Visibility>("cgal"));
        BruteForceVisibility twin;
        twin.build(whole);
        RandomStream random(6, c.name);
        for (int i = 0; i < 200; ++i) {
            const auto from = static_cast<Index>(random.below(mesh.triangles.size()));
            const auto to = static_cast<Index>(random.below(whole.triangles.size()));
            const Vec3 x = mesh.at(from, 0.2, 0.4).position, y = whole.at(to, 0.4, 0.3).position;
            const Segment there{x, y, from, to}, here{x, y, from, static_cast<Index>(to % mesh.triangles.size())};
            std::uint8_t blocked = 0, expected = 0;
            folded->occluded({&here, 1}, {&blocked, 1});
            twin.occluded({&there, 1}, {&expected, 1});
            EXPECT_EQ(blocked, expected) << i;
        }
    }
}

TEST(UnfoldedVisibility, RaysInAnEmptySeriesAreCutOffOnlyIfTheyDoNotLeaveIt) {
    Mesh mesh = rectangle(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0));
    mesh = settled(std::move(mesh), test::repeated({}, {Vec3(0, 1, 0)}));
    const auto engine = built_over(mesh, test::plugin<Visibility>("cgal"));
    const auto hit = [&](const Vec3& origin, const Vec3& direction) {
        const Ray ray{origin, direction, none};
        Hit met;
        engine->first_hits({&ray, 1}, {&met, 1});
        return met;
    };
    EXPECT_EQ(hit({0.5, 0.5, 1e-6}, {0, 1, 0}).face, none);
    EXPECT_TRUE(hit({0.5, 0.5, 1e-6}, {0, 1, 0}).cut_off) << "along the strip for ever";
    EXPECT_FALSE(hit({0.5, 0.5, 1.0}, {0, 1, 0}).cut_off) << "above all that there is";
    EXPECT_FALSE(hit({0.5, 0.5, 1e-6}, {0, 1, 0.001}).cut_off);
    EXPECT_NEAR(hit({0.5, 0.5, 1.0}, {0, 50, -1}).t, 1.0, 1e-12) << "fifty periods on";
}

/// A face in the plane y = x beside the plane x = 0 sees its own image.
TEST(UnfoldedVisibility, AFaceSeesItsOwnImage) {
    const Mesh mesh =
        settled(rectangle(Vec3(0, 0, 0), Vec3(1, 1, 0), Vec3(0, 0, 1)), test::repeated({plane({1, 0, 0})}, {}));
    ASSERT_LT(mesh.normals[0].y(), 1.0);
    const Vec3 inwards(-1, 0, 0);
    const auto engine = built_over(mesh, test::plugin<Visibility>("cgal"));
    for (const bool to_image : {true, false}) {
        const Ray ray{Vec3(0.5, 0.5, 0.5), to_image ? inwards : Vec3(1, 0, 0), 0};
        Hit hit;
        engine->first_hits({&ray, 1}, {&hit, 1});
        EXPECT_EQ(hit.face == none, !to_image);
        EXPECT_TRUE(!to_image || std::abs(hit.t - 1.0) < 1e-12);
    }
}

/// A face in an oblique symmetry plane is not hidden by itself, on whichever side of the plane rounding leaves its
/// points.
TEST(UnfoldedVisibility, AFaceInAPlaneDoesNotHideItself) {
    RandomStream random(7, "planes");
    for (int i = 0; i < 200; ++i) {
        const Vec3 normal = at_angle(2.0 * pi * random.uniform());
        const Vec3 along = normal.cross(Vec3::UnitZ()), origin(random.uniform(), random.uniform(), 0.0);
        Mesh mesh = rectangle(origin, along, Vec3::UnitZ());
        if (mesh.normals[0].dot(normal) < 0.0) {
            mesh = rectangle(origin + along, -along, Vec3::UnitZ());
        }
        add(mesh, rectangle(origin + normal, along, Vec3::UnitZ()), 0); // opposite
        mesh = settled(mesh, test::repeated({plane(normal, origin)}, {}));
        const auto opposite = static_cast<Index>(2 + random.below(2));
        for (const std::string& name : test::plugin_names<Visibility>()) {
            const auto engine = built_over(mesh, test::plugin<Visibility>(name));
            for (int k = 0; k < 20; ++k) {
                const Segment segment{mesh.at(opposite, 0.3, 0.3).position,
                                      mesh.at(0, 0.5 * random.uniform(), 0.5 * random.uniform()).position, opposite, 0};
                std::uint8_t blocked = 1;
                engine->occluded({&segment, 1}, {&blocked, 1});
                EXPECT_EQ(blocked, 0) << name;
            }
        }
    }
}

TEST(UnfoldedVisibility, IsNotThereWhereNothingRepeats) {
    const Mesh mesh = square_at(0, 0);
    const std::shared_ptr<Visibility> engine = test::plugin<Visibility>("cgal");
    EXPECT_EQ(built_over(mesh, engine), engine);
}

} // namespace
} // namespace difusa::repetition_test
