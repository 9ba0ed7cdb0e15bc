#include <difusa/mesh/output_mesh.h>
#include <difusa/scene/scene.h>
#include <difusa/scene/texture.h>

#include <meshes.h>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

namespace difusa::output_mesh_test {
namespace {

using test::book;
using test::box;
using test::grid;
using test::icosphere;
using test::make_mesh;
using test::mobius;
using test::moved;
using test::together;

constexpr double pi = std::numbers::pi;
constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t no_limit = 100'000'000;

Mesh with_creases_from(double angle, Mesh mesh) {
    mesh.crease_angle = angle;
    mesh.derive();
    return mesh;
}

using Bits = std::array<double, 3>; // compared without tolerance
Bits bits(const Vec3& x) {
    return {x.x(), x.y(), x.z()};
}

/// Positions come from halving again and again; each halving rounds by at most eps/2 a coordinate and passes on
/// the mean of the errors it starts from, and there are fewer than 64 of them.
double position_error(const Mesh& mesh) {
    return 64 * eps * mesh.magnitude();
}

/// Barycentric coordinates of a point of the plane of triangle `t`.
Vec3 barycentrics(const Mesh& mesh, Index t, const Vec3& x) {
    Vec3 w;
    for (int k = 0; k < 3; ++k) {
        const Vec3 a = mesh.corner(t, (k + 1) % 3), b = mesh.corner(t, (k + 2) % 3);
        w[k] = (a - x).cross(b - x).dot(mesh.normals[t]) / (2 * mesh.areas[t]);
    }
    return w;
}

/// The border edges of the output, by position: how often each runs from one point to the other.
std::map<std::pair<Bits, Bits>, int> border(const OutputMesh& output) {
    std::map<std::pair<Index, Index>, int> runs;
    for (const auto& t : output.triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            ++runs[{t[k], t[(k + 1) % 3]}];
        }
    }
    std::map<std::pair<Bits, Bits>, int> result;
    for (const auto& [edge, count] : runs) {
        EXPECT_EQ(count, 1) << "two triangles run through one edge in the same direction";
        if (!runs.contains({edge.second, edge.first})) {
            ++result[{bits(output.vertices[edge.first].position), bits(output.vertices[edge.second].position)}];
        }
    }
    return result;
}

double border_length(const OutputMesh& output) {
    double length = 0.0;
    for (const auto& [edge, count] : border(output)) {
        length += count * (Vec3(edge.first.data()) - Vec3(edge.second.data())).norm();
    }
    return length;
}

double longest_edge(const OutputMesh& output) {
    double longest = 0.0;
    for (const auto& t : output.triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            longest = std::max(
                longest, (output.vertices[t[k]].position - output.vertices[t[(k + 1) % 3]].position).squaredNorm());
        }
    }
    return std::sqrt(longest);
}

double area(const OutputMesh& output, std::size_t f) {
    const auto [a, b, c] = output.triangles[f];
    const Vec3 p = output.vertices[a].position;
    return 0.5 * (output.vertices[b].position - p).cross(output.vertices[c].position - p).norm();
}

