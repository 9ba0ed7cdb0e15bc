// The form factors of M over mirror patches, against what mirrors show exactly.
#include <difusa/core/error.h>
#include <difusa/core/random.h>
#include <difusa/import/shapes.h>
#include <difusa/rays/lambert.h>
#include <difusa/study/mirror_study.h>
#include <difusa/transport/mirror_patches.h>

#include <support/discretised.h>
#include <support/plugins.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

namespace difusa::mirror_patches_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double eps = std::numeric_limits<double>::epsilon();

// M eq. 2: an emitter in N discs. Away from it the midpoint rule converges with the square of the discs' spacing, and
// what the disc adds to pi r² with their area: with 1/N, by 4 each time the squares are halved.
TEST(DiscFactors, ConvergeToThePolygonsFactorAsTheEmitterIsDivided) {
    const auto kernel = test::plugin<Kernel>("disc");
    const Vec3 x(0.3, -0.4, 0.0), n = Vec3(0.2, 0.3, 1.0).normalized();
    const Vec3 a(0, 0, 1), b(0, 1, 1), c(1, 1, 1), d(1, 0, 1); // faces down
    const double exact = lambert_form_factor(x, n, a, b, c) + lambert_form_factor(x, n, a, c, d);
    const auto error = [&](int parts) {
        double sum = 0.0;
        for (int i = 0; i < parts; ++i) {
            for (int j = 0; j < parts; ++j) {
                sum += kernel->form_factor(x, n, Vec3((i + 0.5) / parts, (j + 0.5) / parts, 1.0), -Vec3::UnitZ(),
                                           1.0 / (parts * parts));
            }
        }
        return std::abs(sum - exact);
    };
    for (const int parts : {8, 16, 32}) { // the next term of the error is of fourth order: below 2 % of the ratio
        EXPECT_NEAR(error(parts) / error(2 * parts), 4.0, 0.1) << parts;
    }
}

// M eq. 5 to 10: one mirror patch, on a straightened path.
TEST(MirrorFactors, EqualTheClosedFormOfOneMirrorAndAreBounded) {
    const auto kernel = test::plugin<Kernel>("disc");
    RandomStream random(1, "paths");
    for (int i = 0; i < 2000; ++i) {
        const auto cosine = [&] { return 0.01 + 0.99 * random.uniform(); };
        const double r = std::pow(10.0, 4.0 * random.uniform() - 2.0), r_S = r * (0.001 + 0.998 * random.uniform());
        const double A_E = 0.1 + random.uniform(), A_S = std::pow(10.0, 6.0 * random.uniform() - 6.0);
        const double cos_R = cosine(), cos_S = cosine(), cos_E = cosine();
        // A path along z from R at the origin to E.
        const Vec3 n_R(std::sqrt(1.0 - cos_R * cos_R), 0, cos_R), n_E(std::sqrt(1.0 - cos_E * cos_E), 0, -cos_E);
        const double f_disc = kernel->form_factor(Vec3::Zero(), n_R, Vec3(0, 0, r), n_E, A_E);
        const double f = f_disc * share_in_sight(small_solid_angle(A_S, cos_S, r_S), small_solid_angle(A_E, cos_E, r));
        const double eq_10 = cos_R / (pi * r * r + A_E) * A_S * cos_S * r * r / (r_S * r_S); // times A_E
        const double seen = A_S * cos_S * r * r / (r_S * r_S * cos_E);                       // A'_E, eq. 7 and 8
        if (seen < A_E) {
            EXPECT_NEAR(f, eq_10, 64 * eps * eq_10);
        } else {
            EXPECT_NEAR(f, f_disc, 64 * eps * f_disc) << "all of the emitter is seen";
        }
        EXPECT_LE(f, cos_R * cos_E * (1 + 64 * eps)) << "bounded, however near the mirror";
    }
}

