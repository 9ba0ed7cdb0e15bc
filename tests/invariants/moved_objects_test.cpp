// A surface of which objects have moved: the rays that are kept are those that all of them, cast anew, give.
#include <difusa/algebra/hit_lists.h>
#include <difusa/bake/relight.h>
#include <difusa/core/random.h>
#include <difusa/import/placement.h>
#include <difusa/import/shapes.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/radiosity/moved_system.h>
#include <difusa/transport/mirrored.h>

#include <support/discretised.h>
#include <support/lit_scenes.h>
#include <support/saved_bakes.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace difusa::moved_objects_test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

enum Materials : Index { walls, crate, ball, mirror, lamp, count_of_materials };

/// A room with a crate on its floor, which the crate's feet part, and with a ball in mid-air; `mirrors`: a wall before
/// the wall y = 0 reflects, partly in colour, and so does the crate.
Scene room(bool mirrors = false) {
    Scene scene;
    scene.mesh = lit::plain_box(Vec3::Zero(), Vec3(4, 3, 2.5), 1, Front::inside);
    add(scene.mesh, lit::plain_box(Vec3(1.0, 1.0, 0), Vec3(1.3, 1.4, 0.35), 1, Front::outside), crate);
    Mesh sphere_mesh = sphere(0.2, 1, Front::outside);
    move(sphere_mesh, Vec3(2.6, 1.9, 1.2));
    add(scene.mesh, sphere_mesh, ball);
    add(scene.mesh, rectangle(Vec3(0.5, 0.02, 0.5), Vec3(0, 0, 1), Vec3(2, 0, 0)), mirror);
    add(scene.mesh, rectangle(Vec3(1.5, 1.2, 2.4), Vec3(0, 0.6, 0), Vec3(0.6, 0, 0)), lamp);
    scene.materials.resize(count_of_materials);
    const char* const names[] = {"walls", "crate", "ball", "mirror", "lamp"};
    for (std::size_t m = 0; m < count_of_materials; ++m) {
        scene.materials[m].name = names[m];
        scene.materials[m].reflectance = Rgb(0.6, 0.5, 0.4);
    }
    scene.materials[lamp].emission = Rgb(30, 25, 20);
    if (mirrors) {
        scene.materials[mirror].mirror = Rgb(0.3, 0.4, 0.5);
        scene.materials[crate].mirror = Rgb(0.2, 0.2, 0.2);
    }
    settle_mirrors(scene, 4);
    return scene;
}

std::vector<char> marks(const Mesh& mesh, std::initializer_list<Index> materials) {
    std::vector<char> marked;
    for (const Index material : mesh.material) {
        marked.push_back(std::find(materials.begin(), materials.end(), material) != materials.end() ? 1 : 0);
    }
    return marked;
}

RigidMotion motion(const Vec3& offset, double degrees = 0.0, const Vec3& axis = Vec3::UnitZ()) {
    return {rotation(axis, degrees), offset};
}

/// About the vertical through the crate.
RigidMotion turned_crate(double degrees) {
    const Vec3 middle(1.15, 1.2, 0.0);
    const Eigen::Matrix3d turn = rotation(Vec3::UnitZ(), degrees);
    return {turn, Vec3(middle - turn * middle)};
}

FreshParts fresh(const std::string& projection = "") {
    FreshParts parts{test::plugin<Visibility>("cgal"), test::plugin<Basis>("normalized-radial"), {}, false};
    std::string text;
    parts.projection = projection_for(*parts.basis, projection, text);
    return parts;
}

constexpr std::size_t rays = 48;

