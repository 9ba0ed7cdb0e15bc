#include <difusa/discretisation/basis.h>
#include <difusa/discretisation/evaluate.h>

#include <support/rooms.h>
#include <support/sited.h>
#include <support/surface_sampling.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace difusa::bases_test {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

struct Case {
    std::string name;
    Mesh mesh;
    double spacing;
    /// Whether two points of one region see each other; empty: all do.
    std::function<bool(const Vec3&, const Vec3&)> see{};
    bool in_sight(const Vec3& p, const Vec3& q) const { return !see || see(p, q); }
};

std::vector<Case> cases() {
    std::vector<Case> all;
    all.push_back({"cube", test::box(1.0), 0.12});
    all.push_back({"sphere", test::icosphere(2, 1.0, true), 0.25});
    all.push_back({"sphere of few facets", test::icosphere(0), 0.2});
    all.push_back({"room", test::l_room(), 0.25, test::see_in_l_room});
    all.push_back({"thin wall", test::thin_wall(1e-9), 0.12});
    all.push_back({"needles", test::needles(60), 0.1});
    all.push_back({"shelf over table", test::shelf_over_table(1e-6), 0.1, test::see_on_table});
    all.push_back({"tiny", test::moved(test::room_with_block(), 1e-6, Vec3::Zero()), 2e-7});
    all.push_back({"large and far away", test::moved(test::room_with_block(), 1e6, Vec3(1e8, 1e8, -1e8)), 2e5});
    return all;
}

/// Every basis found, and choices that are harder than the defaults.
std::vector<std::string> bases() {
    std::vector<std::string> all = test::plugin_names<Basis>();
    all.insert(all.end(), {"shepard:k=0.5", "shepard:k=3", "shepard:support=sharp", "shepard:k=1.5,support=sharp",
                           "normalized-radial:width=2", "normalized-radial:width=0.3", "shepard:width=0.3",
                           "shepard:width=2.5", "radial:profile=cubic", "radial:width=0.3"});
    return all;
}

/// Calls `act` for each basis bound to the sites of each mesh.
void for_each(const std::function<void(const Mesh&, const SiteSet&, const Basis&, const std::string&)>& act) {
    for (const Case& c : cases()) {
        const SiteSet sites = test::poisson_sites(c.mesh, c.spacing);
        for (const std::string& choice : bases()) {
            SCOPED_TRACE(c.name + ", " + choice);
            const auto basis = test::plugin<Basis>(choice);
            basis->bind(c.mesh, sites);
            ASSERT_EQ(basis->size(), sites.size());
            act(c.mesh, sites, *basis, choice);
        }
    }
}

std::vector<SurfacePoint> probes(const Mesh& mesh) {
    std::vector<SurfacePoint> points = test::random_points(mesh, 1000, RandomStream(3, "probes"));
    const auto special = test::special_points(mesh);
    points.insert(points.end(), special.begin(), special.begin() + std::min<std::ptrdiff_t>(500, std::ssize(special)));
    return points;
}

TEST(Bases, WeightsHaveTheSumTheyPromiseAndElementsStayOnTheirRegion) {
    for_each([](const Mesh& mesh, const SiteSet& sites, const Basis& basis, const std::string& /*choice*/) {
        BasisRow row;
        std::size_t negative = 0, foreign = 0, turned = 0, unequal = 0, bad_number = 0;
        double worst_sum = 0.0;
        for (const SurfacePoint& x : probes(mesh)) {
            basis.evaluate(x, row);
            unequal += row.element.size() != row.weight.size() ? 1 : 0;
            double sum = 0.0;
            for (std::size_t i = 0; i < row.element.size(); ++i) {
                if (row.element[i] >= sites.size()) {
                    ++bad_number;
                    continue;
                }
                negative += row.weight[i] >= 0.0 ? 0 : 1;
                foreign += sites.region[row.element[i]] != mesh.region[x.face] ? 1 : 0;
                turned += sites.points[row.element[i]].normal.dot(x.normal) <= perpendicular ? 1 : 0;
                sum += row.weight[i];
            }
            worst_sum = std::max(worst_sum, std::abs(sum - 1.0));
        }
        EXPECT_EQ(bad_number, 0U);
        EXPECT_EQ(unequal, 0U);
        if (basis.partition_of_unity() || !basis.sums_to_one()) { // else it corrects itself with signs
            EXPECT_EQ(negative, 0U);
        }
        EXPECT_EQ(foreign, 0U) << "light leaks from region to region";
        EXPECT_EQ(turned, 0U);
        if (basis.sums_to_one()) {
            // Each weight is rounded when it is divided by the sum, and the sum when it is added up; where weights have
            // both signs their absolute values sum to at most 5.
            EXPECT_LE(worst_sum, (basis.partition_of_unity() ? 200 : 1000) * eps);
        }
    });
}

