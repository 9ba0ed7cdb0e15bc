#include <difusa/discretisation/support_grid.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace difusa {

namespace {

/// Squared distance from a point to the box of a cell, both in units of the cell's size.
double distance_squared(const Vec3& point, const Cell& cell) {
    double sum = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = cell[static_cast<std::size_t>(axis)];
        const double gap = std::max({low - point[axis], point[axis] - (low + 1.0), 0.0});
        sum += gap * gap;
    }
    return sum;
}

/// A part of a triangle, in units of the cells' size.
struct TrianglePiece {
    Vec3 a, b, c;
};

/// Halves a piece at its longest edge. One much narrower than the cells' margin is that edge, as good as: halved as a
/// triangle, a needle n cells long would become n^1.6 pieces, side by side.
void halve(TrianglePiece piece, std::vector<TrianglePiece>& pieces) {
    constexpr double narrow = 1e-7;
    const double ab = (piece.b - piece.a).squaredNorm(), bc = (piece.c - piece.b).squaredNorm(),
                 ca = (piece.a - piece.c).squaredNorm();
    if (!(ab >= bc && ab >= ca)) { // the longest edge comes first
        piece = bc >= ca ? TrianglePiece{piece.b, piece.c, piece.a} : TrianglePiece{piece.c, piece.a, piece.b};
    }
    const Vec3 middle = 0.5 * (piece.a + piece.b);
    const bool thin = (piece.b - piece.a).cross(piece.c - piece.a).squaredNorm() <
                      narrow * narrow * (piece.b - piece.a).squaredNorm();
    pieces.push_back({piece.a, middle, thin ? middle : piece.c});
    pieces.push_back({middle, piece.b, thin ? middle : piece.c});
}

} // namespace

/// Half the median support: smaller cells have tighter lists, but there are more of them. Where few supports are much
/// larger than the others they would reach over too many cells: these are at least a quarter of the rms support, so
/// that there are about 50 for each site. A lower limit keeps cell numbers small however dense the sites are.
void SupportGrid::choose_sizes(const Mesh& mesh, const SiteSet& sites, std::span<const double> support) {
    std::vector<std::vector<double>> of_region(mesh.region_count);
    for (std::size_t i = 0; i < sites.size(); ++i) {
        if (!(support[i] > 0.0 && std::isfinite(support[i]))) {
            throw UsageError("the basis states a support of " + text_of(support[i]) + " for an element of radius " +
                             text_of(sites.radius[i]) + ": it has to be finite and above 0");
        }
        of_region[sites.region[i]].push_back(support[i]);
    }
    for (std::vector<double>& own : of_region) {
        if (own.empty()) {
            inverse_size_.push_back(0.0);
            continue;
        }
        const auto middle = own.begin() + static_cast<std::ptrdiff_t>(own.size() / 2);
        std::nth_element(own.begin(), middle, own.end());
        const double median = *middle, count = static_cast<double>(own.size());
        const double rms = std::sqrt(std::inner_product(own.begin(), own.end(), own.begin(), 0.0) / count);
        inverse_size_.push_back(1.0 / std::max({0.5 * median, 0.25 * rms, mesh.diameter() * 0x1p-28}));
    }
}

SupportGrid::SupportGrid(const Mesh& mesh, const SiteSet& sites, std::span<const double> support) {
    choose_sizes(mesh, sites, support);
    origin_ = mesh.low;
    candidates_.resize(sites.size());
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const SurfacePoint& p = sites.points[i];
        candidates_[i] = {{p.position[0], p.position[1], p.position[2]},
                          {p.normal[0], p.normal[1], p.normal[2]},
                          support[i] * support[i],
                          sites.radius[i]};
    }
    mark(mesh);

    // Two passes over the same pairs (cell, site): count, then fill. Rounding may put a point into the cell next to the
    // one its support was tested against, hence the margin.
    const double margin = 1e-6;
    const auto for_each_pair = [&](const auto& act) {
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const double inverse = inverse_size_[sites.region[i]];
            const Vec3 centre = (sites.points[i].position - origin_) * inverse;
            for_each_cell(centre, sites.region[i], support[i] * inverse + margin,
                          [&](Index bucket) { act(bucket, static_cast<Index>(i)); });
        }
    };
    for_each_pair([this](Index bucket, Index) { ++first_[bucket + 1]; });
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    entries_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for_each_pair([&](Index bucket, Index site) { entries_[next[bucket]++] = site; });
}

/// Calls `act(bucket)` for the occupied cells of a block that a ball overlaps.
template <class Act>
void SupportGrid::for_each_cell(const Cell& block, Index number, const Vec3& centre, double reach,
                                const Act& act) const {
    Index bucket = occupied_[number].first;
    for (std::uint64_t left = occupied_[number].cells; left != 0; left &= left - 1, ++bucket) {
        const int bit = std::countr_zero(left);
        const Cell cell{4 * block[0] + (bit & 3), 4 * block[1] + ((bit >> 2) & 3), 4 * block[2] + (bit >> 4)};
        if (distance_squared(centre, cell) <= reach * reach) {
            act(bucket);
        }
    }
}