// M eq. 11 to 13.
TEST(MirrorFactors, OfChainsFollowTheLeastSolidAngle) {
    EXPECT_DOUBLE_EQ(small_solid_angle(0.02, 0.5, 10.0), 1e-4);
    const double omega = 3e-4;
    for (const auto& chain : {std::vector{1e-4, 5e-4, 9e-4}, std::vector{5e-4, 1e-4, 9e-4}, std::vector{4e-4, 5e-4}}) {
        const double least = *std::min_element(chain.begin(), chain.end());
        EXPECT_DOUBLE_EQ(share_in_sight(least, omega), std::min(least, omega) / omega);
    }
}

TEST(MirrorPatches, CoverTheMirrorsOnceAndSoDoTheirQuarters) {
    MirrorSituation situation = double_mirror(1.0);
    const Mesh& mesh = situation.scene.mesh;
    const double edge = 0.17;
    const std::vector<MirrorPatch> patches = mirror_patches(mesh, edge, Execution{1});
    EXPECT_EQ(patches.size(), mirror_patch_count(mesh, edge));
    EXPECT_THROW(mirror_patch_count(mesh, 1e-12), ResourceError);
    EXPECT_THROW(mirror_patches(mesh, 1e-200, Execution{1}), ResourceError);
    double area = 0.0;
    Vec3 moment = Vec3::Zero(), quarter_moment = Vec3::Zero();
    for (const MirrorPatch& patch : patches) {
        const double A = mesh.areas[patch.triangle] * patch.size * patch.size;
        EXPECT_LE(std::sqrt(2.0 + 1.5 * 1.5) * std::abs(patch.size), edge); // the diagonal of sqrt(2) by 1.5
        area += A;
        moment += A * mesh.at(patch.triangle, patch.u, patch.v).position;
        for (const MirrorPatch& quarter : quartered(patch)) {
            EXPECT_DOUBLE_EQ(std::abs(quarter.size), 0.5 * std::abs(patch.size));
            quarter_moment += 0.25 * A * mesh.at(quarter.triangle, quarter.u, quarter.v).position;
        }
    }
    // Two mirrors of sqrt(2) by 1.5 with the centres (1.5, 0.5, 2.5) and (1.5, 0.5, 0.5).
    const double exact = 2.0 * std::sqrt(2.0) * 1.5;
    EXPECT_NEAR(area, exact, 1e-12);
    EXPECT_LT((moment / area - Vec3(1.5, 0.5, 1.5)).norm(), 1e-12);
    EXPECT_LT((quarter_moment / area - Vec3(1.5, 0.5, 1.5)).norm(), 1e-12);
}

/// A situation with sites, and the pairs of sites of which one is on the emitter and one on the receiver.
struct Sited {
    MirrorSituation situation;
    test::Discretised discretised;

    Sited(MirrorSituation made, double spacing)
        : situation(std::move(made)), discretised(situation.scene, spacing, "cgal", "normalized-radial") {}

    MirroredFactors factors(const MirrorPathOptions& paths, const char* kernel = "disc", unsigned threads = 1) const {
        return mirrored_factors(discretised.tracer(), discretised.discretisation, *test::plugin<Kernel>(kernel), paths,
                                Execution{threads, nullptr, nullptr});
    }
    std::vector<Index> of_material(Index material) const {
        std::vector<Index> list;
        for (Index i = 0; i < discretised.sites().size(); ++i) {
            if (discretised.scene.mesh.material[discretised.sites().points[i].face] == material) {
                list.push_back(i);
            }
        }
        return list;
    }
    double A(Index i) const { return discretised.sites().area[i]; }
};

double entry(const MirroredFactors& factors, Index row, Index column) {
    const SparseRows::Row& entries = factors.rows[row];
    const auto found = std::lower_bound(entries.column.begin(), entries.column.end(), column);
    return found != entries.column.end() && *found == column
               ? entries.value[static_cast<std::size_t>(found - entries.column.begin())]
               : 0.0;
}