TEST(Bases, APartitionOfUnityIsBoundedByItsData) {
    for_each([](const Mesh& mesh, const SiteSet& sites, const Basis& basis, const std::string& /*choice*/) {
        if (!basis.partition_of_unity()) {
            return;
        }
        RandomStream random(6, "data");
        Values b(static_cast<Eigen::Index>(sites.size()), 2);
        for (Eigen::Index i = 0; i < b.rows(); ++i) {
            b(i, 0) = random.uniform() - 0.5;
            b(i, 1) = 7.0;
        }
        const Values f = evaluate(basis, b, probes(mesh), Execution{2, nullptr});
        EXPECT_LE(f.col(0).maxCoeff(), b.col(0).maxCoeff() * (1.0 + 200 * eps));
        EXPECT_GE(f.col(0).minCoeff(), b.col(0).minCoeff() * (1.0 + 200 * eps));
        EXPECT_LE((f.col(1).array() - 7.0).abs().maxCoeff(), 7.0 * 200 * eps) << "constants are not reproduced";
    });
}

TEST(Bases, ShepardInterpolates) {
    for_each([](const Mesh& /*mesh*/, const SiteSet& sites, const Basis& basis, const std::string& choice) {
        if (!choice.starts_with("shepard")) {
            return;
        }
        EXPECT_TRUE(basis.coefficients_are_values());
        BasisRow row;
        for (Index j = 0; j < sites.size(); ++j) {
            basis.evaluate(sites.points[j], row);
            double others = 0.0, own = 0.0;
            for (std::size_t i = 0; i < row.element.size(); ++i) {
                (row.element[i] == j ? own : others) += row.weight[i];
            }
            ASSERT_EQ(own, 1.0);
            ASSERT_EQ(others, 0.0);
        }
    });
}

/// phi at x by the printed formulas, all sites in sight asked. `mother(site, euclidean, cosine)` is 0 outside of its
/// support.
std::map<Index, double> naive(const Case& c, const SiteSet& sites, const SurfacePoint& x, bool normalise,
                              const std::function<double(Index, double, double)>& mother) {
    std::map<Index, double> weight;
    double sum = 0.0;
    for (Index i = 0; i < sites.size(); ++i) {
        const double cosine = x.normal.dot(sites.points[i].normal);
        if (sites.region[i] != c.mesh.region[x.face] || cosine <= perpendicular ||
            !c.in_sight(x.position, sites.points[i].position)) {
            continue;
        }
        const double w = mother(i, (x.position - sites.points[i].position).norm(), cosine);
        if (w > 0.0) {
            weight[i] = w;
            sum += w;
        }
    }
    for (auto& [site, w] : weight) {
        w /= normalise ? sum : 1.0;
    }
    return weight;
}

