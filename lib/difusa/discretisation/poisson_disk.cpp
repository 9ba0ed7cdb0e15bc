#include <difusa/discretisation/poisson_disk.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/core/text.h>
#include <difusa/discretisation/site_grid.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace difusa {

namespace {

/// Part of a triangle, its corners in the triangle's barycentric coordinates (u, v).
struct Piece {
    Index face;
    std::array<Eigen::Vector2d, 3> corner;
    bool fine = false; ///< all of it is known to be in the part of the surface that is filled
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
    return {Piece{piece.face, {middle, q, r}, piece.fine}, Piece{piece.face, {middle, r, p}, piece.fine}};
}

/// The same at its longest edge. A thin piece is its longest edge, as good as: halved as a triangle, a needle n times
/// as long as the pieces wanted would become n^1.6 of them, side by side.
std::array<Piece, 2> halves(const Piece& piece, const LongestEdge& longest) {
    if (!longest.thin) {
        return halves(piece, longest.k);
    }
    const Eigen::Vector2d &p = piece.corner[longest.k], &q = piece.corner[(longest.k + 1) % 3], middle = 0.5 * (p + q);
    return {Piece{piece.face, {middle, q, q}, piece.fine}, Piece{piece.face, {middle, p, p}, piece.fine}};
}

Piece whole(Index face) {
    return {face, {Eigen::Vector2d(0, 0), Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 1)}};
}

