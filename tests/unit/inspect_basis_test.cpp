#include <difusa/bake.h>
#include <difusa/core/error.h>
#include <difusa/discretisation/basis.h>
#include <difusa/discretisation/sampler.h>
#include <difusa/output/bake_files.h>
#include <difusa/output/basis_files.h>
#include <difusa/study/inspect_basis.h>

#include <scratch_directory.h>
#include <support/plugins.h>
#include <support/rooms.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numeric>
#include <set>
#include <string>
#include <variant>
#include <vector>

namespace difusa::inspect_basis_test {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

/// The mesh as an OFF file.
std::filesystem::path write(const test::ScratchDirectory& directory, const Mesh& mesh) {
    std::ofstream file(directory / "mesh.off");
    file.precision(17);
    file << "OFF\n" << mesh.points.size() << ' ' << mesh.triangles.size() << " 0\n";
    for (const Vec3& p : mesh.points) {
        file << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
    }
    for (const auto& t : mesh.triangles) {
        file << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
    }
    return directory / "mesh.off";
}

InspectOptions coarse(const std::string& basis) {
    InspectOptions options;
    options.basis = basis;
    options.spacing = 0.2;
    options.output_spacing = 0.1;
    return options;
}

TEST(InspectBasis, ShowsWhatTheBasisSaysAtEveryVertex) {
    const test::ScratchDirectory directory;
    const auto file = write(directory, test::room_with_block());
    for (const std::string& name : test::plugin_names<Basis>()) {
        SCOPED_TRACE(name);
        InspectOptions options = coarse(name);
        options.elements = {11, 3, 11};
        const BasisInspection shown = inspect_basis(test::registry(), file, options, Execution{2, nullptr});
        ASSERT_EQ(shown.elements, (std::vector<Index>{11, 3}));
        const auto basis = test::plugin<Basis>(name);
        basis->bind(shown.mesh, shown.sites);
        std::vector<double> reach(shown.sites.size(), 0.0);
        BasisRow row;
        for (std::size_t v = 0; v < shown.output.vertices.size(); ++v) {
            const SurfacePoint& x = shown.output.vertices[v];
            basis->evaluate(x, row);
            double sum = 0.0, absolute = 0.0, own[2] = {0.0, 0.0};
            Index overlap = 0;
            for (std::size_t k = 0; k < row.element.size(); ++k) {
                const Index i = row.element[k];
                sum += row.weight[k];
                absolute += std::abs(row.weight[k]);
                overlap += row.weight[k] != 0.0 ? 1 : 0;
                own[i == 11 ? 0 : 1] += i == 11 || i == 3 ? row.weight[k] : 0.0;
                if (row.weight[k] != 0.0) {
                    reach[i] = std::max(reach[i], (x.position - shown.sites.points[i].position).norm());
                }
            }
            ASSERT_EQ(shown.sum[v], sum);
            ASSERT_EQ(shown.lebesgue[v], absolute);
            ASSERT_EQ(shown.overlap[v], overlap);
            ASSERT_EQ(shown.phi(static_cast<Eigen::Index>(v), 0), own[0]);
            ASSERT_EQ(shown.phi(static_cast<Eigen::Index>(v), 1), own[1]);
        }
        for (std::size_t i = 0; i < reach.size(); ++i) {
            EXPECT_NEAR(shown.reach[i], reach[i], 4 * eps * reach[i]);
        }
        if (basis->sums_to_one()) {
            EXPECT_NEAR(std::accumulate(shown.sites.area.begin(), shown.sites.area.end(), 0.0), shown.mesh.area,
                        1e-12 * shown.mesh.area);
        }
        EXPECT_GE(shown.mean_overlap, *std::min_element(shown.overlap.begin(), shown.overlap.end()));
        EXPECT_LE(shown.mean_overlap, *std::max_element(shown.overlap.begin(), shown.overlap.end()));
        EXPECT_GE(shown.mean_lebesgue, *std::min_element(shown.lebesgue.begin(), shown.lebesgue.end()) * (1 - 1e-12));
    }
}

TEST(InspectBasis, TheNearestSiteIsTheNearestOfAll) {
    const test::ScratchDirectory directory;
    for (const Mesh& mesh : {test::room_with_block(), test::shelf_over_table(1e-3), test::icosphere(1)}) {
        const BasisInspection shown =
            inspect_basis(test::registry(), write(directory, mesh), coarse("normalized-radial"), Execution{1, nullptr});
        for (std::size_t v = 0; v < shown.output.vertices.size(); ++v) {
            const SurfacePoint& x = shown.output.vertices[v];
            const auto distance = [&](std::size_t i) {
                return site_distance(x.position, x.normal, shown.mesh.region[x.face], shown.sites.points[i].position,
                                     shown.sites.points[i].normal, shown.sites.region[i]);
            };
            double least = std::numeric_limits<double>::infinity();
            for (std::size_t i = 0; i < shown.sites.size(); ++i) {
                least = std::min(least, distance(i));
            }
            ASSERT_EQ(distance(shown.nearest[v]), least);
        }
    }
}

TEST(InspectBasis, IsTheBasisOfTheBake) {
    const test::ScratchDirectory directory;
    const auto file = write(directory, test::grid(2, 2));
    for (const std::string& sampler : test::plugin_names<Sampler>()) {
        InspectOptions options;
        options.sampler = sampler;
        options.sites = 80;
        options.seed = 9;
        options.neighbours = 7;
        BakeOptions bake_options;
        bake_options.sampler = sampler;
        bake_options.sites = 80;
        bake_options.seed = 9;
        bake_options.neighbours = 7;
        bake_options.rays = 8;
        const BasisInspection shown = inspect_basis(test::registry(), file, options, Execution{1, nullptr});
        const BakeResult baked = bake(test::registry(), file, bake_options, Execution{1, nullptr});
        const FieldFile ours = sites_of(shown), its = sites_of(baked);
        EXPECT_EQ(ours.points, its.points);
        for (const char* name : {"radius", "area"}) {
            const auto values = [name](const FieldFile& field) {
                const auto array = std::find_if(field.point_arrays.begin(), field.point_arrays.end(),
                                                [name](const FieldArray& a) { return a.name == name; });
                return std::get<Values>(array->data);
            };
            EXPECT_EQ(values(ours), values(its)) << name;
        }
    }
}

TEST(InspectBasis, ChoosesElementsByPlace) {
    const test::ScratchDirectory directory;
    const auto file = write(directory, test::grid(2, 2));
    InspectOptions options = coarse("shepard");
    options.near = {Vec3(0.9, 0.1, 5.0), Vec3(0.1, 0.8, -1.0)};
    const BasisInspection shown = inspect_basis(test::registry(), file, options, Execution{1, nullptr});
    options.near.clear();
    const BasisInspection middle = inspect_basis(test::registry(), file, options, Execution{1, nullptr});
    const auto expect_nearest = [](const BasisInspection& inspection, const Vec3& p, std::size_t k) {
        for (const SurfacePoint& site : inspection.sites.points) {
            EXPECT_LE((inspection.sites.points[inspection.elements[k]].position - p).norm(),
                      (site.position - p).norm());
        }
    };
    ASSERT_EQ(shown.elements.size(), 2U);
    expect_nearest(shown, Vec3(0.9, 0.1, 5.0), 0);
    expect_nearest(shown, Vec3(0.1, 0.8, -1.0), 1);
    ASSERT_EQ(middle.elements.size(), 1U);
    expect_nearest(middle, Vec3(0.5, 0.5, 0.0), 0);

    options.elements = {static_cast<Index>(middle.sites.size())};
    try {
        inspect_basis(test::registry(), file, options, Execution{1, nullptr});
        ADD_FAILURE() << "an element that does not exist";
    } catch (const UsageError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("from 0 to " + std::to_string(middle.sites.size() - 1)));
    }
}

