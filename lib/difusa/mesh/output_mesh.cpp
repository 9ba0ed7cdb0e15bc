#include <difusa/mesh/output_mesh.h>

#include <difusa/mesh/smooth_sides.h>

#include <OpenMesh/Core/Mesh/TriConnectivity.hh>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <queue>
#include <string>
#include <utility>

namespace difusa {

namespace {

/// The half-edge mesh being refined. It consists of sheets: joined sides form one edge, all others are boundaries, and
/// each fan of corners is a vertex. Any triangles thus form a manifold, and its vertices are those of the output.
struct Sheets {
    OpenMesh::TriConnectivity links;    ///< connectivity
    std::vector<Vec3> position;         ///< of each vertex
    std::vector<Eigen::Vector2d> place; ///< of each half-edge: u, v of its end vertex, in its input triangle
    std::vector<Index> parent;          ///< of each face: the input triangle it is part of

    std::size_t face_count() const { return links.n_faces(); }

    /// Identical to the bit from either end.
    double squared_length(OpenMesh::EdgeHandle edge) const {
        const auto [a, b] = ends(edge);
        return (a - b).squaredNorm();
    }
    Vec3 midpoint(OpenMesh::EdgeHandle edge) const {
        const auto [a, b] = ends(edge);
        return 0.5 * (a + b);
    }