/// What holds for any mesh: the small triangles tile the input triangle they name, facing as it does, and each
/// vertex is where its face and place say, with a unit normal on the front.
void expect_sound(const Mesh& mesh, const OutputMesh& output, double max_edge) {
    EXPECT_LE(longest_edge(output), max_edge * (1 + eps));
    ASSERT_EQ(output.face.size(), output.triangles.size());
    const double error = position_error(mesh);

    std::vector<double> tiled(mesh.triangles.size(), 0.0), perimeters(mesh.triangles.size(), 0.0);
    for (std::size_t f = 0; f < output.triangles.size(); ++f) {
        const Index t = output.face[f];
        ASSERT_LT(t, mesh.triangles.size());
        std::array<Vec3, 3> x;
        for (std::size_t k = 0; k < 3; ++k) {
            ASSERT_LT(output.triangles[f][k], output.vertices.size());
            x[k] = output.vertices[output.triangles[f][k]].position;
            // A corner that is off by `error` is off by error * edge / (2 area) in barycentrics.
            const double slack = 4 * error * mesh.diameter() / mesh.areas[t];
            const Vec3 w = barycentrics(mesh, t, x[k]);
            EXPECT_GE(w.minCoeff(), -slack);
            EXPECT_LE(w.maxCoeff(), 1 + slack);
        }
        const double signed_area = 0.5 * (x[1] - x[0]).cross(x[2] - x[0]).dot(mesh.normals[t]);
        const double perimeter = (x[1] - x[0]).norm() + (x[2] - x[1]).norm() + (x[0] - x[2]).norm();
        EXPECT_GT(signed_area, -error * perimeter);
        tiled[t] += signed_area;
        perimeters[t] += perimeter;
    }
    for (std::size_t t = 0; t < tiled.size(); ++t) {
        EXPECT_NEAR(tiled[t], mesh.areas[t], error * perimeters[t] + 64 * eps * mesh.areas[t]);
    }

    for (const SurfacePoint& vertex : output.vertices) {
        ASSERT_LT(vertex.face, mesh.triangles.size());
        EXPECT_GE(vertex.u, 0.0);
        EXPECT_GE(vertex.v, 0.0);
        EXPECT_LE(vertex.u + vertex.v, 1.0);
        EXPECT_LE((mesh.at(vertex.face, vertex.u, vertex.v).position - vertex.position).norm(), error);
        EXPECT_NEAR(vertex.normal.norm(), 1.0, 4 * eps);
        EXPECT_GT(vertex.normal.dot(mesh.normals[vertex.face]), 0.0);
    }
    for (std::size_t f = 0; f < output.triangles.size(); ++f) {
        for (const Index v : output.triangles[f]) {
            EXPECT_EQ(mesh.material[output.vertices[v].face], mesh.material[output.face[f]]);
            EXPECT_EQ(mesh.region[output.vertices[v].face], mesh.region[output.face[f]]);
        }
    }
}

/// Every border edge of a closed mesh is met by exactly one that runs back over the same bits.
void expect_no_crack(const OutputMesh& output) {
    const auto edges = border(output);
    for (const auto& [edge, count] : edges) {
        const auto back = edges.find({edge.second, edge.first});
        ASSERT_NE(back, edges.end());
        EXPECT_EQ(back->second, count);
    }
}

TEST(OutputMesh, CubeHasThreeVerticesAtEachCorner) {
    const Mesh mesh = box(2.0);
    const OutputMesh output = refine(mesh, infinity, no_limit, {});
    expect_sound(mesh, output, infinity);
    EXPECT_EQ(output.triangles, (refine(mesh, infinity, no_limit, {}).triangles));
    EXPECT_EQ(output.triangles.size(), 12u);
    EXPECT_EQ(output.vertices.size(), 24u);
    std::map<Bits, std::set<Bits>> normals_at;
    for (const SurfacePoint& vertex : output.vertices) {
        normals_at[bits(vertex.position)].insert(bits(vertex.normal));
        EXPECT_EQ(vertex.normal, mesh.normals[vertex.face]);
    }
    EXPECT_EQ(normals_at.size(), 8u);
    for (const auto& [position, normals] : normals_at) {
        EXPECT_EQ(normals.size(), 3u);
    }
}

TEST(OutputMesh, RefinedCubeIsTightAlongItsCreases) {
    for (const double max_edge : {1.9, 0.5, 0.11}) {
        const Mesh mesh = box(Vec3(1, 1.3, 2.1));
        const OutputMesh output = refine(mesh, max_edge, no_limit, {});
        expect_sound(mesh, output, max_edge);
        expect_no_crack(output);
        // Each of the twelve edges is a border of both sides, and nothing else is a border.
        const double edges = 4 * (1 + 1.3 + 2.1);
        EXPECT_NEAR(border_length(output), 2 * edges, 1e-12);
        for (const SurfacePoint& vertex : output.vertices) {
            EXPECT_EQ(vertex.normal, mesh.normals[vertex.face]);
        }
    }
}

