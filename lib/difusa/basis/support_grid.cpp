#include <difusa/basis/support_grid.h>

#include <difusa/core/random.h>

#include <algorithm>
#include <cmath>

namespace difusa {

namespace {

std::uint64_t hash(const std::array<std::int32_t, 3>& cell, Index patch) {
    const auto x = static_cast<std::uint64_t>(static_cast<std::uint32_t>(cell[0]));
    const auto y = static_cast<std::uint64_t>(static_cast<std::uint32_t>(cell[1]));
    const auto z = static_cast<std::uint64_t>(static_cast<std::uint32_t>(cell[2]));
    return mix_bits((x | (y << 32)) + 0x9e3779b97f4a7c15ULL * (z | (static_cast<std::uint64_t>(patch) << 32)));
}

/// Squared distance from a point to the box of a cell, both in units of the cell's size.
double distance_squared(const Vec3& point, const std::array<std::int32_t, 3>& cell) {
    double sum = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = cell[static_cast<std::size_t>(axis)];
        const double gap = std::max({low - point[axis], point[axis] - (low + 1.0), 0.0});
        sum += gap * gap;
    }
    return sum;
}

} // namespace

SupportGrid::SupportGrid(const Mesh& mesh, const SiteSet& sites, std::span<const double> support) {
    std::vector<double> sorted(support.begin(), support.end());
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    // Half a support: smaller cells have tighter lists but there are more of them. A floor keeps cell numbers
    // small however fine the sites are.
    const double size = std::max(0.5 * *middle, mesh.diameter() * 0x1p-28);
    origin_ = mesh.low;
    inverse_size_ = 1.0 / size;

    candidates_.resize(sites.size());
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const SurfacePoint& p = sites.points[i];
        candidates_[i] = {{p.position[0], p.position[1], p.position[2]},
                          {p.normal[0], p.normal[1], p.normal[2]},
                          support[i] * support[i],
                          static_cast<Index>(i)};
    }
    slots_.resize(1024);
    mark(mesh);

    // Two rounds over the same pairs (cell, site): count, then fill. Rounding may put a point into the cell beside
    // the one its support was tested against, hence the margin.
    first_.assign(bucket_count_ + 1, 0);
    const double margin = 1e-6;
    const auto for_each_pair = [&](const auto& act) {
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const Vec3 centre = (sites.points[i].position - origin_) * inverse_size_;
            const double reach = support[i] * inverse_size_ + margin;
            const double wide = 2.0 * reach + 2.0;
            if (wide * wide * wide > static_cast<double>(slots_.size())) {
                for (const Slot& slot : slots_) {
                    if (slot.patch == sites.patch[i] && distance_squared(centre, slot.cell) <= reach * reach) {
                        act(slot.bucket, static_cast<Index>(i));
                    }
                }
                continue;
            }
            Cell low{}, high{};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double c = centre[static_cast<Eigen::Index>(axis)];
                low[axis] = static_cast<std::int32_t>(std::floor(c - reach));
                high[axis] = static_cast<std::int32_t>(std::floor(c + reach));
            }
            for (std::int32_t x = low[0]; x <= high[0]; ++x) {
                for (std::int32_t y = low[1]; y <= high[1]; ++y) {
                    for (std::int32_t z = low[2]; z <= high[2]; ++z) {
                        const Cell cell{x, y, z};
                        if (distance_squared(centre, cell) > reach * reach) {
                            continue;
                        }
                        const std::size_t slot = find(cell, sites.patch[i]);
                        if (slot != empty) {
                            act(slots_[slot].bucket, static_cast<Index>(i));
                        }
                    }
                }
            }
        }
    };
    for_each_pair([this](Index bucket, Index) { ++first_[bucket + 1]; });
    for (std::size_t b = 0; b < bucket_count_; ++b) {
        first_[b + 1] += first_[b];
    }
    entries_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for_each_pair([&](Index bucket, Index site) { entries_[next[bucket]++] = site; });
}

SupportGrid::Cell SupportGrid::cell_of(const Vec3& position) const {
    const Vec3 scaled = (position - origin_) * inverse_size_;
    // Positions lie in the bounding box up to rounding; +1 makes truncation a floor down to -1.
    return {static_cast<std::int32_t>(scaled[0] + 1.0) - 1, static_cast<std::int32_t>(scaled[1] + 1.0) - 1,
            static_cast<std::int32_t>(scaled[2] + 1.0) - 1};
}

std::size_t SupportGrid::find(const Cell& cell, Index patch) const {
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t slot = hash(cell, patch) & mask;; slot = (slot + 1) & mask) {
        if (slots_[slot].patch == none) {
            return empty;
        }
        if (slots_[slot].patch == patch && slots_[slot].cell == cell) {
            return slot;
        }
    }
}

void SupportGrid::insert(const Cell& cell, Index patch) {
    if (2 * (bucket_count_ + 1) > slots_.size()) {
        grow();
    }
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = hash(cell, patch) & mask;
    while (slots_[slot].patch != none) {
        if (slots_[slot].patch == patch && slots_[slot].cell == cell) {
            return;
        }
        slot = (slot + 1) & mask;
    }
    slots_[slot] = {cell, patch, static_cast<Index>(bucket_count_++)};
}

void SupportGrid::grow() {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    const std::size_t mask = slots_.size() - 1;
    for (const Slot& moved : old) {
        if (moved.patch == none) {
            continue;
        }
        std::size_t slot = hash(moved.cell, moved.patch) & mask;
        while (slots_[slot].patch != none) {
            slot = (slot + 1) & mask;
        }
        slots_[slot] = moved;
    }
}

void SupportGrid::mark(const Mesh& mesh) {
    // Each triangle is halved until a piece meets at most 2 cells along each axis; then all cells of its box count
    // as met. Points may be rounded across a cell's wall, hence the margin.
    const double margin = 1e-6;
    struct Piece {
        Vec3 a, b, c;
    };
    std::vector<Piece> pieces;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto place = [&](int k) -> Vec3 {
            return (mesh.corner(static_cast<Index>(t), k) - origin_) * inverse_size_;
        };
        pieces.push_back({place(0), place(1), place(2)});
        while (!pieces.empty()) {
            const Piece piece = pieces.back();
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
                            insert({x, y, z}, mesh.patch[t]);
                        }
                    }
                }
                continue;
            }
            const double ab = (piece.b - piece.a).squaredNorm(), bc = (piece.c - piece.b).squaredNorm(),
                         ca = (piece.a - piece.c).squaredNorm();
            if (ab >= bc && ab >= ca) {
                const Vec3 middle = 0.5 * (piece.a + piece.b);
                pieces.push_back({piece.a, middle, piece.c});
                pieces.push_back({middle, piece.b, piece.c});
            } else if (bc >= ca) {
                const Vec3 middle = 0.5 * (piece.b + piece.c);
                pieces.push_back({piece.b, middle, piece.a});
                pieces.push_back({middle, piece.c, piece.a});
            } else {
                const Vec3 middle = 0.5 * (piece.c + piece.a);
                pieces.push_back({piece.c, middle, piece.b});
                pieces.push_back({middle, piece.a, piece.b});
            }
        }
    }
}

} // namespace difusa