    std::pair<Vec3, Vec3> ends(OpenMesh::EdgeHandle edge) const {
        const auto vertex = [&](unsigned k) { return links.to_vertex_handle(links.halfedge_handle(edge, k)).idx(); };
        return {position[static_cast<std::size_t>(vertex(0))], position[static_cast<std::size_t>(vertex(1))]};
    }
};

std::size_t number(OpenMesh::BaseHandle handle) {
    return static_cast<std::size_t>(handle.idx());
}

/// `add_face` would look up edges by their end points and reject a second sheet touching the same ones; the twins
/// already give the connectivity, so the links are set directly.
Sheets make_sheets(const Mesh& mesh, const Twins& twin) {
    const auto [vertex, vertex_count] = number_fans(twin);
    const std::size_t side_count = twin.size();
    DIFUSA_REQUIRE(side_count < static_cast<std::size_t>(std::numeric_limits<int>::max()) / 2);
    const auto handle = [](std::size_t i) { return OpenMesh::VertexHandle(static_cast<int>(i)); };

    Sheets sheets;
    auto& links = sheets.links;
    sheets.position.resize(vertex_count);
    for (Index v = 0; v < vertex_count; ++v) {
        links.new_vertex();
    }
    std::vector<OpenMesh::HalfedgeHandle> half(side_count);     // of each side
    std::vector<OpenMesh::HalfedgeHandle> border(vertex_count); // the boundary half-edge leaving each vertex
    for (std::size_t s = 0; s < side_count; ++s) {
        const Index from = vertex[s], to = vertex[after(s)];
        sheets.position[from] = mesh.points[point_at(mesh, s)];
        if (twin[s] == none || s < twin[s]) {
            half[s] = links.new_edge(handle(from), handle(to));
        } else {
            half[s] = links.opposite_halfedge_handle(half[twin[s]]);
        }
        links.set_halfedge_handle(handle(from), half[s]);
        if (twin[s] == none) {
            DIFUSA_REQUIRE(!border[to].is_valid());
            border[to] = links.opposite_halfedge_handle(half[s]);
        }
    }
    for (std::size_t v = 0; v < vertex_count; ++v) {
        if (border[v].is_valid()) {
            links.set_next_halfedge_handle(border[v], border[number(links.to_vertex_handle(border[v]))]);
            links.set_halfedge_handle(handle(v), border[v]);
        }
    }
    sheets.place.resize(links.n_halfedges());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const OpenMesh::FaceHandle face = links.new_face();
        links.set_halfedge_handle(face, half[3 * t]);
        for (std::size_t s = 3 * t; s < 3 * t + 3; ++s) {
            links.set_face_handle(half[s], face);
            links.set_next_halfedge_handle(half[s], half[after(s)]);
        }
        sheets.place[number(half[3 * t])] = {1.0, 0.0};
        sheets.place[number(half[3 * t + 1])] = {0.0, 1.0};
        sheets.place[number(half[3 * t + 2])] = {0.0, 0.0};
        sheets.parent.push_back(static_cast<Index>(t));
    }
    return sheets;
}

/// Splits an edge at its midpoint, and the face on either side in two.
///
/// The places are halved like the positions, but without rounding: they are multiples of a power of two. They thus stay
/// exact in triangles of any shape, and both sides of an edge agree on them.
void split(Sheets& sheets, OpenMesh::EdgeHandle edge) {
    struct Corner {
        OpenMesh::VertexHandle vertex;
        Eigen::Vector2d place;
    };
    struct Side {
        OpenMesh::FaceHandle face; // invalid beyond a boundary
        std::array<Corner, 3> corners;
        Eigen::Vector2d middle;
    };
    auto& links = sheets.links;
    std::array<Side, 2> sides;
    for (unsigned k = 0; k < 2; ++k) {
        OpenMesh::HalfedgeHandle h = links.halfedge_handle(edge, k);
        Side& side = sides[k];
        side.face = links.face_handle(h);
        if (!side.face.is_valid()) {
            continue;
        }
        for (Corner& corner : side.corners) {
            corner = {links.to_vertex_handle(h), sheets.place[number(h)]};
            h = links.next_halfedge_handle(h);
        }
        side.middle = 0.5 * (side.corners[0].place + side.corners[2].place);
    }

    const OpenMesh::VertexHandle middle = links.new_vertex();
    sheets.position.push_back(sheets.midpoint(edge));
    const std::size_t old_faces = links.n_faces();
    links.split(edge, middle);
    sheets.place.resize(links.n_halfedges());
    sheets.parent.resize(links.n_faces());

    std::size_t next_face = old_faces; // each side keeps its face for one half and gets a new face for the other
    for (const Side& side : sides) {
        if (!side.face.is_valid()) {
            continue;
        }
        const auto new_face = OpenMesh::FaceHandle(static_cast<int>(next_face++));
        sheets.parent[number(new_face)] = sheets.parent[number(side.face)];
        for (const OpenMesh::FaceHandle face : {side.face, new_face}) {
            OpenMesh::HalfedgeHandle h = links.halfedge_handle(face);
            for (int k = 0; k < 3; ++k, h = links.next_halfedge_handle(h)) {
                const OpenMesh::VertexHandle v = links.to_vertex_handle(h);
                const auto* corner = std::find_if(side.corners.begin(), side.corners.end(),
                                                  [&](const Corner& c) { return c.vertex == v; });
                DIFUSA_REQUIRE(v == middle || corner != side.corners.end());
                sheets.place[number(h)] = v == middle ? side.middle : corner->place;
            }
        }
    }
    DIFUSA_REQUIRE(next_face == links.n_faces());
}

/// Triangles much lower than `max_edge` and much longer.
std::vector<char> find_needles(const Mesh& mesh, double max_edge) {
    constexpr double low = 1.0 / 64.0, length = 4.0; // in edges
    std::vector<char> needle(mesh.triangles.size(), 0);
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        double longest = 0.0;
        for (int k = 0; k < 3; ++k) {
            longest = std::max(longest, (mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k)).norm());
        }
        needle[t] = longest > length * max_edge && 2.0 * mesh.areas[t] < low * max_edge * longest ? 1 : 0;
    }
    return needle;
}

/// True if an edge runs inside an input triangle that is a needle.
bool in_needle(const Sheets& sheets, const std::vector<char>& needle, OpenMesh::EdgeHandle edge) {
    const auto& links = sheets.links;
    const auto one = links.face_handle(links.halfedge_handle(edge, 0));
    const auto other = links.face_handle(links.halfedge_handle(edge, 1));
    return one.is_valid() && other.is_valid() && sheets.parent[number(one)] == sheets.parent[number(other)] &&
           needle[sheets.parent[number(one)]] != 0;
}

