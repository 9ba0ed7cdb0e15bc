// White furnace: in a closed scene of constant E and rho the radiosity is B = E/(1-rho) everywhere, whatever the shape.
// Every basis, transport, solver and visibility engine that is found takes part.
//
// How far a discretisation may be off follows from what it does to a constant. Let (K1)_j be the row sums of the
// operator K = D P Π, l_j those of the transport D, and h* = E/(1-rho) the exact irradiance (= B). With
// h = l E + K (rho h) + r, r the solver's residual, the error e = h - h* obeys
//     e_j = (l_j - 1) E + rho h* ((K1)_j - 1) + rho (K e)_j + r_j,
// so that, if rho ‖K‖∞ < 1,
//     |e| <= (max|l - 1| E + rho h* max|K1 - 1| + ‖r‖∞) / (1 - rho ‖K‖∞).
// A gather over a partition of unity has l = K1 = 1 up to the rounding of sums of weights: what is left is the
// residual.
#include <difusa/algebra/dense.h>
#include <difusa/algebra/spectral_radius.h>
#include <difusa/discretisation/evaluate.h>

#include <support/dense_operator.h>
#include <support/discretised.h>
#include <support/rooms.h>
#include <support/surface_sampling.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace difusa::furnace_test {
namespace {

constexpr double E = 3.0;
constexpr std::size_t rays = 64;

struct Room {
    std::string name;
    Mesh mesh;
    double spacing;
};

std::vector<Room> rooms() {
    std::vector<Room> all;
    all.push_back({"box", test::box(1.0, 1, true), 0.22});
    all.push_back({"sphere", test::icosphere(2, 1.0, true), 0.35});
    all.push_back({"L-shaped room", test::l_room(), 0.33});
    all.push_back({"room with a block", test::room_with_block(), 0.22});
    return all;
}

/// A closed scene with everything that its transport needs.
struct Furnace : test::Discretised {
    Furnace(const Mesh& mesh, double spacing, const std::string& caster, const std::string& basis)
        : Discretised(test::uniform_scene(mesh, 0.5, E), spacing, caster, basis) {}
};

/// Solves with every solver and compares with E/(1-rho), at the sites and (through the basis) at random points.
void expect_furnace(const Furnace& furnace, const LightTransport& transport, double rho, double limit_at_points) {
    const Discretisation& discretisation = furnace.discretisation;
    const Values black = furnace.on_surfels(1.0), grey = furnace.on_surfels(rho);
    const ReflectedTransport T(discretisation, transport, grey);
    const Values light = test::Discretised::gather(transport, furnace.on_surfels(E));
    const Eigen::MatrixXd matrix = test::dense(ReflectedTransport(discretisation, transport, black));
    const double norm = matrix.cwiseAbs().rowwise().sum().maxCoeff();
    const double closure = (matrix.rowwise().sum().array() - 1.0).abs().maxCoeff();
    const double light_closure = (light.array() / E - 1.0).abs().maxCoeff();
    ASSERT_LT(rho * norm, 1.0) << "choose a smaller reflectance";
    const double exact = E / (1.0 - rho);
    for (const std::string& name : test::plugin_names<Solver>()) {
        SCOPED_TRACE(name);
        const auto solver = test::plugin<Solver>(name);
        if (solver->needs_factors() && !T.factors({})) {
            continue; // refused: the coefficients are solved for
        }
        const SolveProblem problem{&T, light};
        SolveOptions options;
        options.tolerance = 1e-13;
        const SolveSummary summary = solver->solve(problem, options, Execution{});
        ASSERT_TRUE(summary.converged()) << summary.sentence();
        const double bound =
            (light_closure * E + rho * exact * closure + summary.residual * light.maxCoeff()) / (1.0 - rho * norm);
        const double error = (summary.h.array() - exact).abs().maxCoeff();
        EXPECT_LE(error, bound + 1e-12 * exact);
        if (discretisation.basis->partition_of_unity() && limit_at_points > 0.0) {
            EXPECT_LE(error, limit_at_points * exact);
            const Values f =
                evaluate(*discretisation.basis, discretisation.projection->coefficients(summary.h),
                         test::random_points(furnace.scene.mesh, 500, RandomStream(5, "probes")), Execution{});
            EXPECT_LE((f.array() - exact).abs().maxCoeff(), limit_at_points * exact);
        }
    }
}

TEST(Furnace, GatherIsExactForPartitionsOfUnityAndWithinItsBoundElse) {
    for (const Room& room : rooms()) {
        for (const std::string& engine : test::plugin_names<Visibility>()) {
            for (const std::string& basis : test::plugin_names<Basis>()) {
                SCOPED_TRACE(room.name + ", " + engine + ", " + basis);
                const Furnace furnace(room.mesh, room.spacing, engine, basis);
                const LightTransport transport = furnace.gathered(rays);
                for (std::size_t j = 0; j < furnace.sites().size(); ++j) {
                    ASSERT_EQ(transport.sky[j], 0.0) << "light escapes from a closed room";
                    ASSERT_EQ(transport.back[j], 0.0) << "a back is seen in a closed room";
                }
                // The swings of solved coefficients count in the norm: a basis without unity gets less reflectance.
                const bool unity = furnace.discretisation.basis->partition_of_unity();
                for (const double rho : unity ? std::vector<double>{0.5, 0.95} : std::vector<double>{0.05}) {
                    expect_furnace(furnace, transport, rho, 1e-10);
                }
            }
        }
    }
}

TEST(Furnace, GatherIsExactWhereverTheRoomStands) {
    RandomStream random(8, "motions");
    for (const double scale : {1e-6, 1.0, 1e6}) {
        for (const double far : {0.0, 1e3}) {
            const Eigen::Matrix3d R = test::random_rotation(random);
            const Mesh mesh = test::transformed(test::l_room(), R, scale, far * scale * Vec3(1, 2, -3));
            for (const std::string& engine : test::plugin_names<Visibility>()) {
                SCOPED_TRACE(engine + " scale " + std::to_string(scale) + " far " + std::to_string(far));
                const Furnace furnace(mesh, 0.33 * scale, engine, "shepard");
                expect_furnace(furnace, furnace.gathered(rays), 0.8, 1e-10);
            }
        }
    }
}

TEST(Furnace, AnyDirectionsDo) {
    for (const std::string& directions : test::plugin_names<Directions>()) {
        SCOPED_TRACE(directions);
        const Furnace furnace(test::room_with_block(), 0.22, "cgal", "normalized-radial");
        expect_furnace(furnace, furnace.gathered(rays, directions), 0.9, 1e-10);
    }
}

TEST(Furnace, PairwiseStaysWithinTheBoundOfItsRowSums) {
    for (const Room& room : rooms()) {
        for (const std::string& engine : test::plugin_names<Visibility>()) {
            for (const std::string& basis : test::plugin_names<Basis>()) {
                const Furnace furnace(room.mesh, room.spacing, engine, basis);
                const Values black = furnace.on_surfels(1.0);
                for (const std::string& kernel : test::plugin_names<Kernel>()) {
                    SCOPED_TRACE(room.name + ", " + engine + ", " + basis + ", " + kernel);
                    const LightTransport transport = furnace.paired(kernel);
                    const double norm = test::dense(ReflectedTransport(furnace.discretisation, transport, black))
                                            .cwiseAbs()
                                            .rowwise()
                                            .sum()
                                            .maxCoeff();
                    // Half of what the norm allows, so that the bound exists whatever the kernel does close by.
                    expect_furnace(furnace, transport, std::min(0.5, 0.5 / norm), 0.0);
                }
            }
        }
    }
}

TEST(Furnace, TheDiscKernelApproachesItAsSitesGetDenser) {
    // In the mean over the walls the rows of the disc kernel sum to 1 but for what the nearest sites around the edges
    // get wrong: a strip some spacings wide, so that the error falls with the spacing.
    double before = 1.0;
    for (const double spacing : {0.3, 0.15, 0.075}) {
        const Furnace furnace(test::box(1.0, 1, true), spacing, "cgal", "normalized-radial");
        const Values sums = furnace.row_sums(furnace.paired("disc"));
        double miss = 0.0;
        for (std::size_t j = 0; j < furnace.sites().size(); ++j) {
            miss += furnace.sites().area[j] * std::abs(sums(static_cast<Eigen::Index>(j), 0) - 1.0) /
                    furnace.scene.mesh.area;
        }
        EXPECT_LT(miss, 0.75 * before) << spacing;
        before = miss;
    }
    EXPECT_LT(before, 0.15);
}

TEST(Furnace, NothingThatReflectsEverythingHasAnAnswer) {
    const Furnace furnace(test::l_room(), 0.33, "cgal", "shepard");
    const LightTransport transport = furnace.gathered(rays);
    const Values black = furnace.on_surfels(1.0), grey = furnace.on_surfels(0.7);
    const ReflectedTransport K(furnace.discretisation, transport, black);
    EXPECT_NEAR(spectral_radius(K, 40, 0.0, Execution{}), 1.0, 1e-13);
    EXPECT_NEAR(largest_eigenvalue(test::dense(K)), 1.0, 1e-12);
    EXPECT_NEAR(spectral_radius(ReflectedTransport(furnace.discretisation, transport, grey), 40, 0.0, Execution{}), 0.7,
                1e-13);
}

} // namespace
} // namespace difusa::furnace_test