TEST(OutputMesh, SmoothClosedSurfaceStaysOneSheet) {
    const Mesh mesh = icosphere(2, 3.0, true);
    const double max_edge = 0.2;
    const OutputMesh output = refine(mesh, max_edge, no_limit, {});
    expect_sound(mesh, output, max_edge);
    EXPECT_TRUE(border(output).empty());
    // Euler: V - E + F = 2 with E = 3F/2.
    EXPECT_EQ(2 * output.vertices.size(), output.triangles.size() + 4);
    std::set<Bits> positions;
    for (const SurfacePoint& vertex : output.vertices) {
        positions.insert(bits(vertex.position));
    }
    EXPECT_EQ(positions.size(), output.vertices.size());
}

TEST(OutputMesh, IcosahedronShadesExactlyLikeItsSphere) {
    // By symmetry the normals at the corners are radial, and so are then all their interpolants.
    for (const bool inward : {false, true}) {
        const Mesh mesh = with_creases_from(pi / 3, icosphere(0, 2.0, inward));
        const OutputMesh smooth = refine(mesh, 0.3, no_limit, {});
        expect_sound(mesh, smooth, 0.3);
        for (const SurfacePoint& vertex : smooth.vertices) {
            EXPECT_LE((vertex.normal - (inward ? -1.0 : 1.0) * vertex.position.normalized()).norm(), 32 * eps);
        }
    }
}

TEST(OutputMesh, CreaseAngleDecidesWhatIsSmooth) {
    // The faces of an icosahedron turn by pi - acos(-sqrt(5)/3) across each edge.
    const double turn = pi - std::acos(-std::sqrt(5.0) / 3);
    EXPECT_EQ(refine(with_creases_from(turn * (1 + 1e-12), icosphere(0)), infinity, no_limit, {}).vertices.size(), 12u);
    const Mesh mesh = with_creases_from(turn * (1 - 1e-12), icosphere(0));
    const OutputMesh sharp = refine(mesh, infinity, no_limit, {});
    EXPECT_EQ(sharp.vertices.size(), 60u);
    for (const SurfacePoint& vertex : sharp.vertices) {
        EXPECT_LE((vertex.normal - mesh.normals[vertex.face]).norm(), 4 * eps);
    }
}

TEST(OutputMesh, NormalsOnTessellatedSphereAreNearlyRadial) {
    const double radius = 5.0;
    const Mesh mesh = icosphere(3, radius);
    const OutputMesh output = refine(mesh, 0.2, no_limit, {});
    // A corner normal is a mean of face normals, each within theta of the radius there, so it is off by at most
    // 2 sin(theta/2); the interpolated radii have length cos(theta) or more.
    double theta = 0.0;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        theta = std::max(theta, std::acos(mesh.normals[t].dot(mesh.corner(t, 0)) / radius));
    }
    const double bound = std::asin(2 * std::sin(theta / 2) / std::cos(theta));
    double worst = 0.0;
    for (const SurfacePoint& vertex : output.vertices) {
        worst = std::max(worst, std::acos(std::min(1.0, vertex.normal.dot(vertex.position.normalized()))));
    }
    EXPECT_LT(worst, bound);
    EXPECT_LT(worst, theta / 3) << "no better than flat shading";
}

TEST(OutputMesh, MaterialsPartVerticesButNotNormals) {
    // A roof that bends at x = 1 by less than the crease angle, with a material border at the bend.
    Mesh mesh = grid(2, 1, 2.0, 1.0);
    for (Vec3& point : mesh.points) {
        point.z() = 0.25 * std::abs(point.x() - 1.0);
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        mesh.material[t] = t % 4 < 2 ? 0 : 1;
    }
    mesh.derive();
    ASSERT_EQ(mesh.region_count, 1u);
    const OutputMesh output = refine(mesh, 0.2, no_limit, {});
    expect_sound(mesh, output, 0.2);

    std::map<Bits, std::vector<const SurfacePoint*>> at;
    for (const SurfacePoint& vertex : output.vertices) {
        at[bits(vertex.position)].push_back(&vertex);
    }
    std::size_t parted = 0;
    for (const auto& [position, vertices] : at) {
        const bool on_border = position[0] == 1.0;
        ASSERT_EQ(vertices.size(), on_border ? 2u : 1u);
        if (on_border) {
            ++parted;
            EXPECT_NE(mesh.material[vertices[0]->face], mesh.material[vertices[1]->face]);
            EXPECT_EQ(vertices[0]->normal, vertices[1]->normal);
            EXPECT_LE((vertices[0]->normal - Vec3::UnitZ()).norm(), 8 * eps);
        }
    }
    EXPECT_EQ(parted, 9u); // an edge of length 1 halved three times
}