/// Pieces this small, or thin, need no more attention: their points are as good as one. The edges of pieces no larger
/// than a step of the coordinates are rounding errors.
double smallest_piece(const Mesh& mesh, double spacing) {
    return std::max(spacing * 0x1p-20, 4.0 * coordinate_step(mesh));
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
Execution part_of(const Execution& execution) {
    if (execution.progress != nullptr) {
        execution.progress->check();
    }
    return execution.silent();
}

void throw_darts(const Mesh& mesh, double spacing, std::uint64_t seed, SiteGrid& grid, const Execution& execution) {
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

/// The part of the surface where the wanted spacing is below a limit.
struct FinePart {
    const SizeField& size;
    double below;

    /// False only if no point of the piece, a triangle with these corners and longest edge, is in it; or if its centre
    /// is not, for edges of at most a quarter of the spacing, when all of the piece is within a sixth of it from there.
    /// Marks pieces of which all points are in it.
    bool may_meet(const Mesh& mesh, Piece& piece, const std::array<Vec3, 3>& corners, double longest,
                  double spacing) const {
        if (piece.fine) {
            return true;
        }
        const double farthest = 2.0 / 3.0 * longest; // from the centre: two thirds of a median, at most
        const double limit = longest > 0.25 * spacing ? below + SizeField::slope * farthest : below;
        const double at_most =
            size.bound_below(limit, (corners[0] + corners[1] + corners[2]) / 3.0, mesh.region[piece.face]);
        piece.fine = at_most + SizeField::slope * farthest < below;
        return at_most < limit;
    }
};

/// Adds sites to a grid until none of its mesh, or of a part of it, is farther than the spacing from its nearest site.
class GapFilling {
  public:
    /// `part`: null for the whole mesh.
    GapFilling(const Mesh& mesh, double spacing, std::uint64_t seed, const FinePart* part, SiteGrid& grid,
               const Execution& execution)
        : mesh_(mesh), spacing_(spacing), smallest_(smallest_piece(mesh, spacing)), seed_(seed), part_(part),
          grid_(grid), execution_(execution) {}

    void run() {
        // Triangles are divided and filled in batches, which bounds the memory for pieces.
        constexpr std::size_t lot = std::size_t{1} << 16U;
        const double coarse = 4.0 * spacing_;
        std::vector<Piece> pieces, stack;
        Index next = 0;
        while (next < mesh_.triangles.size() || !stack.empty()) {
            pieces.clear();
            while (pieces.size() < lot && (next < mesh_.triangles.size() || !stack.empty())) {
                if (stack.empty()) {
                    stack.push_back(whole(next++));
                }
                Piece piece = stack.back();
                stack.pop_back();
                const std::array<Vec3, 3> corners = places(mesh_, piece);
                const LongestEdge longest(corners, smallest_);
                if (!is_wanted(piece, corners, longest)) {
                    continue;
                }
                if (longest.squared <= coarse * coarse) {
                    pieces.push_back(piece);
                } else {
                    const auto [a, b] = halves(piece, longest);
                    stack.push_back(b);
                    stack.push_back(a);
                }
            }
            while (!pieces.empty()) {
                pieces = fill_round(std::move(pieces));
            }
            if (execution_.progress != nullptr) {
                execution_.progress->advance(static_cast<double>(next) / static_cast<double>(mesh_.triangles.size()));
            }
        }
    }

  private:
    /// The output of part of a round: darts not close to a site of earlier rounds, and the halves of the pieces.
    struct Left {
        std::vector<Dart> darts;
        std::vector<Piece> pieces;
    };

    bool is_wanted(Piece& piece, const std::array<Vec3, 3>& corners, const LongestEdge& longest) const {
        return part_ == nullptr || part_->may_meet(mesh_, piece, corners, std::sqrt(longest.squared), spacing_);
    }

    /// One round; returns the remaining pieces.
    std::vector<Piece> fill_round(std::vector<Piece> pieces) {
        constexpr std::size_t grain = 128;
        std::vector<Left> left((pieces.size() + grain - 1) / grain);
        parallel_for(pieces.size(), grain, part_of(execution_), [&](std::size_t begin, std::size_t end, unsigned) {
            std::vector<Piece> stack;
            for (std::size_t i = begin; i < end; ++i) {
                RandomStream stream(seed_, "gaps", used_ + i);
                examine(pieces[i], stream, stack, left[begin / grain]);
            }
        });
        used_ += pieces.size();
        std::vector<Dart> darts;
        pieces.clear();
        for (Left& part : left) {
            darts.insert(darts.end(), part.darts.begin(), part.darts.end());
            pieces.insert(pieces.end(), part.pieces.begin(), part.pieces.end());
            part = {};
        }
        grid_.insert(darts, execution_);
        return pieces;
    }

    void examine(const Piece& given, RandomStream& stream, std::vector<Piece>& stack, Left& left) const {
        stack.assign(1, given);
        while (!stack.empty()) {
            Piece piece = stack.back();
            stack.pop_back();
            const std::array<Vec3, 3> corners = places(mesh_, piece);
            const LongestEdge longest(corners, smallest_);
            const bool large = longest.squared > spacing_ * spacing_; // rarely covered by a single site
            if ((!large && grid_.covers(piece.face, corners)) || !is_wanted(piece, corners, longest)) {
                continue;
            }
            const auto [a, b] = halves(piece, longest);
            if (large) {
                stack.push_back(b);
                stack.push_back(a);
                continue;
            }
            const SurfacePoint x = dart(mesh_, piece, stream);
            if (!grid_.conflicts(x)) {
                left.darts.push_back({x, stream.bits()});
            }
            // A piece of minimum size is done: its dart becomes a site, or is within D of one, and the rest of it is
            // within D 2^-20 of the dart.
            if (longest.squared > smallest_ * smallest_) {
                left.pieces.push_back(a);
                left.pieces.push_back(b);
            }
        }
    }

    const Mesh& mesh_;
    double spacing_, smallest_;
    std::uint64_t seed_;
    const FinePart* part_;
    SiteGrid& grid_;
    const Execution& execution_;
    std::uint64_t used_ = 0; ///< random streams
};

} // namespace

std::vector<SurfacePoint> poisson_disk(const Mesh& mesh, double spacing, std::size_t limit, RandomStream stream,
                                       const Execution& execution) {
    // No site covers more than a disc: this gives a lower bound on their number.
    const double least = mesh.area / (std::numbers::pi * spacing * spacing);
    if (least > static_cast<double>(limit)) {
        throw ResourceError("at least " + text_of(least) + " sites are needed at spacing " + text_of(spacing) +
                            ", but at most " + std::to_string(limit) + " fit; give a larger --spacing");
    }
    SiteGrid grid(mesh, spacing, limit);
    throw_darts(mesh, spacing, stream.bits(), grid, execution);
    GapFilling(mesh, spacing, stream.bits(), nullptr, grid, execution).run();
    return grid.take();
}

std::vector<SurfacePoint> refine_sites(const Mesh& mesh, std::vector<SurfacePoint> sites, const SizeField& size,
                                       std::size_t limit, RandomStream stream, const Execution& execution) {
    std::vector<Dart> placed;
    for (int level = 1; SizeField::spacing_of(size.largest(), level) > size.smallest() / SizeField::rounding; ++level) {
        const double spacing = SizeField::spacing_of(size.largest(), level);
        placed.clear();
        for (const SurfacePoint& site : sites) {
            placed.push_back({site, 0});
        }
        SiteGrid grid(mesh, spacing, limit);
        grid.insert(placed, execution);
        const FinePart part{size, spacing * SizeField::rounding};
        GapFilling(mesh, spacing, stream.bits(), &part, grid, execution).run();
        sites = grid.take();
    }
    return sites;
}

} // namespace difusa
