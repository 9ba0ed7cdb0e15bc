#include <difusa/discretisation/element_integrals.h>

#include <difusa/core/parallel.h>

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
    std::map<std::pair<Index, Index>, Rgb> uneven;
    std::map<Index, Rgb> reflectance; ///< site
    double uncovered = 0.0;
};

template <class Key, class Value> void add(std::map<Key, Value>& sums, const Key& key, const Value& value) {
    const auto [place, is_new] = sums.try_emplace(key, value);
    if (!is_new) {
        place->second += value;
    }
}

} // namespace

ElementIntegrals element_integrals(const Scene& scene, const Basis& basis, double spacing, const Execution& execution) {
    const Mesh& mesh = scene.mesh;
    const std::vector<char> emits = emitting_materials(scene);
    const bool textured = std::any_of(scene.materials.begin(), scene.materials.end(),
                                      [](const Material& m) { return m.reflectance_texture != nullptr; });
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
                    const bool even = !scene.materials[material].emits_unevenly();
                    const Rgb rho = textured ? scene.reflectance(x) : Rgb(Rgb::Zero());
                    const Rgb E = emits[material] != 0 && !even ? scene.emission(x) : Rgb(Rgb::Zero());
                    for (std::size_t i = 0; i < row.element.size(); ++i) {
                        const Index site = row.element[i];
                        const double part = area * row.weight[i];
                        sums[worker]->add(site, part);
                        if (emits[material] != 0 && even) {
                            add(block.share, {site, material}, part);
                        } else if (emits[material] != 0) {
                            add(block.uneven, {site, material}, Rgb(part * E));
                        }
                        if (textured) {
                            add(block.reflectance, site, Rgb(part * rho));
                        }
                    }
                });
            }
            sums[worker]->take(block.area);
        }
    });

    ElementIntegrals integrals;
    integrals.area.assign(basis.size(), 0.0);
    Block sum;
    for (const Block& block : blocks) {
        integrals.uncovered += block.uncovered;
        for (std::size_t k = 0; k < block.area.column.size(); ++k) {
            integrals.area[block.area.column[k]] += block.area.value[k];
        }
        for (const auto& [key, value] : block.share) {
            add(sum.share, key, value);
        }
        for (const auto& [key, value] : block.uneven) {
            add(sum.uneven, key, value);
        }
        for (const auto& [site, value] : block.reflectance) {
            add(sum.reflectance, site, value);
        }
    }
    const auto put = [&](SparseRows& rows, const std::pair<Index, Index>& key, double value) {
        if (integrals.area[key.first] != 0.0) {
            rows.row(key.first).column.push_back(key.second);
            rows.row(key.first).value.push_back(value / integrals.area[key.first]);
        }
    };
    integrals.share = SparseRows(basis.size(), scene.materials.size());
    for (const auto& [key, value] : sum.share) {
        put(integrals.share, key, value);
    }
    for (std::size_t c = 0; c < 3 && has_uneven_emitters(scene); ++c) {
        integrals.uneven[c] = SparseRows(basis.size(), scene.materials.size());
        for (const auto& [key, value] : sum.uneven) {
            put(integrals.uneven[c], key, value[static_cast<Eigen::Index>(c)]);
        }
    }
    if (textured) {
        integrals.reflectance.setZero(static_cast<Eigen::Index>(basis.size()), 3);
        for (const auto& [site, value] : sum.reflectance) {
            if (integrals.area[site] != 0.0) {
                integrals.reflectance.row(site) = (value / integrals.area[site]).matrix().transpose();
            }
        }
    }
    return integrals;
}

} // namespace difusa
