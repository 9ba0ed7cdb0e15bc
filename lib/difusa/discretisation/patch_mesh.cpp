#include <difusa/discretisation/patch_mesh.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace difusa {

namespace {

/// The coordinates (u, v) of p in a triangle of the mesh.
Eigen::Vector2d flat_place(const Mesh& mesh, Index triangle, const Vec3& p) {
    const Vec3& a = mesh.corner(triangle, 0);
    const Vec3 s = mesh.corner(triangle, 1) - a, t = mesh.corner(triangle, 2) - a, d = p - a;
    const Vec3 n = s.cross(t);
    return Eigen::Vector2d(d.cross(t).dot(n), s.cross(d).dot(n)) / n.squaredNorm();
}

double twice_area(const std::array<Eigen::Vector2d, 3>& c) {
    const Eigen::Vector2d s = c[1] - c[0], t = c[2] - c[0];
    return s[0] * t[1] - s[1] * t[0];
}

/// The cell of a coordinate in a grid with so many along a side.
std::size_t flat_cell(double x, std::size_t across) {
    const double scaled = std::floor(std::max(0.0, x) * static_cast<double>(across));
    return std::min(across - 1, static_cast<std::size_t>(std::min(scaled, 1e9)));
}

/// The refined mesh; what is refused is said of patches, which are none of the output.
OutputMesh patches_of(const Mesh& mesh, double edge, std::size_t limit, const Execution& execution) {
    try {
        return refine(mesh, edge, limit, execution);
    } catch (const ResourceError&) {
        if (mesh.triangles.size() > limit) {
            throw;
        }
        throw ResourceError("at this spacing the mesh would have more patches than memory suffices for (" +
                            std::to_string(limit) + "): give a larger --spacing");
    }
}

} // namespace

PatchMesh::PatchMesh(const Mesh& mesh, double edge, std::size_t limit, const Execution& execution)
    : mesh_(&mesh), refined_(patches_of(mesh, edge, limit, execution)) {
    for (Index f = 0; f < size(); ++f) {
        const auto [a, b, c] = corners(f);
        const Vec3 &p = vertex(a).position, &q = vertex(b).position, &r = vertex(c).position;
        area_.push_back(0.5 * (q - p).cross(r - p).norm());
        flat_.push_back(
            {flat_place(mesh, parent(f), p), flat_place(mesh, parent(f), q), flat_place(mesh, parent(f), r)});
    }
    sort_into_cells();
}

void PatchMesh::sort_into_cells() {
    std::vector<std::size_t> patches(mesh_->triangles.size(), 0);
    for (Index f = 0; f < size(); ++f) {
        ++patches[parent(f)];
    }
    std::size_t cells = 0;
    for (const std::size_t each : patches) {
        const auto across = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(each))));
        grids_.push_back({cells, std::max<std::size_t>(1, across)});
        cells += grids_.back().across * grids_.back().across;
    }
    const auto for_each_cell = [&](Index f, const auto& act) {
        const Grid& grid = grids_[parent(f)];
        const auto& c = flat_[f];
        constexpr double margin = 1e-9; // what rounding may do to coordinates
        const Flat low = c[0].cwiseMin(c[1]).cwiseMin(c[2]).array() - margin;
        const Flat high = c[0].cwiseMax(c[1]).cwiseMax(c[2]).array() + margin;
        for (std::size_t j = flat_cell(low[1], grid.across); j <= flat_cell(high[1], grid.across); ++j) {
            for (std::size_t i = flat_cell(low[0], grid.across); i <= flat_cell(high[0], grid.across); ++i) {
                act(grid.first + j * grid.across + i);
            }
        }
    };
    cell_first_.assign(cells + 1, 0);
    for (Index f = 0; f < size(); ++f) {
        for_each_cell(f, [&](std::size_t cell) { ++cell_first_[cell + 1]; });
    }
    for (std::size_t k = 0; k < cells; ++k) {
        cell_first_[k + 1] += cell_first_[k];
    }
    cell_patch_.resize(cell_first_.back());
    std::vector<std::size_t> next(cell_first_.begin(), cell_first_.end() - 1);
    for (Index f = 0; f < size(); ++f) {
        for_each_cell(f, [&](std::size_t cell) { cell_patch_[next[cell]++] = f; });
    }
}

std::array<double, 3> PatchMesh::coordinates(Index patch, const Flat& p) const {
    const auto& c = flat_[patch];
    const double whole = twice_area(c);
    return {twice_area({p, c[1], c[2]}) / whole, twice_area({c[0], p, c[2]}) / whole,
            twice_area({c[0], c[1], p}) / whole};
}

SurfacePoint PatchMesh::centre(Index patch) const {
    const auto& c = flat_[patch];
    const Flat p = (c[0] + c[1] + c[2]) / 3.0;
    return mesh_->at(parent(patch), p[0], p[1]);
}

SurfacePoint PatchMesh::point(Index patch, const std::array<double, 3>& weight) const {
    const auto& c = flat_[patch];
    const Flat p = weight[0] * c[0] + weight[1] * c[1] + weight[2] * c[2];
    return mesh_->at(parent(patch), p[0], p[1]);
}

PatchMesh::Place PatchMesh::at(const SurfacePoint& x) const {
    const Grid& grid = grids_[x.face];
    const Flat p(x.u, x.v);
    const std::size_t cell = grid.first + flat_cell(p[1], grid.across) * grid.across + flat_cell(p[0], grid.across);
    Place best;
    double most = -std::numeric_limits<double>::infinity();
    for (std::size_t k = cell_first_[cell]; k < cell_first_[cell + 1]; ++k) {
        const std::array<double, 3> weight = coordinates(cell_patch_[k], p);
        const double least = std::min({weight[0], weight[1], weight[2]});
        if (least > most) {
            most = least;
            best = {cell_patch_[k], weight};
        }
    }
    DIFUSA_REQUIRE(best.patch != none);
    double sum = 0.0;
    for (double& each : best.weight) { // by rounding, or where the surface was refined across a needle
        each = std::max(each, 0.0);
        sum += each;
    }
    for (double& each : best.weight) {
        each /= sum;
    }
    return best;
}

} // namespace difusa
