// Sampler `poisson-disk`: maximal Poisson-disk sampling of the surface under the site distance of T 4.1. No two sites
// are closer than the spacing D, and no surface point is farther than D (1 + 2^-20) from its nearest site, or
// than D and four steps of the coordinates where these are coarser: every face region, wall side and small object has
// sites, whatever the shape of the triangles.
//
// First, darts are thrown evenly over the area. The remaining gaps are then searched for: the triangles are divided
// into pieces; a piece fully covered by one site is done; into any other a dart is thrown, the piece is halved at its
// longest edge, and both halves are queued for the next round.
//
// All darts of a round have random priorities: those become sites that would if they were thrown one at a time by
// priority (SiteGrid::insert). The work is thus shared between threads, with the result of serial dart throwing.
#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/core/text.h>
#include <difusa/discretisation/sampler.h>
#include <difusa/discretisation/site_grid.h>
#include <difusa/plugin/plugin.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

namespace {

using difusa::Dart;
using difusa::Index;
using difusa::Mesh;
using difusa::parallel_for;
using difusa::RandomStream;
using difusa::SiteGrid;
using difusa::SurfacePoint;
using difusa::Vec3;

/// Part of a triangle, its corners in the triangle's barycentric coordinates (u, v).
struct Piece {
    Index face;
    std::array<Eigen::Vector2d, 3> corner;
};

std::array<Vec3, 3> places(const Mesh& mesh, const Piece& piece) {
    std::array<Vec3, 3> result;
    for (std::size_t k = 0; k < 3; ++k) {
        result[k] = mesh.at(piece.face, piece.corner[k][0], piece.corner[k][1]).position;
    }
    return result;
}

/// Uniform over the piece.
SurfacePoint dart(const Mesh& mesh, const Piece& piece, RandomStream& stream) {
    const double root = std::sqrt(stream.uniform()), part = stream.uniform();
    const Eigen::Vector2d uv =
        (1.0 - root) * piece.corner[0] + root * (1.0 - part) * piece.corner[1] + root * part * piece.corner[2];
    return mesh.at(piece.face, uv[0], uv[1]);
}

/// The longest edge of a piece: the number of its first corner, and its length.
struct LongestEdge {
    std::size_t k = 0;
    double squared = 0.0;
    bool thin = false; ///< the piece is lower than `low` above it

    LongestEdge(const std::array<Vec3, 3>& p, double low) {
        for (std::size_t i = 0; i < 3; ++i) {
            const double length = (p[(i + 1) % 3] - p[i]).squaredNorm();
            if (length > squared) {
                squared = length;
                k = i;
            }
        }
        thin = (p[1] - p[0]).cross(p[2] - p[0]).squaredNorm() < low * low * squared;
    }
};

/// Split from the midpoint of the edge between corner k and the next, the first corner of both halves, to the third
/// corner.
std::array<Piece, 2> halves(const Piece& piece, std::size_t k) {
    const Eigen::Vector2d &p = piece.corner[k], &q = piece.corner[(k + 1) % 3], &r = piece.corner[(k + 2) % 3],
                          middle = 0.5 * (p + q);
    return {Piece{piece.face, {middle, q, r}}, Piece{piece.face, {middle, r, p}}};
}

/// The same at its longest edge. A thin piece is its longest edge, as good as: halved as a triangle, a needle n times
/// as long as the pieces wanted would become n^1.6 of them, side by side.
std::array<Piece, 2> halves(const Piece& piece, const LongestEdge& longest) {
    if (!longest.thin) {
        return halves(piece, longest.k);
    }
    const Eigen::Vector2d &p = piece.corner[longest.k], &q = piece.corner[(longest.k + 1) % 3], middle = 0.5 * (p + q);
    return {Piece{piece.face, {middle, q, q}}, Piece{piece.face, {middle, p, p}}};
}

Piece whole(Index face) {
    return {face, {Eigen::Vector2d(0, 0), Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 1)}};
}

/// Pieces this small, or thin, need no more attention: their points are as good as one. The edges of pieces no larger
/// than a step of the coordinates are rounding errors.
double smallest_piece(const Mesh& mesh, double spacing) {
    return std::max(spacing * 0x1p-20, 4.0 * difusa::coordinate_step(mesh));
}