std::shared_ptr<const RadiositySystem> system_of(const Scene& scene, const std::string& directions = "fibonacci",
                                                 const std::string& projection = "") {
    const auto kept = std::make_shared<Scene>(scene);
    const FreshParts parts = fresh(projection);
    parts.engine->build(kept->mesh);
    const auto set = test::plugin<Directions>(directions);
    Discretisation discretisation =
        discretise(kept->mesh, std::make_shared<SiteSet>(test::poisson_sites(kept->mesh, 0.35)), parts.basis,
                   parts.projection, false, 1, Execution{});
    LightTransport transport = gathered({kept->mesh, *parts.engine}, discretisation.points, *discretisation.surfels,
                                        *set, rays, 1, Execution{});
    return std::make_shared<RadiositySystem>(SystemParts{kept, parts.engine, set, test::plugin<Solver>("krylov"),
                                                         std::move(discretisation), std::move(transport), 1});
}

void expect_same_transport(const LightTransport& a, const LightTransport& b) {
    EXPECT_EQ(a.surfels, b.surfels);
    EXPECT_EQ(a.rays, b.rays);
    EXPECT_EQ(a.bytes, b.bytes);
    EXPECT_EQ(a.sky, b.sky);
    EXPECT_EQ(a.back, b.back);
    EXPECT_EQ(a.back_in_mirrors, b.back_in_mirrors);
    EXPECT_EQ(a.cut_off, b.cut_off);
    const auto &x = dynamic_cast<const HitLists&>(plain_part(*a.W)),
               &y = dynamic_cast<const HitLists&>(plain_part(*b.W));
    EXPECT_EQ(x.packed().row_bytes, y.packed().row_bytes);
    EXPECT_EQ(x.packed().codes, y.packed().codes);
    const auto in_mirrors = part_in_mirrors(*a.W), others = part_in_mirrors(*b.W);
    ASSERT_EQ(in_mirrors == nullptr, others == nullptr);
    if (in_mirrors) {
        EXPECT_EQ(in_mirrors->packed().row_entries, others->packed().row_entries);
        EXPECT_EQ(in_mirrors->packed().column, others->packed().column);
        EXPECT_EQ(in_mirrors->packed().value, others->packed().value);
    }
}

/// All rays of a system cast again.
LightTransport all_anew(const RadiositySystem& system) {
    const Discretisation& discretisation = system.discretisation();
    return gathered(system.tracer(), discretisation.points, *discretisation.surfels, *system.parts().directions, rays,
                    system.parts().seed, Execution{});
}

RecastCount expect_exact(const RadiositySystem& before, std::span<const char> marked, const RigidMotion& how,
                         const std::string& projection = "") {
    RecastCount count, with_threads;
    const auto after = moved_system(before, marked, how, fresh(projection), rays, count, Execution{});
    expect_same_transport(after->transport(), all_anew(*after));
    const auto threaded =
        moved_system(before, marked, how, fresh(projection), rays, with_threads, Execution{3, nullptr, nullptr});
    expect_same_transport(after->transport(), threaded->transport());
    EXPECT_EQ(count.cast, with_threads.cast);
    EXPECT_EQ(count.anew + count.kept, after->transport().rays);
    return count;
}

TEST(MovedObjects, TheTransportIsThatOfAllRaysCastAnew) {
    const auto system = system_of(room());
    const Mesh& mesh = system->parts().scene->mesh;
    struct Case {
        const char* what;
        std::initializer_list<Index> materials;
        RigidMotion motion;
    };
    for (const Case& each :
         {Case{"a crate along the floor", {crate}, motion({0.9, 0.4, 0.0})},
          Case{"over where it was", {crate}, motion({0.1, 0.05, 0.0})}, Case{"turned", {crate}, turned_crate(30.0)},
          Case{"turned and lifted", {crate}, motion({0.5, 0.2, 0.6}, 20.0, Vec3(1, 2, 3))},
          Case{"against a wall", {crate}, motion({-1.0, 0.0, 0.0})},
          Case{"a ball of small triangles", {ball}, motion({-0.7, -0.3, 0.2}, 15.0, Vec3(1, 1, 0))},
          Case{"both together", {crate, ball}, motion({0.3, 0.3, 0.0})},
          Case{"a lamp", {lamp}, motion({0.4, -0.2, -0.3})}}) {
        SCOPED_TRACE(each.what);
        const RecastCount count = expect_exact(*system, marks(mesh, each.materials), each.motion);
        EXPECT_GT(count.anew, 0U);
        EXPECT_GT(count.kept, count.anew); // they are small
    }
}