/// `capped`: radii count up to their median.
void expect_twin(const std::string& choice, const std::function<double(double r, double d, double cosine)>& mother,
                 bool normalise, bool capped = false) {
    for (const Case& c : cases()) {
        SCOPED_TRACE(c.name + ", " + choice);
        const SiteSet sites = test::poisson_sites(c.mesh, c.spacing);
        const auto basis = test::plugin<Basis>(choice);
        basis->bind(c.mesh, sites);
        const double most = capped ? test::median_radius(sites) : std::numeric_limits<double>::infinity();
        BasisRow row;
        double worst = 0.0;
        for (const SurfacePoint& x : test::random_points(c.mesh, 500, RandomStream(8, "probes"))) {
            const std::map<Index, double> twin = naive(c, sites, x, normalise, [&](Index i, double d, double cosine) {
                return mother(std::min(sites.radius[i], most), d, cosine);
            });
            if (twin.empty()) {
                continue; // no support holds x: a rule of its own, see below
            }
            basis->evaluate(x, row);
            std::map<Index, double> difference = twin;
            for (std::size_t i = 0; i < row.element.size(); ++i) {
                difference[row.element[i]] -= row.weight[i];
            }
            for (const auto& [site, d] : difference) {
                worst = std::max(worst, std::abs(d));
            }
        }
        // Both sides subtract the same coordinates; what they round differently afterwards are a dozen operations and
        // the sums of at most some hundred weights.
        EXPECT_LE(worst, 1e-12);
    }
}

TEST(Bases, EqualTheirFormulasOverAllSites) {
    const auto cubic = [](double t) { return t < 1.0 ? 2 * t * t * t - 3 * t * t + 1 : 0.0; };
    for (const double width : {1.0, 2.0}) {
        expect_twin(
            "normalized-radial:width=" + std::to_string(width),
            [&](double r, double d, double cosine) { return cubic(d / (width * r)) * cosine; }, true);
    }
    for (const double k : {0.5, 1.0, 2.0, 3.0}) {
        const std::string exponent = "shepard:k=" + std::to_string(k);
        // In units of the radius: weights are ratios, and powers stay in range at any scale.
        expect_twin(
            exponent + ",support=sharp",
            [&](double r, double d, double cosine) {
                const double distance = d / cosine;
                return distance < r ? std::pow(distance / 1e3, -k) : 0.0;
            },
            true);
        expect_twin(
            exponent,
            [&](double r, double d, double cosine) {
                const double distance = d / cosine;
                return distance < r ? std::pow(1e3 / distance - 1e3 / r, k) : 0.0;
            },
            true);
    }
    for (const double width : {0.42466, 0.3}) {
        expect_twin(
            "radial:width=" + std::to_string(width),
            [&](double r, double d, double cosine) {
                const double s = d / cosine / (width * r);
                return s < 4.0 ? std::exp(-0.5 * s * s) : 0.0;
            },
            false, true);
        expect_twin(
            "radial:profile=cubic,width=" + std::to_string(width),
            [&](double r, double d, double cosine) {
                return cubic(d / cosine / (2.0 * std::sqrt(2.0 * std::log(2.0)) * width * r));
            },
            false, true);
    }
}

TEST(Bases, WhereNoSupportReachesTheNearestSiteOfTheRegionServes) {
    for (const char* choice : {"normalized-radial:width=0.05", "shepard:width=0.05"}) {
        for (const Case& c : cases()) {
            SCOPED_TRACE(c.name + ", " + choice);
            const SiteSet sites = test::poisson_sites(c.mesh, c.spacing);
            const auto basis = test::plugin<Basis>(choice);
            basis->bind(c.mesh, sites);
            BasisRow row;
            std::size_t wrong = 0, alone = 0;
            for (const SurfacePoint& x : test::random_points(c.mesh, 500, RandomStream(8, "probes"))) {
                basis->evaluate(x, row);
                double least = std::numeric_limits<double>::infinity();
                bool covered = false;
                for (Index i = 0; i < sites.size(); ++i) {
                    const double d = site_distance(x.position, x.normal, c.mesh.region[x.face],
                                                   sites.points[i].position, sites.points[i].normal, sites.region[i]);
                    least = c.in_sight(x.position, sites.points[i].position) ? std::min(least, d) : least;
                    covered = covered || d < 0.06 * sites.radius[i];
                }
                if (covered) {
                    continue;
                }
                ++alone;
                const SurfacePoint& site = sites.points[row.element[0]];
                wrong += row.element.size() != 1 || row.weight[0] != 1.0 ||
                                 site_distance(x.position, x.normal, c.mesh.region[x.face], site.position, site.normal,
                                               sites.region[row.element[0]]) > least * (1 + 4 * eps)
                             ? 1
                             : 0;
            }
            EXPECT_EQ(wrong, 0U);
            EXPECT_GT(alone, 50U);
        }
    }
}

