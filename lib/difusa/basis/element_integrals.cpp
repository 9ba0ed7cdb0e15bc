#include <difusa/basis/element_integrals.h>

#include <difusa/core/parallel.h>
#include <difusa/transport/transport.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>

namespace difusa {

namespace {

/// A part of a triangle in barycentric coordinates (u, v).
struct Piece {
    std::array<Eigen::Vector2d, 3> corner;
    double area;
};

/// Calls `act(u, v, area)` for the centroid of each piece of the triangle, pieces small enough.
template <class Act> void for_each_node(const Mesh& mesh, Index t, double longest, const Act& act) {
    const Vec3 a = mesh.corner(t, 0), along_u = mesh.corner(t, 1) - a, along_v = mesh.corner(t, 2) - a;
    std::array<Piece, 64> stack; // a halving doubles the pieces and adds one level: depth, not number, is stacked
    std::size_t top = 0;
    stack[top++] = {{Eigen::Vector2d(0, 0), Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 1)}, mesh.areas[t]};
    while (top > 0) {
        const Piece piece = stack[--top];
        std::size_t widest = 0;
        double length = -1.0;
        for (std::size_t k = 0; k < 3; ++k) {
            const Eigen::Vector2d edge = piece.corner[(k + 1) % 3] - piece.corner[k];
            const double squared = (edge[0] * along_u + edge[1] * along_v).squaredNorm();
            if (squared > length) {
                length = squared;
                widest = k;
            }
        }
        if (length <= longest * longest || top + 2 > stack.size()) {
            const Eigen::Vector2d centre = (piece.corner[0] + piece.corner[1] + piece.corner[2]) / 3.0;
            act(centre[0], centre[1], piece.area);
            continue;
        }
        const Eigen::Vector2d p = piece.corner[widest], q = piece.corner[(widest + 1) % 3],
                              r = piece.corner[(widest + 2) % 3], middle = 0.5 * (p + q);
        stack[top++] = {{middle, q, r}, 0.5 * piece.area};
        stack[top++] = {{p, middle, r}, 0.5 * piece.area};
    }
}

/// The sums of one block of triangles.
struct Block {
    SparseRows::Row area;
    std::map<std::pair<Index, Index>, double> share; ///< (site, material)
    double uncovered = 0.0;
};

} // namespace

ElementIntegrals element_integrals(const Scene& scene, const Basis& basis, double spacing, const Execution& execution) {
    const Mesh& mesh = scene.mesh;
    const std::vector<char> emits = emitting_materials(scene);
    // Blocks of a fixed number of triangles, each summed by itself, then added in order: the same bits for any number
    // of threads.
    const std::size_t block_size = std::max<std::size_t>(1, mesh.triangles.size() / 256);
    const std::size_t block_count = (mesh.triangles.size() + block_size - 1) / block_size;
    std::vector<Block> blocks(block_count);
    std::vector<std::unique_ptr<RowAccumulator>> sums(execution.threads);
    parallel_for(block_count, 1, execution, [&](std::size_t begin, std::size_t end, unsigned worker) {
        if (!sums[worker]) {
            sums[worker] = std::make_unique<RowAccumulator>(basis.size());
        }
        BasisRow row;
        std::size_t nodes = 0;
        for (std::size_t b = begin; b < end; ++b) {
            Block& block = blocks[b];
            const std::size_t last = std::min((b + 1) * block_size, mesh.triangles.size());
            for (std::size_t t = b * block_size; t < last; ++t) {
                const auto face = static_cast<Index>(t);
                const Index material = mesh.material[t];
                for_each_node(mesh, face, 0.5 * spacing, [&](double u, double v, double area) {
                    if (++nodes % 4096 == 0 && execution.progress != nullptr) {
                        execution.progress->check();
                    }
                    const SurfacePoint x = mesh.at(face, u, v);
                    basis.evaluate(x, row);
                    if (row.element.empty()) {
                        block.uncovered += area;
                    }
                    for (std::size_t i = 0; i < row.element.size(); ++i) {
                        sums[worker]->add(row.element[i], area * row.weight[i]);
                        if (emits[material] != 0) {
                            block.share[{row.element[i], material}] += area * row.weight[i] * scene.emission_factor(x);
                        }
                    }
                });
            }
            sums[worker]->take(block.area);
        }
    });

    ElementIntegrals integrals;
    integrals.area.assign(basis.size(), 0.0);
    integrals.share = SparseRows(basis.size(), scene.materials.size());
    std::map<std::pair<Index, Index>, double> share;
    for (const Block& block : blocks) {
        integrals.uncovered += block.uncovered;
        for (std::size_t k = 0; k < block.area.column.size(); ++k) {
            integrals.area[block.area.column[k]] += block.area.value[k];
        }
        for (const auto& [key, value] : block.share) {
            share[key] += value;
        }
    }
    for (const auto& [key, value] : share) {
        if (integrals.area[key.first] != 0.0) {
            SparseRows::Row& row = integrals.share.row(key.first);
            row.column.push_back(key.second);
            row.value.push_back(value / integrals.area[key.first]);
        }
    }
    return integrals;
}

} // namespace difusa
