#include <difusa/transport/pairwise.h>

#include <difusa/core/parallel.h>

#include <algorithm>
#include <cstdint>

namespace difusa {

Transport pairwise(const Scene& scene, const SiteSet& sites, const ElementIntegrals& integrals,
                   const Visibility& visibility, const Kernel& kernel, const Execution& execution) {
    const std::size_t n = sites.size();
    Transport transport;
    transport.S = SparseRows(n, n);
    transport.L = SparseRows(n, scene.materials.size());
    const bool any_uneven = integrals.uneven[0].rows() > 0;
    if (any_uneven) {
        transport.uneven.fill(transport.L);
    }

    // Which pairs j < k exchange light: one segment a pair, whatever the kernel's asymmetry.
    std::vector<std::vector<Index>> sees(n);
    std::vector<std::size_t> cast(n, 0);
    parallel_for(n, 4, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        std::vector<Segment> segments;
        std::vector<Index> other;
        std::vector<std::uint8_t> blocked;
        for (std::size_t j = begin; j < end; ++j) {
            segments.clear();
            other.clear();
            const SurfacePoint& x = sites.points[j];
            for (std::size_t k = j + 1; k < n; ++k) {
                const SurfacePoint& y = sites.points[k];
                const Vec3 way = y.position - x.position;
                if (x.normal.dot(way) > 0.0 && y.normal.dot(way) < 0.0) {
                    segments.push_back({x.position, y.position, x.face, y.face});
                    other.push_back(static_cast<Index>(k));
                }
            }
            blocked.assign(segments.size(), 0);
            if (!scene.mesh.convex) {
                visibility.occluded(segments, blocked);
                cast[j] = segments.size();
            }
            for (std::size_t i = 0; i < segments.size(); ++i) {
                if (blocked[i] == 0) {
                    sees[j].push_back(other[i]);
                }
            }
        }
    });
    for (const std::size_t count : cast) {
        transport.segments += count;
    }

    // Row j: first the k < j, then the k > j. Lists of the former are gathered in order of k.
    std::vector<std::vector<Index>> seen_by(n);
    for (std::size_t j = 0; j < n; ++j) {
        for (const Index k : sees[j]) {
            seen_by[k].push_back(static_cast<Index>(j));
        }
    }
    parallel_for(n, 16, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        RowAccumulator lamps(scene.materials.size());
        std::vector<RowAccumulator> uneven(3, lamps);
        for (std::size_t j = begin; j < end; ++j) {
            SparseRows::Row& row = transport.S.row(j);
            row.column = std::move(seen_by[j]);
            row.column.insert(row.column.end(), sees[j].begin(), sees[j].end());
            row.value.reserve(row.column.size());
            for (const Index k : row.column) {
                const double form_factor =
                    kernel.form_factor(sites.points[j].position, sites.points[j].normal, sites.points[k].position,
                                       sites.points[k].normal, sites.area[k]);
                row.value.push_back(form_factor);
                const SparseRows::Row& share = integrals.share.row(k);
                for (std::size_t m = 0; m < share.column.size(); ++m) {
                    lamps.add(share.column[m], form_factor * share.value[m]);
                }
                for (std::size_t c = 0; any_uneven && c < 3; ++c) {
                    const SparseRows::Row& E = integrals.uneven[c].row(k);
                    for (std::size_t m = 0; m < E.column.size(); ++m) {
                        uneven[c].add(E.column[m], form_factor * E.value[m]);
                    }
                }
            }
            lamps.take(transport.L.row(j));
            for (std::size_t c = 0; any_uneven && c < 3; ++c) {
                uneven[c].take(transport.uneven[c].row(j));
            }
        }
    });
    return transport;
}

} // namespace difusa