/// Replaces an edge inside an input triangle by the other diagonal of its two faces, if that is much shorter.
bool flip_to_shorter(Sheets& sheets, OpenMesh::EdgeHandle edge) {
    auto& links = sheets.links;
    const auto a = links.halfedge_handle(edge, 0), b = links.halfedge_handle(edge, 1);
    const auto to_a = links.next_halfedge_handle(a), to_b = links.next_halfedge_handle(b); // to the far corners
    const auto position = [&](OpenMesh::HalfedgeHandle h) {
        return sheets.position[number(links.to_vertex_handle(h))];
    };
    if ((position(to_a) - position(to_b)).squaredNorm() > 0.5 * sheets.squared_length(edge) ||
        !links.is_flip_ok(edge)) {
        return false;
    }
    const Eigen::Vector2d q = sheets.place[number(a)], p = sheets.place[number(b)], r = sheets.place[number(to_a)],
                          s = sheets.place[number(to_b)];
    const auto turn = [](const Eigen::Vector2d& x, const Eigen::Vector2d& y) { return x[0] * y[1] - x[1] * y[0]; };
    if (!(turn(q - s, r - s) > 0.0 && turn(p - r, s - r) > 0.0)) { // the faces are no convex quadrangle
        return false;
    }
    links.flip(edge);
    sheets.place[number(a)] = r;
    sheets.place[number(b)] = s;
    return true;
}

/// No refinement has fewer triangles: a triangle without an edge longer than d has at most the area of the equilateral
/// one, and a triangle whose sides are divided into n pieces in total is divided into at least n - 2.
double least_triangles(const Mesh& mesh, double max_edge) {
    const double largest_area = std::sqrt(0.1875) * max_edge * max_edge;
    double count = 0.0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        double pieces = 0.0;
        for (std::size_t s = 3 * t; s < 3 * t + 3; ++s) {
            const double length = (mesh.points[point_at(mesh, s)] - mesh.points[point_at(mesh, after(s))]).norm();
            pieces += std::max(1.0, std::floor(length / max_edge));
        }
        count += std::max(pieces - 2.0, std::floor(mesh.areas[t] / largest_area));
    }
    return count;
}

[[noreturn]] void refuse(const Mesh& mesh, double max_edge, double least, std::size_t limit) {
    const auto text = [](double value) {
        std::array<char, 32> buffer{};
        std::snprintf(buffer.data(), buffer.size(), "%.3g", value);
        return std::string(buffer.data());
    };
    if (mesh.triangles.size() > limit) {
        throw ResourceError("the mesh has " + std::to_string(mesh.triangles.size()) +
                            " triangles, and memory has room for an output of " + std::to_string(limit) +
                            ": allow more memory, simplify the mesh, or bake it in parts");
    }
    // Halved triangles have on average a third to a half of the area allowed by the bound.
    const double factor = 2.0 * std::sqrt(std::max(1.0, least / static_cast<double>(limit)));
    throw ResourceError("with edges of at most " + text(max_edge) + " the output mesh would have more than " +
                        (least > static_cast<double>(limit) ? text(least) : std::to_string(limit)) +
                        " triangles; the limit is " + std::to_string(limit) +
                        ": choose a larger --output-spacing, such as " + text(factor * max_edge));
}