/// Points of the projection besides the sites go along as well.
TEST(MovedObjects, AllPointsOfGalerkinGoAlong) {
    const auto system = system_of(room(), "fibonacci", "galerkin");
    EXPECT_GT(system->discretisation().points.size(), system->discretisation().sites->size());
    expect_exact(*system, marks(system->parts().scene->mesh, {crate}), turned_crate(40.0), "galerkin");
}

TEST(MovedObjects, MirrorsShowWhatHasMoved) {
    const auto system = system_of(room(true));
    const Mesh& mesh = system->parts().scene->mesh;
    for (const Index which : {Index{crate}, Index{ball}, Index{mirror}}) {
        SCOPED_TRACE(which);
        const RecastCount count = expect_exact(*system, marks(mesh, {which}), motion({0.3, 0.4, 0.0}));
        EXPECT_GT(count.kept, count.anew);
    }
}

TEST(MovedObjects, TheIdentityChangesNothingAndCastsNothing) {
    const auto system = system_of(room());
    RecastCount count;
    const auto same = moved_system(*system, marks(system->parts().scene->mesh, {crate}), {}, fresh(), rays, count, {});
    expect_same_transport(same->transport(), system->transport());
    EXPECT_EQ(count.cast, 0U);
    EXPECT_EQ(count.kept, system->transport().rays);
}

/// Out of the box of the scene, which roundings are relative to.
TEST(MovedObjects, AWiderSceneCastsAllRays) {
    const auto system = system_of(room());
    const RecastCount count =
        expect_exact(*system, marks(system->parts().scene->mesh, {ball}), motion({10.0, 0.0, 0.0}));
    EXPECT_EQ(count.kept, 0U);
}

TEST(MovedObjects, AnotherTransportIsRefused) {
    const auto system = system_of(room()), other = system_of(room(), "low-discrepancy");
    SystemParts mixed = system->parts();
    mixed.transport = other->transport();
    const auto wrong = std::make_shared<RadiositySystem>(mixed);
    RecastCount count;
    EXPECT_THROW(moved_system(*wrong, marks(mixed.scene->mesh, {crate}), motion({0.9, 0.4, 0.0}), fresh(), rays, count,
                              Execution{}),
                 InputError);
}

TEST(MovedObjects, PointsThatOthersNeedAreDoubled) {
    // A crate that shares its lower corners with a floor around it.
    Mesh mesh = rectangle(Vec3::Zero(), Vec3(1, 0, 0), Vec3(0, 1, 0));
    const std::size_t points = mesh.points.size();
    mesh.points.push_back(Vec3(0, 0, 1));
    mesh.points.push_back(Vec3(1, 0, 1));
    const auto top = static_cast<Index>(points);
    Index a = none, b = none;
    for (Index p = 0; p < points; ++p) {
        a = mesh.points[p] == Vec3(0, 0, 0) ? p : a;
        b = mesh.points[p] == Vec3(1, 0, 0) ? p : b;
    }
    mesh.triangles.push_back({a, b, top + 1});
    mesh.triangles.push_back({a, top + 1, top});
    for (int i = 0; i < 2; ++i) {
        mesh.original_face.push_back(static_cast<Index>(mesh.original_face.size()));
        mesh.material.push_back(1);
    }
    mesh.derive();
    ASSERT_EQ(mesh.region_count, 2U);
    const std::vector<char> marked = marks(mesh, {1});
    const Mesh moved = moved_mesh(mesh, marked, motion({0, 0.25, 0}));
    EXPECT_EQ(moved.points.size(), mesh.points.size() + 2);
    EXPECT_EQ(moved.region, mesh.region);
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
            EXPECT_EQ(moved.corner(t, k),
                      Vec3(mesh.corner(t, k) + (marked[t] != 0 ? Vec3(0, 0.25, 0) : Vec3(0, 0, 0))));
        }
    }
    // One triangle of a smooth surface does not go without the others.
    std::vector<char> half(mesh.triangles.size(), 0);
    half.back() = 1;
    EXPECT_THROW(moved_mesh(mesh, half, motion({0, 0.25, 0})), InputError);
}