TEST(OutputMesh, ColoursOfCornersPartVerticesWhereTheyJump) {
    Mesh mesh = grid(2, 1);
    mesh.corner_reflectance.assign(mesh.triangles.size(), {Rgb(0.5), Rgb(0.5), Rgb(0.5)});
    EXPECT_EQ(refine(mesh, infinity, no_limit, {}).vertices.size(), 6u);
    mesh.corner_reflectance[0].fill(Rgb(0.25, 0.5, 0.5)); // both triangles of the first cell
    mesh.corner_reflectance[1].fill(Rgb(0.25, 0.5, 0.5));
    EXPECT_EQ(refine(mesh, infinity, no_limit, {}).vertices.size(), 8u);
}

TEST(OutputMesh, SeamsOfTexturesPartVerticesWhereColoursJump) {
    Scene scene;
    scene.mesh = grid(2, 1); // two cells, of two triangles each
    const auto placed = [&](double left_begins, double right_begins) {
        scene.mesh.corner_texture.resize(scene.mesh.triangles.size());
        for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
            const bool right = scene.mesh.at(t, 1.0 / 3.0, 1.0 / 3.0).position.x() > 0.5;
            for (int k = 0; k < 3; ++k) {
                const Vec3& point = scene.mesh.points[scene.mesh.triangles[t][static_cast<std::size_t>(k)]];
                const double across = 0.5 * point.x() - (right ? 0.25 - right_begins : -left_begins);
                scene.mesh.corner_texture[t][static_cast<std::size_t>(k)] = TextureCoordinates(across, point.y());
            }
        }
        return refine(scene.mesh, infinity, no_limit, {}, scene.texture_seams()).vertices.size();
    };
    const Rgb dark = Rgb::Constant(0.1), bright = Rgb::Constant(0.9), red(0.9, 0.1, 0.1);
    Image image{4, 1, {}};
    for (const Rgb& pixel : {dark, bright, red, red}) {
        image.pixels.push_back(
            {static_cast<float>(pixel[0]), static_cast<float>(pixel[1]), static_cast<float>(pixel[2])});
    }
    const auto texture = std::make_shared<const Texture>(image);
    scene.materials.emplace_back();
    EXPECT_EQ(placed(0.0, 0.5), 6u); // without a texture, no colours
    for (const bool emits : {false, true}) {
        (emits ? scene.materials[0].emission_texture : scene.materials[0].reflectance_texture) = texture;
        EXPECT_EQ(placed(0.0, 0.25), 6u);       // the same colours on both sides
        EXPECT_EQ(placed(0.0, 0.25 + 3.0), 6u); // repeated
        EXPECT_EQ(placed(0.0, 0.5), 8u);
        EXPECT_EQ(placed(0.375, 0.75), 6u); // other places of the texture that look the same
        scene.materials[0].reflectance_texture = nullptr;
    }
}

TEST(OutputMesh, ThePagesOfABookMeetAtTheSpine) {
    for (const int pages : {2, 3, 4, 7}) {
        const Mesh mesh = book(pages);
        const OutputMesh output = refine(mesh, 0.15, no_limit, {});
        expect_sound(mesh, output, 0.15);
        const auto edges = border(output);
        int pieces = 0;
        for (const auto& [edge, count] : edges) {
            if (edge.first[0] == 0.0 && edge.first[1] == 0.0 && edge.second[0] == 0.0 && edge.second[1] == 0.0) {
                EXPECT_EQ(count, pages); // every page has the same piece of the spine
                ++pieces;
            } else {
                EXPECT_EQ(count, 1);
            }
        }
        EXPECT_EQ(pieces, 8);
        EXPECT_NEAR(border_length(output), 4.0 * pages, 1e-12);
    }
}