/// The form factor from j to the image of k.
double unfolded(const Sited& sited, Index j, Index k) {
    SurfacePoint y = sited.discretised.sites().points[k];
    for (std::size_t m = sited.situation.mirrors.size(); m > 0; --m) {
        const MirrorSituation::Rectangle& mirror = sited.situation.mirrors[m - 1];
        const Vec3 n = (mirror[1] - mirror[0]).cross(mirror[3] - mirror[0]).normalized();
        y.position -= 2.0 * n.dot(y.position - mirror[0]) * n;
        y.normal = mirrored(y.normal, n);
    }
    const SurfacePoint& x = sited.discretised.sites().points[j];
    return test::plugin<Kernel>("disc")->form_factor(x.position, x.normal, y.position, y.normal, sited.A(k));
}

/// Rms difference of all factors from the emitter to the receiver to those of the unfolded scene, over their rms.
double error_of(const Sited& sited, const MirrorPathOptions& paths) {
    const MirroredFactors factors = sited.factors(paths);
    double squares = 0.0, size = 0.0;
    for (const Index j : sited.of_material(1)) {
        for (const Index k : sited.of_material(0)) {
            const double exact = unfolded(sited, j, k), error = entry(factors, j, k) - exact;
            squares += error * error;
            size += exact * exact;
        }
    }
    return std::sqrt(squares / size);
}

// Through mirrors in which everything is seen, the factors become those of the unfolded scene. Inside the emitter the
// midpoint rule over patches integrates smooth elements; at its edges, where they end, the outermost patches count in
// full or not at all, so that the error falls with the size of the patches. How the edges lie to the rows of patches
// changes the errors of single cases; they are taken together.
TEST(MirrorFactors, ConvergeToThoseOfTheUnfoldedSceneOverOneMirrorAndTwo) {
    double coarse = 0.0, fine = 0.0;
    for (const bool twice : {false, true}) {
        const Sited sited(twice ? double_mirror(1.0) : single_mirror(1.0, 1.0), 0.35);
        for (const MirrorPaths paths : {MirrorPaths::gathered, MirrorPaths::shot}) {
            coarse += std::pow(error_of(sited, {paths, 0.6, false}), 2);
            fine += std::pow(error_of(sited, {paths, 0.15, false}), 2);
        }
    }
    // Two halvings of the patches: 4, with errors of order 1.
    EXPECT_GT(std::sqrt(coarse / fine), 3.0) << std::sqrt(coarse) << " " << std::sqrt(fine);
    EXPECT_LT(std::sqrt(fine / 4.0), 0.04);
}

// Quartered, patches err no more than if all were as small as the smallest of them need be.
TEST(MirrorFactors, AreAsGoodFromPatchesQuarteredWhereTheyMatter) {
    const Sited sited(single_mirror(1.0, 2.0), 0.35);
    for (const MirrorPaths paths : {MirrorPaths::gathered, MirrorPaths::shot}) {
        const double even = error_of(sited, {paths, 1.0, false}), quartered = error_of(sited, {paths, 1.0, true});
        EXPECT_LT(quartered, 0.7 * even) << even << " " << quartered;
    }
}

TEST(MirrorFactors, AreReciprocalFromBothEndsOfAPath) {
    const Sited sited(double_mirror(1.0), 0.3);
    // The point kernel is reciprocal; the disc kernel takes the other end as a point.
    const MirroredFactors gathered = sited.factors({MirrorPaths::gathered, 1.0, true}, "point");
    const MirroredFactors shot = sited.factors({MirrorPaths::shot, 1.0, true}, "point");
    std::size_t compared = 0;
    for (Index a = 0; a < gathered.rows.size(); ++a) {
        for (const Index b : gathered.rows[a].column) {
            const double there = sited.A(a) * entry(gathered, a, b), back = sited.A(b) * entry(shot, b, a);
            EXPECT_NEAR(there, back, 1e-12 * there); // sums of up to some hundred equal terms
            ++compared;
        }
    }
    EXPECT_GT(compared, 100U);
}