/// Splits the longest edge until none is longer than `max_edge`.
///
/// Whether and where an edge is split depends only on its two ends, so sheets that touch along an edge without being
/// joined still get the same points on it. The longest edge of all is also the longest of its triangles, hence no new
/// edge is longer, and angles stay at least half as large as the smallest of the input (Rosenberg and Stenger 1975).
///
/// In a needle each half would again have two long sides, so that n pieces of its length became n^1.6 triangles. There
/// the sides are split before the edges between them, which are then flipped: across the needle instead of along it.
void refine(Sheets& sheets, const Mesh& mesh, double max_edge, std::size_t limit, const Execution& execution) {
    // A midpoint is rounded by at most eps * |coordinate|. From 16 times that on, the two halves and the median to the
    // opposite corner are shorter than 0.93 of the edge whatever the rounding, so this terminates.
    const auto can_be_halved = [&](OpenMesh::EdgeHandle edge) {
        const auto [a, b] = sheets.ends(edge);
        const double magnitude = a.cwiseAbs().cwiseMax(b.cwiseAbs()).maxCoeff();
        const Vec3 m = sheets.midpoint(edge);
        return (a - b).norm() > 16.0 * std::numeric_limits<double>::epsilon() * magnitude && m != a && m != b;
    };

    struct Candidate {
        double squared_length;
        int edge;
        bool operator<(const Candidate& other) const { // true if the other goes first
            return squared_length != other.squared_length ? squared_length < other.squared_length : edge > other.edge;
        }
    };
    std::priority_queue<Candidate> candidates;
    const std::vector<char> needle = find_needles(mesh, max_edge);
    const auto consider = [&](OpenMesh::EdgeHandle edge) {
        const double squared_length = sheets.squared_length(edge);
        if (squared_length > max_edge * max_edge && can_be_halved(edge)) {
            candidates.push({(in_needle(sheets, needle, edge) ? 0.5 : 1.0) * squared_length, edge.idx()});
        }
    };
    auto& links = sheets.links;
    for (int e = 0; e < static_cast<int>(links.n_edges()); ++e) {
        consider(OpenMesh::EdgeHandle(e));
    }
    for (std::size_t step = 0; !candidates.empty(); ++step) {
        if (execution.progress != nullptr && step % 4096 == 0) {
            execution.progress->check();
        }
        const OpenMesh::EdgeHandle edge(candidates.top().edge);
        candidates.pop();
        if (in_needle(sheets, needle, edge) && flip_to_shorter(sheets, edge)) {
            consider(edge);
            continue;
        }
        const auto old_edges = static_cast<int>(links.n_edges());
        split(sheets, edge);
        if (sheets.face_count() > limit) {
            refuse(mesh, max_edge, 0.0, limit);
        }
        consider(edge); // now one of its halves
        for (int e = old_edges; e < static_cast<int>(links.n_edges()); ++e) {
            consider(OpenMesh::EdgeHandle(e));
        }
    }
}

} // namespace

double expected_output_triangles(const Mesh& mesh, double max_edge) {
    // Halved triangles have on average a third to a half of the area allowed by the bound.
    const auto own = static_cast<double>(mesh.triangles.size());
    return own + 3.0 * (least_triangles(mesh, max_edge) - own);
}

void check_refinement(const Mesh& mesh, double max_edge, std::size_t triangle_limit) {
    if (const double least = least_triangles(mesh, max_edge); least > static_cast<double>(triangle_limit)) {
        refuse(mesh, max_edge, least, triangle_limit);
    }
}

OutputMesh refine(const Mesh& mesh, double max_edge, std::size_t triangle_limit, const Execution& execution,
                  const std::vector<char>& seams) {
    DIFUSA_REQUIRE(max_edge > 0.0);
    check_refinement(mesh, max_edge, triangle_limit);
    Sheets sheets = make_sheets(mesh, part_materials(mesh, join_smooth_sides(mesh, mesh.crease_angle), seams));
    refine(sheets, mesh, max_edge, triangle_limit, execution);

    OutputMesh output;
    const auto& links = sheets.links;
    output.vertices.resize(links.n_vertices());
    output.triangles.resize(links.n_faces());
    output.face = std::move(sheets.parent);
    for (std::size_t f = 0; f < output.triangles.size(); ++f) {
        OpenMesh::HalfedgeHandle h = links.halfedge_handle(OpenMesh::FaceHandle(static_cast<int>(f)));
        for (Index& corner : output.triangles[f]) {
            corner = static_cast<Index>(links.to_vertex_handle(h).idx());
            SurfacePoint& vertex = output.vertices[corner];
            if (vertex.face == none) {
                vertex.position = sheets.position[corner];
                vertex.face = output.face[f];
                vertex.u = sheets.place[number(h)].x();
                vertex.v = sheets.place[number(h)].y();
            }
            h = links.next_halfedge_handle(h);
        }
    }
    for (SurfacePoint& vertex : output.vertices) {
        DIFUSA_REQUIRE(vertex.face != none);
        vertex.normal = mesh.shading.at_vertex(vertex.face, vertex.u, vertex.v, mesh.normals[vertex.face]);
    }
    return output;
}

} // namespace difusa
