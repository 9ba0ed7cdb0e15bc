#include <difusa/discretisation/surfels.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/core/text.h>
#include <difusa/discretisation/cell_table.h>
#include <difusa/discretisation/separators.h>
#include <difusa/discretisation/wall_sections.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace difusa {

namespace {

constexpr double most_cells = 0x1p31;

/// Which face of a cube the direction points to: 0 to 5.
Index side_of(const Vec3& n) {
    Eigen::Index axis = 0;
    n.cwiseAbs().maxCoeff(&axis);
    return static_cast<Index>(2 * axis + (n[axis] < 0.0 ? 1 : 0));
}

/// The function of position n·p - offset on a triangle, as a + b·(u, v).
std::pair<double, Eigen::Vector2d> on_triangle(const Mesh& mesh, Index t, const Vec3& n, double offset) {
    const double a = n.dot(mesh.corner(t, 0)) - offset;
    return {a, {n.dot(mesh.corner(t, 1)) - offset - a, n.dot(mesh.corner(t, 2)) - offset - a}};
}

ConvexPolygon whole_triangle() {
    ConvexPolygon polygon;
    polygon.add({0.0, 0.0});
    polygon.add({1.0, 0.0});
    polygon.add({0.0, 1.0});
    return polygon;
}

} // namespace

Surfels::Surfels(const Mesh& mesh, double edge, const Execution& execution) : mesh_(&mesh), edge_(edge) {
    DIFUSA_REQUIRE(edge > 0.0);
    lay_grids();
    number_parts(cuts(execution));
}

void Surfels::lay_grids() {
    const Mesh& mesh = *mesh_;
    place_.resize(mesh.triangles.size());
    std::vector<Index> small;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        int longest = 0;
        double length = 0.0;
        for (int k = 0; k < 3; ++k) {
            const double side = (mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k)).norm();
            if (side > length) {
                length = side;
                longest = k;
            }
        }
        if (length > edge_) {
            add_grid(t, longest);
        } else {
            small.push_back(t);
        }
    }
    clusters_ = slab_first_.empty() ? 0 : slab_first_.back();
    gather_clusters(small);
}

/// Squares along the side from corner `longest` to the next.
void Surfels::add_grid(Index t, int longest) {
    const Mesh& mesh = *mesh_;
    const std::array<int, 3> k{longest, (longest + 1) % 3, (longest + 2) % 3}; // ends of the side, apex
    const Vec3 a = mesh.corner(t, k[0]), along = mesh.corner(t, k[1]) - a, to_apex = mesh.corner(t, k[2]) - a;
    const double length = along.norm(), foot = to_apex.dot(along) / length;
    const double height = 2.0 * mesh.areas[t] / length;
    const double slabs = std::ceil(length / edge_), rows = std::ceil(height / edge_);
    if (!(static_cast<double>(slab_first_.empty() ? 0 : slab_first_.back()) + slabs * rows < most_cells)) {
        throw ResourceError("a surface of this size cannot be divided into pieces of " + text_of(edge_) +
                            ": give a larger --spacing");
    }
    Grid grid;
    grid.triangle = t;
    grid.slabs = static_cast<Index>(slabs);
    const double unit_x = slabs / length, unit_y = rows / height, apex = foot * unit_x;
    std::array<double, 3> x{}, y{}; // by corner
    x[static_cast<std::size_t>(k[1])] = slabs;
    x[static_cast<std::size_t>(k[2])] = apex;
    y[static_cast<std::size_t>(k[2])] = height * unit_y;
    grid.x = {x[0], x[1] - x[0], x[2] - x[0]};
    grid.y = {y[0], y[1] - y[0], y[2] - y[0]};
    if (slab_first_.empty()) {
        slab_first_.push_back(0);
    }
    grid.first_slab = static_cast<Index>(slab_first_.size() - 1);
    for (double slab = 0.0; slab < slabs; slab += 1.0) {
        const double top = std::clamp(apex, slab, slab + 1.0); // where the triangle is highest in this slab
        const double share = top <= apex ? (apex > 0.0 ? top / apex : 1.0) : (slabs - top) / (slabs - apex);
        const double high = std::clamp(std::ceil(share * rows * (1.0 - 1e-12)), 1.0, rows);
        slab_first_.push_back(slab_first_.back() + static_cast<Index>(high));
    }
    place_[t] = {none, static_cast<Index>(grids_.size())};
    grids_.push_back(grid);
}