// ---- by name, with a saved transport
// ---------------------------------------------------------------------------------

BakeOptions bake_options() {
    BakeOptions options = lit::quick(0.3, 64);
    options.every_surface = true;
    return options;
}

RelightOptions moving(const SavedTransport& saved, std::vector<ObjectMove> moves) {
    RelightOptions how;
    how.bake = relight_defaults(saved);
    how.bake.error_points = 0;
    how.moves = std::move(moves);
    return how;
}

BakeResult relit(const SavedTransport& saved, const Scene& scene, const RelightOptions& how) {
    return relight(test::registry(), saved, scene, "scene", how, Execution{2, nullptr, nullptr});
}

void expect_same_light(const BakeResult& a, const BakeResult& b) {
    EXPECT_EQ(a.solution.irradiance, b.solution.irradiance);
    EXPECT_EQ(a.output.B, b.output.B);
    EXPECT_EQ(a.output.H_direct, b.output.H_direct);
}

TEST(MovedObjects, TheIdentityHasTheBitsOfTheSavedTransport) {
    const Scene scene = room();
    const SavedTransport saved = test::through_file(lit::baked(scene, bake_options()));
    const BakeResult moved = relit(saved, scene, moving(saved, {{"crate", 0.0, {}}}));
    expect_same_light(moved, relit(saved, scene, moving(saved, {})));
    EXPECT_EQ(moved.journal.count_of("rays"), 0U);
}

/// A moved transport can be saved, relit, and moved on; a light that was turned down stays a matter of the light.
TEST(MovedObjects, AMovedTransportIsSavedAndMovedAgain) {
    const Scene scene = room();
    BakeOptions options = bake_options();
    options.projection = "galerkin";
    const SavedTransport saved = test::through_file(lit::baked(scene, options));
    const ObjectMove first{"crate", 30.0, motion({0.6, 0.3, 0.0})}, second{"ball", 0.0, motion({-0.5, 0.0, 0.1})};
    const BakeResult once = relit(saved, scene, moving(saved, {first}));
    const SavedTransport again = test::through_file(once);
    expect_same_light(relit(again, scene, moving(again, {})), once);
    const BakeResult twice = relit(again, scene, moving(again, {second}));
    expect_same_light(twice, relit(saved, scene, moving(saved, {first, second})));
    ASSERT_EQ(twice.moved.size(), 2U);
    EXPECT_EQ(twice.moved[1].object, "ball");
    EXPECT_GT(twice.recast->kept, twice.recast->anew);
    // The crate stands on the floor as before, turned by 30 degrees about its middle.
    const Mesh& mesh = once.scene->mesh;
    Eigen::AlignedBox3d box;
    for (const Index t : once.moved[0].triangles) {
        box.extend(mesh.box(t));
    }
    EXPECT_NEAR((box.center() - Vec3(1.75, 1.5, 0.175)).norm(), 0.0, 1e-14);
    EXPECT_NEAR(box.sizes().x(), 0.3 * std::sqrt(0.75) + 0.4 * 0.5, 1e-14);
    EXPECT_EQ(box.min().z(), 0.0);
}

/// sqrt of the mean over the area of the sum of the squares of all channels.
double rms(const Mesh& mesh, const BakeResult& a, const BakeResult& b) {
    const std::vector<SurfacePoint> points = even_points(mesh, 4000, RandomStream(3, "points"));
    const PointValues at_a = a.field().at(points, 0, 1, "test", Execution{}),
                      at_b = b.field().at(points, 0, 1, "test", Execution{});
    return std::sqrt((at_a.B - at_b.B).squaredNorm() / static_cast<double>(points.size()));
}