TEST(InspectBasis, FilesHoldOneRowForEachVertexAndSite) {
    const test::ScratchDirectory directory;
    InspectOptions options = coarse("moving-least-squares");
    options.elements = {2, 5};
    const BasisInspection shown =
        inspect_basis(test::registry(), write(directory, test::grid(2, 2)), options, Execution{1, nullptr});
    const auto rows = [](const FieldArray& array) {
        return std::holds_alternative<Values>(array.data)
                   ? static_cast<std::size_t>(std::get<Values>(array.data).rows())
                   : std::get<std::vector<std::int32_t>>(array.data).size();
    };
    const auto names = [](const FieldFile& field) {
        std::vector<std::string> all;
        for (const FieldArray& array : field.point_arrays) {
            all.push_back(array.name);
        }
        return all;
    };
    const FieldFile field = field_of(shown), sites = sites_of(shown);
    EXPECT_THAT(names(field),
                testing::ElementsAre("element", "element_5", "sum", "lebesgue", "overlap", "nearest_site"));
    EXPECT_THAT(names(sites), testing::ElementsAre("element", "shown", "radius", "reach", "area", "at_own_site",
                                                   "original_face_id", "region"));
    for (const FieldArray& array : field.point_arrays) {
        EXPECT_EQ(rows(array), shown.output.vertices.size()) << array.name;
    }
    for (const FieldArray& array : sites.point_arrays) {
        EXPECT_EQ(rows(array), shown.sites.size()) << array.name;
    }
    // The element is resolved: the vertex nearest to its site is within the output's spacing of it.
    const auto& phi = std::get<Values>(field.point_arrays[0].data);
    EXPECT_GT(phi.maxCoeff(), 0.5 * shown.at_own_site[2]);
    write_inspection(shown, directory / "basis.vtp", directory / "sites.ply", Execution{1, nullptr});
    EXPECT_EQ(directory.names(), (std::set<std::string>{"basis.vtp", "mesh.off", "sites.ply"}));
}

} // namespace
} // namespace difusa::inspect_basis_test