void Surfels::gather_clusters(const std::vector<Index>& small) {
    const Mesh& mesh = *mesh_;
    CellTable table;
    std::vector<Index> cluster(small.size());
    for (std::size_t i = 0; i < small.size(); ++i) {
        const Index t = small[i];
        const Vec3 middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3.0;
        const Vec3 scaled = (middle - mesh.low) / edge_;
        Cell cell{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            // Scenes more than 2^30 surfels across wrap round: what then shares a number is still of one region.
            cell[axis] = static_cast<std::int32_t>(std::fmod(scaled[static_cast<Eigen::Index>(axis)], 0x1p30));
        }
        cluster[i] = table.insert(cell, 6 * mesh.region[t] + side_of(mesh.normals[t]));
        place_[t].first = clusters_ + cluster[i];
    }
    cluster_first_.assign(table.count() + 1, 0);
    for (const Index c : cluster) {
        ++cluster_first_[c + 1];
    }
    for (std::size_t c = 0; c < table.count(); ++c) {
        cluster_first_[c + 1] += cluster_first_[c];
    }
    cluster_member_.resize(small.size());
    std::vector<Index> next(cluster_first_.begin(), cluster_first_.end() - 1);
    for (std::size_t i = 0; i < small.size(); ++i) {
        cluster_member_[next[cluster[i]]++] = small[i];
    }
}

Index Surfels::cell_at(const Grid& grid, double u, double v) const {
    const double x = grid.x[0] + grid.x[1] * u + grid.x[2] * v, y = grid.y[0] + grid.y[1] * u + grid.y[2] * v;
    const auto slab = x > 0.0 ? std::min(static_cast<Index>(x), grid.slabs - 1) : 0;
    const Index* const first = &slab_first_[grid.first_slab + slab];
    const auto row = y > 0.0 ? std::min(static_cast<Index>(y), first[1] - first[0] - 1) : 0;
    return first[0] + row;
}

Index Surfels::part_at(const Split& split, Index triangle, double u, double v) const {
    const Vec3 position = mesh_->at(triangle, u, v).position;
    std::size_t code = 0;
    for (std::size_t i = 0; i < split.planes.size(); ++i) {
        code |= static_cast<std::size_t>(split.planes[i].normal.dot(position) > split.planes[i].offset) << i;
    }
    return split.part[code];
}

/// The planes of the walls that stand on each cell.
std::vector<std::vector<Surfels::Plane>> Surfels::cuts(const Execution& execution) const {
    std::vector<std::vector<Plane>> cuts(clusters_ + cluster_first_.size() - 1);
    for (const WallSection& section : wall_sections(*mesh_, execution)) {
        const Vec3& normal = mesh_->normals[section.wall];
        mark(section.triangle, section.from, section.to, {normal, normal.dot(mesh_->corner(section.wall, 0)), 0.0},
             cuts);
    }
    return cuts;
}

