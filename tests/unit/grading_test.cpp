// Graded sites: the spacing that values ask for, the sites placed for it, and the supports around them.
#include <difusa/core/error.h>
#include <difusa/discretisation/grading.h>
#include <difusa/discretisation/poisson_disk.h>
#include <difusa/mesh/surface_sampling.h>

#include <support/plugins.h>
#include <support/rooms.h>
#include <support/sited.h>

#include <meshes.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

namespace difusa::grading_test {
namespace {

constexpr std::size_t no_limit = 1'000'000;
constexpr double largest = 0.2;

/// The spacing 0.02 + 0.1 |x - corner| at points spread over the surface.
SizeField towards_corner(const Mesh& mesh, std::size_t points = 4000) {
    std::vector<SurfacePoint> at = even_points(mesh, points, RandomStream(3, "points"));
    std::vector<Index> region;
    std::vector<double> sizes;
    for (const SurfacePoint& x : at) {
        region.push_back(mesh.region[x.face]);
        sizes.push_back(std::min(largest, 0.02 + 0.1 * (x.position - mesh.low).norm()));
    }
    return {std::move(at), region, std::move(sizes), largest, mesh.region_count};
}

std::vector<SurfacePoint> even_sites(const Mesh& mesh) {
    return poisson_disk(mesh, largest, no_limit, RandomStream(1, "sites"), Execution{});
}

std::vector<SurfacePoint> graded_sites(const Mesh& mesh, const SizeField& size, unsigned threads = 1) {
    return refine_sites(mesh, even_sites(mesh), size, no_limit, RandomStream(1, "graded"), Execution{threads});
}

double between(const Mesh& mesh, const SurfacePoint& x, const SurfacePoint& y) {
    return site_distance(x.position, x.normal, mesh.region[x.face], y.position, y.normal, mesh.region[y.face]);
}

/// The values f(p) at the sites, a column for each component.
template <class Function> Values at_sites(const SiteSet& sites, Eigen::Index columns, const Function& f) {
    Values values(static_cast<Eigen::Index>(sites.size()), columns);
    for (std::size_t i = 0; i < sites.size(); ++i) {
        values.row(static_cast<Eigen::Index>(i)) = f(sites.points[i].position);
    }
    return values;
}

std::vector<Mesh> meshes() {
    return {test::grid(1, 1), test::box(1.0, 3), test::icosphere(3, 0.5), test::room_with_block()};
}

TEST(Grading, EveryPointHasASiteAsNearAsItShould) {
    for (const Mesh& mesh : meshes()) {
        const SizeField size = towards_corner(mesh);
        const std::vector<SurfacePoint> sites = graded_sites(mesh, size);
        for (const SurfacePoint& x : even_points(mesh, 2000, RandomStream(7, "asked"))) {
            double nearest = std::numeric_limits<double>::infinity();
            for (const SurfacePoint& site : sites) {
                nearest = std::min(nearest, between(mesh, x, site));
            }
            const double s = size.at(x.position, mesh.region[x.face]);
            double wanted = largest;
            for (int level = 1; s + SizeField::slope * SizeField::spacing_of(largest, level) / 6.0 <
                                SizeField::rounding * SizeField::spacing_of(largest, level);
                 ++level) {
                wanted = SizeField::spacing_of(largest, level);
            }
            EXPECT_LE(wanted, SizeField::cover * s);
            EXPECT_LE(nearest, wanted * (1.0 + 1e-5));
        }
    }
}

TEST(Grading, NoSiteIsCloserToAnotherThanTheFinestSpacingThere) {
    for (const Mesh& mesh : meshes()) {
        const SizeField size = towards_corner(mesh);
        const std::vector<SurfacePoint> sites = graded_sites(mesh, size);
        for (std::size_t i = 0; i < sites.size(); ++i) {
            for (std::size_t j = 0; j < i; ++j) {
                // Pieces with a point that is fine enough are filled: of two sites the later had such a point within
                // a third of a spacing, two thirds of the longest edge of a piece of half a spacing.
                const auto finest = [&](const SurfacePoint& x) {
                    return (size.at(x.position, mesh.region[x.face]) - SizeField::slope * largest) /
                           SizeField::rounding / SizeField::root_of_2;
                };
                EXPECT_GE(between(mesh, sites[i], sites[j]), std::min(finest(sites[i]), finest(sites[j])));
                EXPECT_GE(between(mesh, sites[i], sites[j]), size.smallest() / SizeField::rounding);
            }
        }
    }
}

TEST(Grading, KeepsTheSitesThatAreThereAndAddsNoneWhereTheyAreEnough) {
    const Mesh mesh = test::box(1.0, 3);
    const std::vector<SurfacePoint> even = even_sites(mesh);
    const std::vector<SurfacePoint> graded = graded_sites(mesh, towards_corner(mesh));
    ASSERT_GT(graded.size(), even.size());
    for (std::size_t i = 0; i < even.size(); ++i) {
        EXPECT_EQ(graded[i].position, even[i].position);
    }
    const SizeField nothing(even, std::vector<Index>(even.size(), 0), std::vector<double>(even.size(), largest),
                            largest, mesh.region_count);
    EXPECT_EQ(graded_sites(mesh, nothing).size(), even.size());
    EXPECT_THROW(refine_sites(mesh, even, towards_corner(mesh), even.size(), RandomStream(1, "graded"), Execution{}),
                 ResourceError);
}

TEST(Grading, HasTheSameSitesForAnyNumberOfThreads) {
    const Mesh mesh = test::room_with_block();
    const SizeField size = towards_corner(mesh);
    const std::vector<SurfacePoint> one = graded_sites(mesh, size), three = graded_sites(mesh, size, 3);
    ASSERT_EQ(one.size(), three.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
        EXPECT_EQ(one[i].position, three[i].position);
    }
}

TEST(Grading, EveryPointIsInASupport) {
    for (const Mesh& mesh : meshes()) {
        const SizeField size = towards_corner(mesh);
        const SiteSet sites = make_site_set(mesh, graded_sites(mesh, size), 0.1, 10, Execution{}, &size);
        for (const SurfacePoint& x : even_points(mesh, 2000, RandomStream(8, "asked"))) {
            double least = std::numeric_limits<double>::infinity();
            for (std::size_t i = 0; i < sites.size(); ++i) {
                least = std::min(least, between(mesh, x, sites.points[i]) / sites.radius[i]);
            }
            EXPECT_LT(least, 1.0);
        }
    }
}

/// The error that is left at each site is that of its element before, times the ratio of the spacings.
TEST(Grading, SharesTheSquaredErrorEvenlyAmongAsManyElementsAsAreWanted) {
    const Mesh mesh = test::grid(1, 1);
    const SiteSet sites = test::poisson_sites(mesh, 0.02);
    std::vector<double> error, own(sites.size(), sites.spacing);
    for (const SurfacePoint& x : sites.points) {
        error.push_back(std::exp(-3.0 * x.position[0])); // the spacing varies less than `slope` everywhere
    }
    const double coarsest = 4.0 * sites.spacing, wanted = 0.5 * static_cast<double>(sites.size());
    const SizeField size = graded_spacing(sites, own, error, coarsest, wanted, mesh.region_count, Execution{});
    double count = 0.0;
    std::vector<double> elements;
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const double s = size.at(sites.points[i].position, sites.region[i]);
        const double rounded = SizeField::rounded(coarsest, s);
        count += own[i] * own[i] / (rounded * rounded);
        EXPECT_LE(std::max(rounded / s, s / rounded), SizeField::rounding * (1.0 + 1e-12));
        if (s < 0.99 * coarsest) {
            elements.push_back(error[i] * s / own[i] * s); // error times spacing: the root of an element's square
        }
    }
    // Rounding to levels makes the number jump where the factor lets a strip of sites change theirs.
    EXPECT_NEAR(count / wanted, 1.0, 0.1);
    ASSERT_GT(elements.size(), sites.size() / 2);
    const auto [least, most] = std::minmax_element(elements.begin(), elements.end());
    EXPECT_NEAR(*least / *most, 1.0, 1e-9);
}

TEST(Grading, GainsWhatTheMeanSquareIsAboveTheSquareOfTheMean) {
    EXPECT_DOUBLE_EQ(gain_of_grading({0.3, 0.3, 0.3}), 1.0);
    EXPECT_DOUBLE_EQ(gain_of_grading({0.0, 0.0, 0.0, 2.0}), 4.0);
    EXPECT_DOUBLE_EQ(gain_of_grading({1e-200, 3e-200}), 0.5 * 10.0 / 4.0);
    EXPECT_EQ(gain_of_grading({0.0, 0.0}), 1.0);
    EXPECT_EQ(gain_of_grading({}), 1.0);
}

/// The naive twin, up to a rounding of each term; and after other sizes are assigned.
TEST(Grading, SpacingsAreTheLowerEnvelopeOfConesOnThePoints) {
    for (const Mesh& mesh : meshes()) {
        const SiteSet sites = test::poisson_sites(mesh, 0.1);
        RandomStream random(12, "sizes");
        std::vector<double> sizes(sites.size());
        for (double& size : sizes) {
            size = 0.01 + 0.09 * random.uniform();
        }
        SizeField field(sites.points, sites.region, sizes, 0.1, mesh.region_count);
        std::vector<SurfacePoint> asked = even_points(mesh, 200, RandomStream(5, "asked"));
        asked.insert(asked.end(), sites.points.begin(), sites.points.end());
        for (int round = 0; round < 2; ++round) {
            for (const SurfacePoint& x : asked) {
                const Index region = mesh.region[x.face];
                double least = 0.1;
                for (std::size_t i = 0; i < sites.size(); ++i) {
                    if (sites.region[i] == region) {
                        least = std::min(least,
                                         sizes[i] + SizeField::slope * (sites.points[i].position - x.position).norm());
                    }
                }
                EXPECT_NEAR(field.at(x.position, region), least, 1e-15);
                EXPECT_EQ(field.placed_at(x.position, region), SizeField::rounded(0.1, field.at(x.position, region)));
                const double found = field.at(x.position, region);
                for (const double limit : {0.005, 0.02, 0.05, found * (1.0 - 1e-12), found * (1.0 + 1e-12), 0.2}) {
                    const double bound = field.bound_below(limit, x.position, region);
                    EXPECT_EQ(bound < limit, found < limit);
                    EXPECT_GE(bound, std::min(found, limit));
                }
            }
            std::reverse(sizes.begin(), sizes.end());
            field.assign(sizes);
        }
    }
}

TEST(Grading, DoesNotRefineWhatHasNoError) {
    const Mesh mesh = test::grid(1, 1);
    const SiteSet sites = test::poisson_sites(mesh, 0.05);
    const std::vector<double> none(sites.size(), 0.0), own(sites.size(), sites.spacing);
    const SizeField size = graded_spacing(sites, own, none, sites.spacing, 1e6, mesh.region_count, Execution{});
    EXPECT_EQ(size.smallest(), sites.spacing);
}

TEST(Grading, DoesNotDependOnTheUnitOfErrors) {
    const Mesh mesh = test::grid(1, 1);
    const SiteSet sites = test::poisson_sites(mesh, 0.05);
    const std::vector<double> own(sites.size(), sites.spacing);
    const auto spacing = [&](const std::vector<double>& error) {
        return graded_spacing(sites, own, error, 2.0 * sites.spacing, 2.0 * static_cast<double>(sites.size()),
                              mesh.region_count, Execution{});
    };
    std::vector<double> error;
    for (std::size_t i = 0; i < sites.size(); ++i) {
        error.push_back(std::ldexp(1.0, -static_cast<int>(i % 7)));
    }
    const SizeField size = spacing(error);
    EXPECT_LT(size.smallest(), sites.spacing);
    for (const double unit : {0x1p-1064, 0x1p-4, 0x1p1000}) { // roots of roots are exact; the first is denormal
        std::vector<double> other = error;
        std::for_each(other.begin(), other.end(), [unit](double& each) { each *= unit; });
        const SizeField same = spacing(other);
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const Vec3& p = sites.points[i].position;
            ASSERT_EQ(same.at(p, sites.region[i]), size.at(p, sites.region[i])) << unit;
        }
    }
    // Beside large errors the least ones are none.
    std::vector<double> apart = error;
    apart[3] = 0x1p-1070;
    const SizeField finite = spacing(apart);
    EXPECT_GE(finite.smallest(), 0.25 * sites.spacing);
    EXPECT_LE(finite.at(sites.points[3].position, sites.region[3]), 2.0 * sites.spacing);
}