TEST(OutputMesh, MobiusStripIsCutOnce) {
    const Mesh mesh = mobius(24);
    const OutputMesh output = refine(mesh, 0.05, no_limit, {});
    expect_sound(mesh, output, 0.05);
    double expected = 0.0; // twice the cut and once the rim
    std::map<std::pair<Index, Index>, std::vector<bool>> sides;
    for (const auto& t : mesh.triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Index a = t[k], b = t[(k + 1) % 3];
            sides[std::minmax(a, b)].push_back(a < b);
        }
    }
    int cuts = 0;
    for (const auto& [edge, runs] : sides) {
        if (runs.size() == 1 || runs[0] == runs[1]) {
            expected += static_cast<double>(runs.size()) * (mesh.points[edge.first] - mesh.points[edge.second]).norm();
            cuts += runs.size() == 2;
        }
    }
    EXPECT_EQ(cuts, 1);
    EXPECT_NEAR(border_length(output), expected, 1e-12);
}

TEST(OutputMesh, TwoWaysRoundAnUnjoinedEdge) {
    // Three triangles at the edge 0-1; the fans of two of them close around both of its ends, so the same two
    // vertices carry two border edges.
    const Mesh cap =
        make_mesh({{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0.1}, {0.5, -1, 0.1}, {0.5, 0.1, 1}, {-1, 0, 0}, {2, 0, 0}},
                  {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {0, 2, 5}, {3, 0, 5}, {1, 6, 2}, {1, 3, 6}});
    const OutputMesh output = refine(cap, 0.2, no_limit, {});
    expect_sound(cap, output, 0.2);
    int pieces = 0;
    for (const auto& [edge, count] : border(output)) {
        if (edge.first[1] == 0.0 && edge.first[2] == 0.0 && edge.second[1] == 0.0 && edge.second[2] == 0.0 &&
            edge.first[0] < edge.second[0]) {
            EXPECT_EQ(count, 2); // {0,1,2} and {0,1,4}
            ++pieces;
        }
    }
    EXPECT_EQ(pieces, 8);
}

TEST(OutputMesh, SurfacesThatTouchInAPointStayApart) {
    Mesh mesh = together(icosphere(1), moved(icosphere(1), 1.0, Vec3(0, 0, 5)));
    const Index shared = mesh.triangles.front()[0];
    for (Index& corner : mesh.triangles.back()) {
        corner = corner == mesh.triangles.back()[0] ? shared : corner;
    }
    mesh.derive();
    const OutputMesh output = refine(mesh, infinity, no_limit, {});
    EXPECT_EQ(output.triangles.size(), mesh.triangles.size());
    expect_sound(mesh, output, infinity);
}

TEST(OutputMesh, Needles) {
    const Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0.3, 1e-9, 0}, {0.6, -1, 0}, {0.5, 1e-3, 0.4}},
                                {{0, 1, 2}, {0, 3, 1}, {2, 1, 4}});
    const OutputMesh output = refine(mesh, 0.01, no_limit, {});
    expect_sound(mesh, output, 0.01);
    for (std::size_t f = 0; f < output.triangles.size(); ++f) {
        EXPECT_GT(area(output, f), 0.0);
    }
}

/// Twice as many pieces, twice as many triangles.
TEST(OutputMesh, NeedlesAreCutAcross) {
    const Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {1, 1e-9, 0}, {0, -1e-6, 1e-7}}, {{0, 1, 2}, {0, 3, 1}});
    for (const double max_edge : {0.1, 0.01, 0.001}) {
        const OutputMesh output = refine(mesh, max_edge, no_limit, {});
        expect_sound(mesh, output, max_edge);
        EXPECT_LT(static_cast<double>(output.triangles.size()), 10.0 / max_edge);
    }
}

TEST(OutputMesh, AnglesStayAtLeastHalfAsLarge) {
    const auto smallest_angle = [](const std::array<Vec3, 3>& x) {
        double smallest = pi;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 a = x[(k + 1) % 3] - x[k], b = x[(k + 2) % 3] - x[k];
            smallest = std::min(smallest, std::atan2(a.cross(b).norm(), a.dot(b)));
        }
        return smallest;
    };
    const Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0.2, 0.3, 0}, {0.7, -2, 0.1}}, {{0, 1, 2}, {0, 3, 1}});
    double before = pi, after = pi;
    for (Index t = 0; t < 2; ++t) {
        before = std::min(before, smallest_angle({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)}));
    }
    const OutputMesh output = refine(mesh, 0.02, no_limit, {});
    for (const auto& [a, b, c] : output.triangles) {
        after = std::min(after, smallest_angle({output.vertices[a].position, output.vertices[b].position,
                                                output.vertices[c].position}));
    }
    EXPECT_GE(after, before / 2 * (1 - 1e-12));
}