/// Notes the plane at all cells of triangle t that the segment ab on it passes through.
void Surfels::mark(Index t, const Vec3& a, const Vec3& b, const Plane& plane,
                   std::vector<std::vector<Plane>>& cuts) const {
    const double rounding = wall_rounding(*mesh_);
    const auto note = [&](Index cell, double weight) {
        for (Plane& known : cuts[cell]) {
            const double cosine = known.normal.dot(plane.normal);
            if (std::abs(cosine) > 1.0 - 1e-9 &&
                std::abs(known.offset - (cosine > 0.0 ? plane.offset : -plane.offset)) <= rounding) {
                known.weight += weight;
                return;
            }
        }
        cuts[cell].push_back({plane.normal, plane.offset, weight});
    };
    const Place& place = place_[t];
    if (place.grid == none) {
        note(place.first, (b - a).norm());
        return;
    }
    const Grid& grid = grids_[place.grid];
    const Vec3 corner = mesh_->corner(t, 0), along_u = mesh_->corner(t, 1) - corner,
               along_v = mesh_->corner(t, 2) - corner;
    const auto in_grid = [&](const Vec3& p) {
        const Vec3 n = along_u.cross(along_v), way = p - corner;
        const double u = n.dot(way.cross(along_v)) / n.squaredNorm(), v = n.dot(along_u.cross(way)) / n.squaredNorm();
        return Eigen::Vector2d(grid.x[0] + grid.x[1] * u + grid.x[2] * v, grid.y[0] + grid.y[1] * u + grid.y[2] * v);
    };
    Eigen::Vector2d p = in_grid(a), q = in_grid(b);
    if (p[0] > q[0]) {
        std::swap(p, q);
    }
    constexpr double margin = 1e-6; // of a square: a cell marked too many is cut in vain
    const auto slab_of = [&](double x) {
        return static_cast<Index>(std::clamp(std::floor(x), 0.0, static_cast<double>(grid.slabs - 1)));
    };
    // The length of ab within a cell.
    const auto length_in = [&](Index slab, Index row) {
        double enter = 0.0, leave = 1.0;
        for (int axis = 0; axis < 2; ++axis) {
            const double low = axis == 0 ? slab : row, from = p[axis], way = q[axis] - from;
            if (std::abs(way) > margin) {
                const double at_low = (low - from) / way, at_high = (low + 1.0 - from) / way;
                enter = std::max(enter, std::min(at_low, at_high));
                leave = std::min(leave, std::max(at_low, at_high));
            }
        }
        return std::max(0.0, leave - enter) * (b - a).norm();
    };
    for (Index slab = slab_of(p[0] - margin); slab <= slab_of(q[0] + margin); ++slab) {
        const double width = q[0] - p[0];
        const auto height = [&](double x) {
            return width > margin ? p[1] + (q[1] - p[1]) * std::clamp((x - p[0]) / width, 0.0, 1.0)
                                  : (x < q[0] ? p[1] : q[1]);
        };
        double low = height(static_cast<double>(slab) - margin),
               high = height(static_cast<double>(slab) + 1.0 + margin);
        if (width <= margin) {
            low = p[1];
            high = q[1];
        }
        const Index first = slab_first_[grid.first_slab + slab], rows = slab_first_[grid.first_slab + slab + 1] - first;
        const auto row_of = [&](double y) {
            return static_cast<Index>(std::clamp(std::floor(y), 0.0, static_cast<double>(rows - 1)));
        };
        for (Index row = row_of(std::min(low, high) - margin); row <= row_of(std::max(low, high) + margin); ++row) {
            note(first + row, length_in(slab, row));
        }
    }
}

/// Numbers the cells, and the parts of those that are cut.
void Surfels::number_parts(std::vector<std::vector<Plane>> cuts) {
    number_.resize(cuts.size());
    std::vector<Piece> pieces;
    const auto area_of = [&] {
        double sum = 0.0;
        for (const Piece& piece : pieces) {
            sum += piece.area;
        }
        return sum;
    };
    const auto add = [&](Index cell, std::uint8_t code, double area) {
        area_.push_back(area);
        cell_.push_back(cell);
        code_.push_back(code);
        return static_cast<Index>(area_.size() - 1);
    };
    for (Index cell = 0; cell < cuts.size(); ++cell) {
        std::vector<Plane>& planes = cuts[cell];
        cell_pieces(cell, pieces);
        const double whole = area_of();
        if (planes.empty()) {
            number_[cell] = add(cell, 0, whole);
            continue;
        }
        std::stable_sort(planes.begin(), planes.end(),
                         [](const Plane& a, const Plane& b) { return a.weight > b.weight; });
        planes.resize(std::min(planes.size(), most_planes));
        Split split{std::move(planes), {}};
        split.part.assign(std::size_t{1} << split.planes.size(), none);
        number_[cell] = is_split | static_cast<Index>(splits_.size());
        std::vector<std::uint32_t> known;
        for (Part& part : parts_of(split, pieces)) {
            pieces = std::move(part.pieces);
            if (const double area = area_of(); area > 1e-9 * whole) {
                split.part[part.code] = add(cell, static_cast<std::uint8_t>(part.code), area);
                known.push_back(part.code);
            }
        }
        if (known.empty()) {
            split.part[0] = add(cell, 0, whole); // no more than a speck
            known.push_back(0);
        }
        // What rounding puts where nothing is belongs to the part it has most sides in common with.
        for (std::uint32_t code = 0; code < split.part.size(); ++code) {
            const auto apart = [code](std::uint32_t a, std::uint32_t b) {
                return std::popcount(code ^ a) < std::popcount(code ^ b);
            };
            split.part[code] = split.part[*std::min_element(known.begin(), known.end(), apart)];
        }
        splits_.push_back(std::move(split));
    }
}