/// What the weights of the others, brought to a sum of 1, make of their values.
TEST(Grading, LeaveOneOutIsWhatTheOtherSitesSay) {
    const Mesh mesh = test::grid(2, 2);
    const SiteSet sites = test::poisson_sites(mesh, 0.1);
    const auto basis = test::plugin<Basis>("normalized-radial");
    basis->bind(mesh, sites);
    const Values f = at_sites(sites, 1, [](const Vec3& p) { return Values::Constant(1, 1, std::sin(9.0 * p[0])); });
    const Values residual = leave_one_out(*basis, sites, f, Execution{});
    for (std::size_t i = 0; i < sites.size(); ++i) {
        BasisRow row;
        basis->evaluate(sites.points[i], row);
        double sum = 0.0, weight = 0.0;
        for (std::size_t k = 0; k < row.element.size(); ++k) {
            if (row.element[k] != i) {
                sum += row.weight[k] * f(static_cast<Eigen::Index>(row.element[k]), 0);
                weight += row.weight[k];
            }
        }
        EXPECT_NEAR(residual(static_cast<Eigen::Index>(i), 0), f(static_cast<Eigen::Index>(i), 0) - sum / weight,
                    1e-12);
    }
}

TEST(Grading, LeaveOneOutVanishesForWhatTheBasisReproduces) {
    const Mesh mesh = test::grid(2, 2);
    const SiteSet sites = test::poisson_sites(mesh, 0.1);
    const auto basis = test::plugin<Basis>("moving-least-squares");
    basis->bind(mesh, sites);
    const Values f = at_sites(sites, 2, [](const Vec3& p) { return Eigen::RowVector2d(1.0, 2.0 - 3.0 * p[0] + p[1]); });
    const Values residual = leave_one_out(*basis, sites, f, Execution{});
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const Vec3& p = sites.points[i].position;
        const double to_border = std::min({p[0], p[1], 1.0 - p[0], 1.0 - p[1]});
        EXPECT_NEAR(residual(static_cast<Eigen::Index>(i), 0), 0.0, 1e-10);
        if (to_border > 2.0 * sites.spacing) { // nearer to it slopes may be bounded
            EXPECT_NEAR(residual(static_cast<Eigen::Index>(i), 1), 0.0, 1e-10);
        }
    }
}

} // namespace
} // namespace difusa::grading_test