/// Points spread evenly over the area of a mesh, in an order that keeps spatial neighbours close: along the triangles,
/// and within a triangle along the Sierpinski curve through its halves, quarters, eighths, ...
class EvenDarts {
  public:
    EvenDarts(const Mesh& mesh, std::size_t count) : mesh_(mesh), count_(count), below_(mesh.areas.size()) {
        std::partial_sum(mesh.areas.begin(), mesh.areas.end(), below_.begin());
    }

    std::size_t count() const { return count_; }

    /// The i-th of the points.
    Dart at(std::size_t i, RandomStream stream) const {
        // Anywhere in the next `window` shares of the area: neighbours, at most a few shares apart, are practically
        // independent.
        constexpr double window = 64.0;
        const auto count = static_cast<double>(count_);
        double share = (static_cast<double>(i) + window * stream.uniform()) / count;
        share -= std::floor(share);
        const double target = share * below_.back();
        const auto place = std::upper_bound(below_.begin(), below_.end() - 1, target);
        const auto face = static_cast<Index>(place - below_.begin());
        const double area = mesh_.areas[face];
        double along = std::clamp((target - (*place - area)) / area, 0.0, 1.0);
        Piece piece = whole(face);
        for (double points = count * area / below_.back(); points > 2.0; points *= 0.5) {
            along *= 2.0;
            piece = halves(piece, 1)[along < 1.0 ? 0 : 1]; // the new corner comes first: its opposite edge is next
            along -= along < 1.0 ? 0.0 : 1.0;
        }
        const SurfacePoint x = dart(mesh_, piece, stream);
        return {x, stream.bits()};
    }

  private:
    const Mesh& mesh_;
    std::size_t count_;
    std::vector<double> below_; ///< area of the triangles up to and including this one
};

/// For one of many loops: their number is unknown, so no progress is reported; but all end here if cancelled.
difusa::Execution part_of(const difusa::Execution& execution) {
    if (execution.progress != nullptr) {
        execution.progress->check();
    }
    return {execution.threads, nullptr};
}

class PoissonDisk final : public difusa::Sampler {
  public:
    explicit PoissonDisk(const difusa::Parameters& /*parameters*/) {}

    std::vector<SurfacePoint> sample(const Mesh& mesh, const difusa::Visibility* /*visibility*/, double spacing,
                                     std::size_t limit, RandomStream stream,
                                     const difusa::Execution& execution) const override {
        // No site covers more than a disc: this gives a lower bound on their number.
        const double least = mesh.area / (std::numbers::pi * spacing * spacing);
        if (least > static_cast<double>(limit)) {
            throw difusa::ResourceError("at least " + difusa::text_of(least) + " sites are needed at spacing " +
                                        difusa::text_of(spacing) + ", but at most " + std::to_string(limit) +
                                        " fit; give a larger --spacing");
        }
        SiteGrid grid(mesh, spacing, limit);
        throw_darts(mesh, spacing, stream.bits(), grid, execution);
        fill_gaps(mesh, spacing, stream.bits(), grid, execution);
        return grid.take();
    }

  private:
    static void throw_darts(const Mesh& mesh, double spacing, std::uint64_t seed, SiteGrid& grid,
                            const difusa::Execution& execution) {
        // Twice as many as a dense packing of discs of diameter D contains: beyond that most darts miss. In several
        // batches: sites of the first save the others comparisons with each other.
        constexpr std::size_t lots = 4, largest_lot = std::size_t{1} << 20U;
        auto left = static_cast<std::size_t>(2.0 * mesh.area / (spacing * spacing)) + 1;
        const EvenDarts even(mesh, std::clamp<std::size_t>(left / lots, 1, largest_lot));
        std::vector<Dart> darts;
        for (std::uint64_t first = 0; left > 0; first += darts.size(), left -= darts.size()) {
            darts.resize(std::min(left, even.count()));
            parallel_for(darts.size(), 1024, part_of(execution), [&](std::size_t begin, std::size_t end, unsigned) {
                for (std::size_t i = begin; i < end; ++i) {
                    darts[i] = even.at(i, RandomStream(seed, "darts", first + i));
                }
            });
            grid.insert(darts, execution);
        }
    }