/// Where in which grid a cell is that is no cluster.
Surfels::Square Surfels::square_of(Index cell) const {
    const auto after = std::upper_bound(slab_first_.begin(), slab_first_.end(), cell);
    const auto at = static_cast<Index>(after - slab_first_.begin() - 1);
    const auto grid_after = std::upper_bound(grids_.begin(), grids_.end(), at,
                                             [](Index slab, const Grid& grid) { return slab < grid.first_slab; });
    const Grid& grid = *(grid_after - 1);
    return {&grid, at - grid.first_slab, cell - slab_first_[at], slab_first_[at + 1] - slab_first_[at]};
}

std::optional<std::array<Index, 2>> Surfels::square(Index s) const {
    if (cell_[s] >= clusters_) {
        return {};
    }
    const Square square = square_of(cell_[s]);
    return {{square.slab, square.row}};
}

/// A square that the triangle's sides leave whole, as most are; empty if they may cut it.
ConvexPolygon Surfels::whole_square(const Grid& grid, Index slab, Index row) {
    constexpr double rounding = 1e-12;
    const double determinant = grid.x[1] * grid.y[2] - grid.x[2] * grid.y[1];
    ConvexPolygon square;
    for (const auto& [right, up] :
         {std::pair(0.0, 0.0), std::pair(1.0, 0.0), std::pair(1.0, 1.0), std::pair(0.0, 1.0)}) {
        const double x = static_cast<double>(slab) + right - grid.x[0], y = static_cast<double>(row) + up - grid.y[0];
        const Eigen::Vector2d uv((grid.y[2] * x - grid.x[2] * y) / determinant,
                                 (grid.x[1] * y - grid.y[1] * x) / determinant);
        if (!(uv[0] >= -rounding && uv[1] >= -rounding && uv.sum() <= 1.0 + rounding)) {
            return {};
        }
        const Eigen::Vector2d inside = uv.cwiseMax(0.0);
        square.add(inside / std::max(1.0, inside.sum()));
    }
    return square;
}

void Surfels::cell_pieces(Index cell, std::vector<Piece>& pieces) const {
    pieces.clear();
    if (cell >= clusters_) {
        const Index cluster = cell - clusters_;
        for (Index i = cluster_first_[cluster]; i < cluster_first_[cluster + 1]; ++i) {
            pieces.push_back({cluster_member_[i], whole_triangle(), mesh_->areas[cluster_member_[i]]});
        }
        return;
    }
    const Square square = square_of(cell);
    const Grid& grid = *square.grid;
    const Index slab = square.slab, row = square.row, rows = square.rows;
    if (const ConvexPolygon whole = whole_square(grid, slab, row); whole.count > 0) {
        pieces.push_back({grid.triangle, whole, 2.0 * mesh_->areas[grid.triangle] * whole.area()});
        return;
    }
    ConvexPolygon polygon = whole_triangle();
    const Eigen::Vector2d along_x(grid.x[1], grid.x[2]), along_y(grid.y[1], grid.y[2]);
    if (slab > 0) {
        polygon = polygon.cut(grid.x[0] - static_cast<double>(slab), along_x);
    }
    if (slab + 1 < grid.slabs) {
        polygon = polygon.cut(static_cast<double>(slab) + 1.0 - grid.x[0], -along_x);
    }
    if (row > 0) {
        polygon = polygon.cut(grid.y[0] - static_cast<double>(row), along_y);
    }
    if (row + 1 < rows) {
        polygon = polygon.cut(static_cast<double>(row) + 1.0 - grid.y[0], -along_y);
    }
    if (polygon.count == 0) { // a corner that rounding alone lets into the cell
        const double x = std::clamp(static_cast<double>(slab) + 0.5, 0.0, static_cast<double>(grid.slabs));
        Eigen::Matrix2d M;
        M << along_x.transpose(), along_y.transpose();
        Eigen::Vector2d uv = M.inverse() * Eigen::Vector2d(x - grid.x[0], static_cast<double>(row) - grid.y[0]);
        uv = uv.cwiseMax(0.0);
        uv /= std::max(1.0, uv.sum());
        for (int k = 0; k < 3; ++k) {
            polygon.add(uv);
        }
    }
    pieces.push_back({grid.triangle, polygon, 2.0 * mesh_->areas[grid.triangle] * polygon.area()});
}