// As printed, a vertex receives over all mirror patches by which the emitter's centre sees its surroundings, while the
// patches that show it the emitter are others: where the receiver is as far from the mirror as the emitter, both are
// equally many, and otherwise their ratio is that of the solid angles under which the mirror sees both elements.
TEST(MirrorFactors, AsPrintedTendToTheRatioOfTheSolidAnglesAtTheMirror) {
    for (const auto& [to, from] : {std::pair(4.0, 4.0), std::pair(4.0, 2.0)}) {
        const Sited sited(single_mirror(to, from), 0.3);
        const MirroredFactors factors = sited.factors({MirrorPaths::printed, 0.1, false});
        double sum = 0.0, expected = 0.0, proper = 0.0;
        for (const Index j : sited.of_material(1)) {
            for (const Index k : sited.of_material(0)) {
                // Both ends are parallel to the mirror: cosines are equal, distances to it are in the ratio to : from.
                const double ratio = sited.A(j) * to * to / (sited.A(k) * from * from), f = unfolded(sited, j, k);
                sum += entry(factors, j, k);
                expected += f * ratio;
                proper += f;
            }
        }
        EXPECT_NEAR(sum, expected, 0.02 * expected) << to << " " << from;
        EXPECT_GT(expected, (to == from ? 0.98 : 3.8) * proper);
    }
}

// The correction for shared vertices: over one mirror patch a receiver takes once what the path carries, not once for
// each of the m + 1 or so elements that live where it ends.
TEST(MirrorFactors, AsPrintedCountAPathOnce) {
    const Sited sited(single_mirror(2.0, 2.0), 0.3);
    const MirroredFactors factors = sited.factors({MirrorPaths::printed, 100.0, false}); // two patches
    std::size_t ended = 0;
    for (const Index k : sited.of_material(0)) {
        double sum = 0.0, largest = 0.0;
        std::size_t receivers = 0;
        for (const Index j : sited.of_material(1)) {
            if (const double value = entry(factors, j, k); value > 0.0) {
                sum += value;
                largest = std::max(largest, unfolded(sited, j, k));
                ++receivers;
            }
        }
        if (receivers > 0) {
            EXPECT_GT(receivers, 3U);
            EXPECT_LE(sum, 2.0 * largest * (1 + 8 * eps)) << "at most once over each of the two patches";
            ++ended;
        }
    }
    EXPECT_GT(ended, 0U);
}

TEST(MirrorFactors, DoNotDependOnTheNumberOfThreads) {
    const Sited sited(double_mirror(1.0), 0.3);
    for (const MirrorPaths paths : {MirrorPaths::gathered, MirrorPaths::printed}) {
        const MirroredFactors one = sited.factors({paths, 1.0, true}),
                              three = sited.factors({paths, 1.0, true}, "disc", 3);
        EXPECT_EQ(one.rays, three.rays);
        for (std::size_t j = 0; j < one.rows.size(); ++j) {
            EXPECT_EQ(one.rows[j].column, three.rows[j].column);
            EXPECT_EQ(one.rows[j].value, three.rows[j].value);
        }
    }
}

TEST(MirrorSituations, HaveTheExactLightOfTheirImages) {
    // All of the emitter is in sight: the form factor of its image.
    const MirrorSituation single = single_mirror(2.0, 1.0);
    const SurfacePoint x{Vec3(2.4, 0.7, 1.0), Vec3::UnitZ(), none, 0.0, 0.0};
    const Vec3 a(0, 0, 4), b(0, 1, 4), c(1, 1, 4), d(1, 0, 4);
    const double image =
        lambert_form_factor(x.position, x.normal, a, b, c) + lambert_form_factor(x.position, x.normal, a, c, d);
    EXPECT_NEAR(single.exact(x), image, 1e-14);
    // Behind the periscope it is as if the light came straight on, from 2 + 2 farther up, as far as the mirrors show
    // it.
    const MirrorSituation periscope = double_mirror(4.0);
    const SurfacePoint y{Vec3(6.0, 0.5, 2.5), -Vec3::UnitX(), none, 0.0, 0.0};
    const Vec3 e(-5, 0, 2), f(-5, 1, 2), g(-5, 1, 3), h(-5, 0, 3); // the image: 1 - 4 - 2 = -5
    const double whole =
        lambert_form_factor(y.position, y.normal, e, f, g) + lambert_form_factor(y.position, y.normal, e, g, h);
    EXPECT_NEAR(periscope.exact(y), whole, 1e-14);
}

} // namespace
} // namespace difusa::mirror_patches_test
