// Which surfels of a surface are those of another on which some faces have moved.
#include <difusa/discretisation/surfels.h>

#include <difusa/core/error.h>

#include <algorithm>

namespace difusa {

Eigen::AlignedBox3d Surfels::box_of_cell(Index s) const {
    std::vector<Piece> pieces;
    cell_pieces(cell_[s], pieces);
    Eigen::AlignedBox3d box;
    for (const Piece& piece : pieces) {
        for (std::size_t k = 0; k < piece.outline.count; ++k) {
            const Eigen::Vector2d& uv = piece.outline.corner[k];
            box.extend(mesh_->at(piece.triangle, uv[0], uv[1]).position);
        }
    }
    return box;
}

std::vector<Index> Surfels::numbers_in(const Surfels& other, std::span<const char> marked) const {
    DIFUSA_REQUIRE(place_.size() == other.place_.size() && marked.size() == place_.size() && edge_ == other.edge_);
    const std::vector<Index> cells = cells_in(other, marked);
    std::vector<Index> numbers(size(), none);
    for (Index s = 0; s < size(); ++s) {
        const Index cell = cells[cell_[s]];
        numbers[s] = cell == none ? none : number_in(other, s, cell);
    }
    return numbers;
}

/// For each cell the same of the other division, or none.
std::vector<Index> Surfels::cells_in(const Surfels& other, std::span<const char> marked) const {
    std::vector<Index> cells(number_.size(), none);
    const auto members = [](const Surfels& of, Index cell) {
        const Index cluster = cell - of.clusters_;
        return std::span(of.cluster_member_)
            .subspan(of.cluster_first_[cluster], of.cluster_first_[cluster + 1] - of.cluster_first_[cluster]);
    };
    for (Index t = 0; t < place_.size(); ++t) {
        const Place &here = place_[t], &there = other.place_[t];
        if (marked[t] != 0 || (here.grid == none) != (there.grid == none)) {
            continue;
        }
        if (here.grid == none) {
            const auto a = members(*this, here.first), b = members(other, there.first);
            if (a.front() == t && std::equal(a.begin(), a.end(), b.begin(), b.end())) {
                cells[here.first] = there.first;
            }
            continue;
        }
        const Grid &grid = grids_[here.grid], &same = other.grids_[there.grid];
        if (grid.slabs != same.slabs || grid.x != same.x || grid.y != same.y) {
            continue;
        }
        const Index first = slab_first_[grid.first_slab], last = slab_first_[grid.first_slab + grid.slabs];
        for (Index cell = first; cell < last; ++cell) {
            cells[cell] = other.slab_first_[same.first_slab] + (cell - first);
        }
    }
    return cells;
}

/// Of surfel s, the part of a cell of the other division that is the same as its own.
Index Surfels::number_in(const Surfels& other, Index s, Index cell) const {
    const Index own_number = number_[cell_[s]], number = other.number_[cell];
    if ((own_number & is_split) == 0 || (number & is_split) == 0) {
        return own_number == s && (number & is_split) == 0 ? number : none;
    }
    const Split &own = splits_[own_number & ~is_split], &split = other.splits_[number & ~is_split];
    const auto same_plane = [](const Plane& a, const Plane& b) { return a.normal == b.normal && a.offset == b.offset; };
    if (!std::equal(own.planes.begin(), own.planes.end(), split.planes.begin(), split.planes.end(), same_plane)) {
        return none;
    }
    return split.part[code_[s]];
}

} // namespace difusa