TEST(OutputMesh, ScalingByPowersOfTwoScalesTheBits) {
    const Mesh mesh = icosphere(1);
    const OutputMesh once = refine(mesh, 0.1, no_limit, {});
    for (const int exponent : {-20, 20}) {
        const double scale = std::ldexp(1.0, exponent);
        const OutputMesh other = refine(moved(mesh, scale, Vec3::Zero()), 0.1 * scale, no_limit, {});
        EXPECT_EQ(other.triangles, once.triangles);
        EXPECT_EQ(other.face, once.face);
        ASSERT_EQ(other.vertices.size(), once.vertices.size());
        for (std::size_t v = 0; v < once.vertices.size(); ++v) {
            ASSERT_EQ(other.vertices[v].position, scale * once.vertices[v].position);
        }
    }
}

TEST(OutputMesh, EndsWhereDoublesEnd) {
    // Edges of some 80 units in the last place, and a limit far below one of them.
    const Mesh mesh = moved(icosphere(1), 1e-8, Vec3::Constant(1e6));
    const OutputMesh output = refine(mesh, 1e-15, std::numeric_limits<std::size_t>::max(), {});
    EXPECT_GT(output.triangles.size(), mesh.triangles.size());
    EXPECT_LE(longest_edge(output), 16 * eps * mesh.magnitude());
    for (const SurfacePoint& vertex : output.vertices) {
        EXPECT_NEAR(vertex.normal.norm(), 1.0, 4 * eps);
    }
}

TEST(OutputMesh, NormalsThatCancelGiveWayToTheFace) {
    // A closed double cone as thin as a knife: smooth all round at a crease angle of 180 degrees.
    const Mesh mesh = with_creases_from(pi, make_mesh({{0, 0, 0}, {1, 0, 0}, {0.5, 1, 1e-13}, {0.5, 0.4, 0}},
                                                      {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {1, 0, 2}}));
    const OutputMesh output = refine(mesh, 0.1, no_limit, {});
    for (const SurfacePoint& vertex : output.vertices) {
        EXPECT_NEAR(vertex.normal.norm(), 1.0, 4 * eps);
        EXPECT_GT(vertex.normal.dot(mesh.normals[vertex.face]), 0.0);
    }
}

TEST(OutputMesh, LimitIsExactAndItsMessageHelps) {
    const Mesh mesh = box(1.0);
    const std::size_t count = refine(mesh, 0.1, no_limit, {}).triangles.size();
    EXPECT_EQ(refine(mesh, 0.1, count, {}).triangles.size(), count);
    for (const std::size_t limit : {count - 1, count / 8}) { // found while refining, and foreseen
        try {
            refine(mesh, 0.1, limit, {});
            FAIL();
        } catch (const ResourceError& error) {
            const std::string message = error.what();
            EXPECT_THAT(message, testing::HasSubstr("--output-spacing"));
            EXPECT_THAT(message, testing::HasSubstr(std::to_string(limit)));
            const double advice = std::stod(message.substr(message.rfind(' ')));
            EXPECT_LE(refine(mesh, advice, limit, {}).triangles.size(), limit);
        }
    }
    EXPECT_THROW(refine(mesh, infinity, 11, {}), ResourceError);
    EXPECT_THROW(refine(mesh, 1e-9, 1000, {}), ResourceError); // at once, not after 1e19 triangles
}

TEST(OutputMesh, CanBeInterrupted) {
    struct Stop : Progress {
        bool cancelled() const override { return true; }
    } stop;
    EXPECT_THROW(refine(box(1.0), 0.1, no_limit, {1, &stop}), Interrupted);
}

} // namespace
} // namespace difusa::output_mesh_test