/// The two differ in all sites and rays. If each deviates from the truth by no more than the upper end of its own
/// estimate, they differ by no more than the sum.
TEST(MovedObjects, AgreesWithAFreshBakeWithinTheEstimatedErrors) {
    const Scene scene = room();
    BakeOptions options = bake_options();
    options.rays = 256;
    options.error_points = 256;
    const SavedTransport saved = test::through_file(lit::baked(scene, options));
    RelightOptions how = moving(saved, {{"crate", 25.0, motion({1.4, 0.6, 0.0})}});
    how.bake.error_points = 256;
    const BakeResult moved = relit(saved, scene, how);
    Scene elsewhere = scene;
    elsewhere.mesh = moved.scene->mesh;
    options.seed = 2;
    const BakeResult afresh = lit::baked(elsewhere, options);
    const double difference = rms(elsewhere.mesh, moved, afresh);
    EXPECT_LT(difference, moved.error->total.high + afresh.error->total.high);
    EXPECT_GT(difference, 0.0);
    EXPECT_GT(moved.recast->kept, 5 * moved.recast->anew);
}

TEST(MovedObjects, WhatCannotBeMovedIsRefused) {
    const Scene scene = room();
    const SavedTransport saved = test::through_file(lit::baked(scene, bake_options()));
    const auto moved = [&](const std::string& object, const RigidMotion& how) {
        return [&, object, how] { relit(saved, scene, moving(saved, {{object, 0.0, how}})); };
    };
    EXPECT_THAT(moved("crat", motion({1, 0, 0})), ThrowsMessage<UsageError>(HasSubstr("did you mean crate?")));
    EXPECT_THAT(moved("12-", motion({1, 0, 0})), ThrowsMessage<UsageError>(HasSubstr("there is no object")));
    EXPECT_THAT(moved("0", motion({1, 0, 0})), ThrowsMessage<UsageError>(HasSubstr("joined smoothly")));
    RigidMotion larger;
    larger.rotation *= 2.0;
    EXPECT_THAT(moved("crate", larger), ThrowsMessage<UsageError>(HasSubstr("must be rigid")));
    RigidMotion mirrored_motion;
    mirrored_motion.rotation(0, 0) = -1.0;
    EXPECT_THAT(moved("crate", mirrored_motion), ThrowsMessage<UsageError>(HasSubstr("must be rigid")));
    BakeOptions pairs = bake_options();
    pairs.transport = "pairwise";
    const SavedTransport in_pairs = test::through_file(lit::baked(scene, pairs));
    EXPECT_THAT(
        [&] {
            relit(in_pairs, scene, moving(in_pairs, {{"crate", 0.0, motion({1, 0, 0})}}));
        },
        ThrowsMessage<UsageError>(HasSubstr("pairwise")));
}

TEST(MovedObjects, ObjectsAreFoundByMeshMaterialAndFace) {
    Scene scene = room();
    const std::vector<SoupPart> parts{{"room.obj", 0, 0, "shell"}, {"things.obj", 12, 8, "things"}};
    const auto found = [&](const std::string& name) {
        return triangles_of_object(name, scene, parts, scene.mesh.triangles.size());
    };
    const Mesh& mesh = scene.mesh;
    std::vector<Index> crates, things;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (mesh.material[t] == crate) {
            crates.push_back(t);
        }
        if (mesh.original_face[t] >= 12) {
            things.push_back(t);
        }
    }
    EXPECT_EQ(found("crate"), crates);
    EXPECT_EQ(found("things"), things);
    EXPECT_EQ(found("0-3"), (std::vector<Index>{0, 1, 2, 3}));
    EXPECT_EQ(found("3"), (std::vector<Index>{3}));
}

} // namespace
} // namespace difusa::moved_objects_test