/// What is left of the pieces on one side of a plane: above it, or below. Their areas are those of before.
void Surfels::cut_pieces(const Plane& plane, bool above, std::vector<Piece>& pieces) const {
    const double sign = above ? 1.0 : -1.0;
    for (Piece& piece : pieces) {
        const auto [a, b] = on_triangle(*mesh_, piece.triangle, plane.normal, plane.offset);
        piece.outline = piece.outline.cut(sign * a, sign * b);
    }
    std::erase_if(pieces, [](const Piece& piece) { return piece.outline.count == 0; });
}

/// Measures pieces that were cut, and drops slivers that rounding leaves on the line of a wall.
void Surfels::measure(std::vector<Piece>& pieces) const {
    double largest = 0.0;
    for (Piece& piece : pieces) {
        piece.area = 2.0 * mesh_->areas[piece.triangle] * piece.outline.area();
        largest = std::max(largest, piece.area);
    }
    std::erase_if(pieces, [&](const Piece& piece) { return piece.area < 0x1p-30 * largest; });
}

/// The parts into which the planes cut a cell, by code; those without a piece are left out.
std::vector<Surfels::Part> Surfels::parts_of(const Split& split, const std::vector<Piece>& pieces) const {
    std::vector<Part> parts{{0, pieces}};
    for (std::size_t i = 0; i < split.planes.size(); ++i) {
        std::vector<Part> finer;
        for (Part& part : parts) {
            Part above{part.code | std::uint32_t{1} << i, part.pieces};
            cut_pieces(split.planes[i], false, part.pieces);
            cut_pieces(split.planes[i], true, above.pieces);
            for (Part* side : {&part, &above}) {
                if (!side->pieces.empty()) {
                    finer.push_back(std::move(*side));
                }
            }
        }
        parts = std::move(finer);
    }
    std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.code < b.code; });
    for (Part& part : parts) {
        measure(part.pieces);
    }
    return parts;
}

void Surfels::pieces(Index s, std::vector<Piece>& pieces) const {
    const Index cell = cell_[s];
    cell_pieces(cell, pieces);
    if ((number_[cell] & is_split) == 0) {
        return;
    }
    const std::vector<Piece> whole = pieces;
    const Split& split = splits_[number_[cell] & ~is_split];
    for (std::size_t i = 0; i < split.planes.size(); ++i) {
        cut_pieces(split.planes[i], ((std::uint32_t{code_[s]} >> i) & 1U) != 0, pieces);
    }
    measure(pieces);
    if (pieces.empty()) {
        pieces = whole;
    }
}

SurfacePoint Surfels::centre(Index s, std::vector<Piece>& scratch) const {
    pieces(s, scratch);
    const auto largest = std::max_element(scratch.begin(), scratch.end(),
                                          [](const Piece& a, const Piece& b) { return a.area < b.area; });
    const Eigen::Vector2d uv = largest->outline.centroid();
    return mesh_->at(largest->triangle, uv[0], uv[1]);
}

SurfacePoint Surfels::point_on(const std::vector<Piece>& pieces, double u, double v) const {
    double sum = 0.0;
    for (const Piece& piece : pieces) {
        sum += piece.area;
    }
    const double wanted = u * sum;
    double below = 0.0;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        if (wanted < below + pieces[i].area || i + 1 == pieces.size()) {
            const double part = pieces[i].area > 0.0 ? std::clamp((wanted - below) / pieces[i].area, 0.0, 1.0) : 0.5;
            // Not on the outline, where a wall may stand.
            const Eigen::Vector2d at = pieces[i].outline.at(part, v),
                                  uv = at + 0x1p-10 * (pieces[i].outline.centroid() - at);
            return mesh_->at(pieces[i].triangle, uv[0], uv[1]);
        }
        below += pieces[i].area;
    }
    return {};
}

std::size_t Surfels::bytes() const {
    return place_.size() * sizeof(Place) + grids_.size() * sizeof(Grid) + slab_first_.size() * sizeof(Index) +
           (cluster_first_.size() + cluster_member_.size() + number_.size() + cell_.size()) * sizeof(Index) +
           area_.size() * sizeof(double) + code_.size();
}

} // namespace difusa