/// Calls `act(bucket)` for the cells of a region that a ball overlaps.
template <class Act>
void SupportGrid::for_each_cell(const Vec3& centre, Index region, double reach, const Act& act) const {
    const double wide = 0.5 * reach + 2.0; // blocks
    if (wide * wide * wide > static_cast<double>(blocks_.slots().size())) {
        for (const CellTable::Slot& slot : blocks_.slots()) {
            if (slot.region == region) {
                for_each_cell(slot.cell, slot.number, centre, reach, act);
            }
        }
        return;
    }
    Cell low{}, high{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double c = centre[static_cast<Eigen::Index>(axis)];
        low[axis] = static_cast<std::int32_t>(std::floor(c - reach)) >> 2;
        high[axis] = static_cast<std::int32_t>(std::floor(c + reach)) >> 2;
    }
    for (std::int32_t x = low[0]; x <= high[0]; ++x) {
        for (std::int32_t y = low[1]; y <= high[1]; ++y) {
            for (std::int32_t z = low[2]; z <= high[2]; ++z) {
                const Cell block{x, y, z};
                const Index number = blocks_.find(block, region);
                if (number != none) {
                    for_each_cell(block, number, centre, reach, act);
                }
            }
        }
    }
}

void SupportGrid::near(std::span<Query> queries) const {
    constexpr std::size_t group = 16;
    std::array<Cell, group> cell;
    std::array<std::size_t, group> start;
    std::array<Index, group> found;
    for (std::size_t first = 0; first < queries.size(); first += group) {
        const std::size_t count = std::min(group, queries.size() - first);
        for (std::size_t i = 0; i < count; ++i) {
            const Query& query = queries[first + i];
            cell[i] = cell_of(*query.position, query.region);
            start[i] = blocks_.start(block_of(cell[i]), query.region);
            blocks_.prefetch(start[i]);
        }
        for (std::size_t i = 0; i < count; ++i) {
            found[i] = blocks_.find_from(start[i], block_of(cell[i]), queries[first + i].region);
            __builtin_prefetch(occupied_.data() + (found[i] == none ? 0 : found[i]));
        }
        for (std::size_t i = 0; i < count; ++i) {
            found[i] = bucket_of(found[i], cell[i]);
            __builtin_prefetch(first_.data() + (found[i] == none ? 0 : found[i]));
        }
        for (std::size_t i = 0; i < count; ++i) {
            Query& query = queries[first + i];
            query.near = span_of(found[i]);
            for (std::size_t k = 0; k < query.near.size(); k += 16) { // a cache line holds 16 numbers
                __builtin_prefetch(query.near.data() + k);
            }
        }
        for (std::size_t i = 0; i < count; ++i) {
            for (const Index site : queries[first + i].near) {
                __builtin_prefetch(&candidates_[site]);
            }
        }
    }
}

void SupportGrid::mark(const Mesh& mesh) {
    // Each triangle is halved until a piece overlaps at most 2 cells along each axis; then all cells of its box count
    // as overlapped. Points may be rounded across a cell's wall, hence the margin.
    const double margin = 1e-6;
    const auto add = [&](const Cell& cell, Index region) {
        const Index block = blocks_.insert(block_of(cell), region);
        if (block == occupied_.size()) {
            occupied_.emplace_back();
        }
        occupied_[block].cells |= std::uint64_t{1} << bit_of(cell);
    };
    std::vector<TrianglePiece> pieces;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const double inverse = inverse_size_[mesh.region[t]];
        if (inverse == 0.0) {
            continue; // no site is looked for
        }
        const auto place = [&](int k) -> Vec3 { return (mesh.corner(static_cast<Index>(t), k) - origin_) * inverse; };
        pieces.push_back({place(0), place(1), place(2)});
        while (!pieces.empty()) {
            const TrianglePiece piece = pieces.back();
            pieces.pop_back();
            const Vec3 low = piece.a.cwiseMin(piece.b).cwiseMin(piece.c).array() - margin;
            const Vec3 high = piece.a.cwiseMax(piece.b).cwiseMax(piece.c).array() + margin;
            Cell first{}, last{};
            bool small = true;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                first[axis] = static_cast<std::int32_t>(std::floor(low[static_cast<Eigen::Index>(axis)]));
                last[axis] = static_cast<std::int32_t>(std::floor(high[static_cast<Eigen::Index>(axis)]));
                small = small && last[axis] <= first[axis] + 1;
            }
            if (small) {
                for (std::int32_t x = first[0]; x <= last[0]; ++x) {
                    for (std::int32_t y = first[1]; y <= last[1]; ++y) {
                        for (std::int32_t z = first[2]; z <= last[2]; ++z) {
                            add({x, y, z}, mesh.region[t]);
                        }
                    }
                }
                continue;
            }
            halve(piece, pieces);
        }
    }
    Index buckets = 0;
    for (Occupied& occupied : occupied_) {
        occupied.first = buckets;
        buckets += static_cast<Index>(std::popcount(occupied.cells));
    }
    first_.assign(std::size_t{buckets} + 1, 0);
}

} // namespace difusa