TEST(Bases, ManyThinLayersDoNotShareLight) {
    // Forty sheets a millionth apart: the sites next to a point in space are those of the other sheets.
    Mesh mesh = test::grid(1, 1);
    for (int layer = 1; layer < 40; ++layer) {
        mesh = test::together(mesh, test::moved(test::grid(1, 1), 1.0, Vec3(0, 0, layer * 1e-6)));
    }
    const SiteSet sites = test::poisson_sites(mesh, 0.3);
    for (const std::string& choice : bases()) {
        SCOPED_TRACE(choice);
        const auto basis = test::plugin<Basis>(choice);
        basis->bind(mesh, sites);
        BasisRow row;
        std::size_t foreign = 0;
        for (const SurfacePoint& x : test::random_points(mesh, 500, RandomStream(8, "probes"))) {
            basis->evaluate(x, row);
            for (const Index i : row.element) {
                foreign += sites.region[i] != mesh.region[x.face] ? 1 : 0;
            }
        }
        EXPECT_EQ(foreign, 0U);
    }
}

TEST(Bases, ElementsFadeOutWithoutAStep) {
    // Along a line across the plane every default element is continuous: over a step h it changes by at most L h, where
    // the steepest, a weight that goes through 1/d² at the spacing, stays below 20/spacing.
    const Mesh mesh = test::grid(1, 1);
    const SiteSet sites = test::poisson_sites(mesh, 0.1);
    for (const std::string& choice : test::plugin_names<Basis>()) {
        if (choice == "radial") {
            continue; // ends at exp(-8), by definition
        }
        const auto basis = test::plugin<Basis>(choice);
        basis->bind(mesh, sites);
        constexpr int steps = 20'000;
        std::vector<double> before(sites.size(), 0.0), now(sites.size(), 0.0);
        double largest = 0.0;
        BasisRow row;
        for (int i = 0; i <= steps; ++i) {
            const double u = 0.5 * i / steps;
            basis->evaluate(mesh.at(0, u, 0.3), row);
            std::fill(now.begin(), now.end(), 0.0);
            for (std::size_t k = 0; k < row.element.size(); ++k) {
                now[row.element[k]] = row.weight[k];
            }
            for (std::size_t k = 0; i > 0 && k < now.size(); ++k) {
                largest = std::max(largest, std::abs(now[k] - before[k]));
            }
            before.swap(now);
        }
        EXPECT_LE(largest, 20.0 / 0.1 * 0.5 / steps) << choice;
        EXPECT_GT(largest, 0.0) << choice;
    }
}

TEST(Bases, ScalingByAPowerOfTwoKeepsEveryBit) {
    const Mesh one = test::icosphere(2), other = test::moved(one, 0x1p-20, Vec3::Zero());
    const SiteSet sites = test::poisson_sites(one, 0.25), small = test::poisson_sites(other, 0.25 * 0x1p-20);
    ASSERT_EQ(sites.size(), small.size());
    for (const std::string& choice : bases()) {
        const auto a = test::plugin<Basis>(choice), b = test::plugin<Basis>(choice);
        a->bind(one, sites);
        b->bind(other, small);
        BasisRow row, twin;
        for (const SurfacePoint& x : test::random_points(one, 200, RandomStream(2, "probes"))) {
            a->evaluate(x, row);
            b->evaluate(other.at(x.face, x.u, x.v), twin);
            EXPECT_EQ(row.element, twin.element) << choice;
            EXPECT_EQ(row.weight, twin.weight) << choice;
        }
    }
}

} // namespace
} // namespace difusa::bases_test