    /// The output of part of a round: darts not close to a site of earlier rounds, and the halves of the pieces.
    struct Left {
        std::vector<Dart> darts;
        std::vector<Piece> pieces;
    };

    static void fill_gaps(const Mesh& mesh, double spacing, std::uint64_t seed, SiteGrid& grid,
                          const difusa::Execution& execution) {
        // Triangles are divided and filled in batches, which bounds the memory for pieces.
        constexpr std::size_t lot = std::size_t{1} << 16U;
        const double coarse = 4.0 * spacing, smallest = smallest_piece(mesh, spacing);
        std::uint64_t used = 0; // random streams
        std::vector<Piece> pieces, stack;
        Index next = 0;
        while (next < mesh.triangles.size() || !stack.empty()) {
            pieces.clear();
            while (pieces.size() < lot && (next < mesh.triangles.size() || !stack.empty())) {
                if (stack.empty()) {
                    stack.push_back(whole(next++));
                }
                const Piece piece = stack.back();
                stack.pop_back();
                const LongestEdge longest(places(mesh, piece), smallest);
                if (longest.squared <= coarse * coarse) {
                    pieces.push_back(piece);
                } else {
                    const auto [a, b] = halves(piece, longest);
                    stack.push_back(b);
                    stack.push_back(a);
                }
            }
            while (!pieces.empty()) {
                const std::size_t count = pieces.size();
                pieces = fill_round(mesh, spacing, seed, used, std::move(pieces), grid, execution);
                used += count;
            }
            if (execution.progress != nullptr) {
                execution.progress->advance(static_cast<double>(next) / static_cast<double>(mesh.triangles.size()));
            }
        }
    }

    /// One round; returns the remaining pieces.
    static std::vector<Piece> fill_round(const Mesh& mesh, double spacing, std::uint64_t seed, std::uint64_t used,
                                         std::vector<Piece> pieces, SiteGrid& grid,
                                         const difusa::Execution& execution) {
        constexpr std::size_t grain = 128;
        const double smallest = smallest_piece(mesh, spacing);
        std::vector<Left> left((pieces.size() + grain - 1) / grain);
        parallel_for(pieces.size(), grain, part_of(execution), [&](std::size_t begin, std::size_t end, unsigned) {
            std::vector<Piece> stack;
            for (std::size_t i = begin; i < end; ++i) {
                RandomStream stream(seed, "gaps", used + i);
                examine(mesh, spacing, smallest, pieces[i], stream, grid, stack, left[begin / grain]);
            }
        });
        std::vector<Dart> darts;
        pieces.clear();
        for (Left& part : left) {
            darts.insert(darts.end(), part.darts.begin(), part.darts.end());
            pieces.insert(pieces.end(), part.pieces.begin(), part.pieces.end());
            part = {};
        }
        grid.insert(darts, execution);
        return pieces;
    }

    static void examine(const Mesh& mesh, double spacing, double smallest, const Piece& given, RandomStream& stream,
                        const SiteGrid& grid, std::vector<Piece>& stack, Left& left) {
        stack.assign(1, given);
        while (!stack.empty()) {
            const Piece piece = stack.back();
            stack.pop_back();
            const std::array<Vec3, 3> corners = places(mesh, piece);
            const LongestEdge longest(corners, smallest);
            const auto [a, b] = halves(piece, longest);
            if (longest.squared > spacing * spacing) { // rarely covered by a single site
                stack.push_back(b);
                stack.push_back(a);
                continue;
            }
            if (grid.covers(piece.face, corners)) {
                continue;
            }
            const SurfacePoint x = dart(mesh, piece, stream);
            if (!grid.conflicts(x)) {
                left.darts.push_back({x, stream.bits()});
            }
            // A piece of minimum size is done: its dart becomes a site, or is within D of one, and the rest of it is
            // within D 2^-20 of the dart.
            if (longest.squared > smallest * smallest) {
                left.pieces.push_back(a);
                left.pieces.push_back(b);
            }
        }
    }
};

} // namespace

DIFUSA_PLUGIN(sampler, "poisson-disk", PoissonDisk, "Maximal Poisson-disk sampling: blue noise without gaps.", {})
