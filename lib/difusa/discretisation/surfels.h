// Surfels: pieces of the surface smaller than the distance of sites. What a ray meets is told by the number of a
// surfel: its mean reflectance, emission and light stand for those of the hit. They know geometry alone.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/mesh/convex_polygon.h>
#include <difusa/mesh/mesh.h>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace difusa {

/// A division of the whole surface. A triangle larger than a surfel is covered by a square grid along its longest side;
/// smaller triangles of one region that face the same way and lie in one cube of space make a surfel together. Where a
/// separator (separators.h) stands on the surface, surfels end at its plane, so that none lies on both sides of a wall.
class Surfels {
  public:
    /// `edge`: side of the squares and cubes, a length. The mesh must outlive the surfels. Throws ResourceError if
    /// there would be more than 2^31.
    Surfels(const Mesh& mesh, double edge, const Execution& execution);

    const Mesh& mesh() const { return *mesh_; }
    std::size_t size() const { return area_.size(); }
    double edge() const { return edge_; }

    /// Of a surfel. They sum to the area of the surface, up to rounding.
    double area(Index s) const { return area_[s]; }

    /// The surfel that the point (u, v) of a triangle belongs to.
    Index at(Index triangle, double u, double v) const {
        const Place& place = place_[triangle];
        const Index base = place.grid == none ? place.first : cell_at(grids_[place.grid], u, v);
        const Index number = number_[base];
        return (number & is_split) == 0 ? number : part_at(splits_[number & ~is_split], triangle, u, v);
    }

    /// A part of a surfel in one plane.
    struct Piece {
        Index triangle = none;
        ConvexPolygon outline; ///< in barycentric coordinates (u, v)
        double area = 0.0;
    };

    /// The column and row of the square that it is or is a part of, in the grid of its triangle; nothing for clusters.
    std::optional<std::array<Index, 2>> square(Index s) const;

    /// What a surfel consists of; never empty.
    void pieces(Index s, std::vector<Piece>& pieces) const;

    /// Around the square or cluster that it is, or that walls have cut it out of.
    Eigen::AlignedBox3d box_of_cell(Index s) const;

    /// The centroid of its largest piece.
    SurfacePoint centre(Index s, std::vector<Piece>& scratch) const;

    /// A point that is uniform by area if u and v are uniform in [0, 1). `pieces`: those of the surfel.
    SurfacePoint point_on(const std::vector<Piece>& pieces, double u, double v) const;

    /// For each surfel, its number in the division by the same edge of a mesh with the same triangles, of which those
    /// that are marked are elsewhere: `none` for surfels on these, and for those that walls cut otherwise there.
    std::vector<Index> numbers_in(const Surfels& other, std::span<const char> marked) const;

    /// Bytes taken.
    std::size_t bytes() const;

  private:
    static constexpr Index is_split = Index{1} << 31U;
    static constexpr std::size_t most_planes = 8; ///< that part a cell; of more, those that cross most of it

    /// The squares of one triangle, in slabs across its longest side: x along that side and y above it in units of the
    /// squares' sides.
    struct Grid {
        Index triangle = none;
        Index first_slab = 0, slabs = 1;
        std::array<double, 3> x, y; ///< x = x[0] + x[1] u + x[2] v, likewise y
    };
    /// Where the cells of a triangle are: in a grid, or all of it in cell `first`.
    struct Place {
        Index first = none, grid = none;
    };
    struct Plane {
        Vec3 normal;
        double offset; ///< normal·p = offset
        double weight; ///< length of what it cuts of the cell
    };
    /// A cell cut by planes: part[c] holds the points for which bit i of c says that they lie above plane i.
    struct Split {
        std::vector<Plane> planes;
        std::vector<Index> part;
    };
    struct Part {
        std::uint32_t code = 0;
        std::vector<Piece> pieces;
    };

    Index cell_at(const Grid& grid, double u, double v) const;
    Index part_at(const Split& split, Index triangle, double u, double v) const;
    void lay_grids();
    void add_grid(Index t, int longest);
    void gather_clusters(const std::vector<Index>& small);
    std::vector<std::vector<Plane>> cuts(const Execution& execution) const;
    void mark(Index t, const Vec3& a, const Vec3& b, const Plane& plane, std::vector<std::vector<Plane>>& cuts) const;
    void number_parts(std::vector<std::vector<Plane>> cuts);
    struct Square {
        const Grid* grid;
        Index slab, row, rows; ///< rows: of the slab
    };
    Square square_of(Index cell) const;
    static ConvexPolygon whole_square(const Grid& grid, Index slab, Index row);
    void cell_pieces(Index base, std::vector<Piece>& pieces) const;
    std::vector<Part> parts_of(const Split& split, const std::vector<Piece>& pieces) const;
    void cut_pieces(const Plane& plane, bool above, std::vector<Piece>& pieces) const;
    void measure(std::vector<Piece>& pieces) const;
    std::vector<Index> cells_in(const Surfels& other, std::span<const char> marked) const;
    Index number_in(const Surfels& other, Index s, Index cell) const;

    const Mesh* mesh_;
    double edge_;
    std::vector<Place> place_;          ///< #T
    std::vector<Grid> grids_;           ///< by triangle
    std::vector<Index> slab_first_;     ///< first cell of each slab of each grid, and of the first cluster
    Index clusters_ = 0;                ///< cells from this number on are clusters
    std::vector<Index> cluster_first_;  ///< #clusters + 1
    std::vector<Index> cluster_member_; ///< triangles
    std::vector<Index> number_;         ///< #cells: the surfel, or is_split and the number of the split
    std::vector<Split> splits_;
    std::vector<double> area_;       ///< #surfels
    std::vector<Index> cell_;        ///< #surfels: the cell each is, or is a part of
    std::vector<std::uint8_t> code_; ///< #surfels: which part
};

} // namespace difusa
