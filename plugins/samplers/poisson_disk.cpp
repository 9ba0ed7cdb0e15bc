// Sampler `poisson-disk`: maximal Poisson-disk sampling of the surface under the site distance of T 4.1. No two sites
// are closer than the spacing D, and no surface point is farther than D (1 + 2^-20) from its nearest site: every face
// region, wall side and small object has sites, whatever the shape of the triangles.
//
// First darts are thrown evenly over the area. What they leave is hunted down: every triangle is a piece; a piece that
// one site covers wholly is done; into any other a dart is thrown, and if the piece is still not covered it is halved
// at its longest edge and both halves wait for the next round.
#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/discretisation/sampler.h>
#include <difusa/discretisation/site_grid.h>
#include <difusa/plugin/plugin.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace {

using difusa::Index;
using difusa::Mesh;
using difusa::SiteGrid;
using difusa::SurfacePoint;
using difusa::Vec3;

/// A part of a triangle, its corners in the triangle's barycentric coordinates (u, v).
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
SurfacePoint dart(const Mesh& mesh, const Piece& piece, difusa::RandomStream& stream) {
    const double root = std::sqrt(stream.uniform()), part = stream.uniform();
    const Eigen::Vector2d uv =
        (1.0 - root) * piece.corner[0] + root * (1.0 - part) * piece.corner[1] + root * part * piece.corner[2];
    return mesh.at(piece.face, uv[0], uv[1]);
}

std::size_t longest_edge(const std::array<Vec3, 3>& p, double& squared) {
    std::size_t longest = 0;
    squared = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double length = (p[(k + 1) % 3] - p[k]).squaredNorm();
        if (length > squared) {
            squared = length;
            longest = k;
        }
    }
    return longest;
}

class PoissonDisk final : public difusa::Sampler {
  public:
    explicit PoissonDisk(const difusa::Parameters& /*parameters*/) {}

    std::vector<SurfacePoint> sample(const Mesh& mesh, const difusa::Visibility* /*visibility*/, double spacing,
                                     std::size_t limit, difusa::RandomStream stream,
                                     const difusa::Execution& execution) const override {
        // No site covers more than a disc: so many are needed at least.
        const double least = mesh.area / (std::numbers::pi * spacing * spacing);
        if (least > static_cast<double>(limit)) {
            throw difusa::ResourceError("at least " + difusa::text_of(least) + " sites are needed at spacing " +
                                        difusa::text_of(spacing) + ", and at most " + std::to_string(limit) +
                                        " can be held; give a larger --spacing");
        }
        SiteGrid grid(mesh, spacing);
        const auto accept = [&](const SurfacePoint& x) {
            if (grid.sites().size() == limit) {
                throw difusa::ResourceError("more than " + std::to_string(limit) + " sites are needed at spacing " +
                                            difusa::text_of(spacing) + "; give a larger --spacing");
            }
            grid.insert(x);
        };
        throw_darts(mesh, spacing, limit, stream, grid, accept, execution);
        fill_gaps(mesh, spacing, stream, grid, accept, execution);
        return grid.take();
    }

  private:
    template <class Accept>
    static void throw_darts(const Mesh& mesh, double spacing, std::size_t limit, difusa::RandomStream& stream,
                            const SiteGrid& grid, const Accept& accept, const difusa::Execution& execution) {
        std::vector<double> below(mesh.areas.size()); // area of the triangles up to and with this one
        double sum = 0.0;
        for (std::size_t t = 0; t < mesh.areas.size(); ++t) {
            sum += mesh.areas[t];
            below[t] = sum;
        }
        // Twice as many as a dense packing of discs of diameter D holds: beyond that most darts miss.
        const auto darts =
            static_cast<std::size_t>(std::min(2.0 * sum / (spacing * spacing) + 1.0, 4.0 * static_cast<double>(limit)));
        for (std::size_t i = 0; i < darts; ++i) {
            if (i % 4096 == 0 && execution.progress != nullptr) {
                execution.progress->check();
            }
            const auto place = std::upper_bound(below.begin(), below.end(), stream.uniform() * sum);
            const auto face = static_cast<Index>(
                std::min<std::ptrdiff_t>(place - below.begin(), static_cast<std::ptrdiff_t>(below.size()) - 1));
            const Piece whole{face, {Eigen::Vector2d(0, 0), Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 1)}};
            const SurfacePoint x = dart(mesh, whole, stream);
            if (!grid.conflicts(x)) {
                accept(x);
            }
        }
    }

    template <class Accept>
    static void fill_gaps(const Mesh& mesh, double spacing, difusa::RandomStream& stream, const SiteGrid& grid,
                          const Accept& accept, const difusa::Execution& execution) {
        std::vector<Piece> pieces, halves;
        pieces.reserve(mesh.triangles.size());
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            pieces.push_back({t, {Eigen::Vector2d(0, 0), Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 1)}});
        }
        const double smallest = spacing * 0x1p-20;
        while (!pieces.empty()) {
            for (std::size_t i = pieces.size(); i > 1; --i) {
                std::swap(pieces[i - 1], pieces[stream.below(i)]);
            }
            halves.clear();
            for (std::size_t i = 0; i < pieces.size(); ++i) {
                if (i % 4096 == 0 && execution.progress != nullptr) {
                    execution.progress->check();
                }
                const Piece& piece = pieces[i];
                const std::array<Vec3, 3> corners = places(mesh, piece);
                if (grid.covers(piece.face, corners)) {
                    continue;
                }
                const SurfacePoint x = dart(mesh, piece, stream);
                if (!grid.conflicts(x)) {
                    accept(x);
                    if (grid.covers(piece.face, corners)) {
                        continue;
                    }
                }
                double squared = 0.0;
                const std::size_t k = longest_edge(corners, squared);
                if (squared <= smallest * smallest) {
                    continue; // its dart is a site, or within D of one, and the rest of it within D 2^-20 of the dart
                }
                const Eigen::Vector2d &p = piece.corner[k], &q = piece.corner[(k + 1) % 3],
                                      &r = piece.corner[(k + 2) % 3], middle = 0.5 * (p + q);
                halves.push_back({piece.face, {middle, q, r}});
                halves.push_back({piece.face, {middle, r, p}});
            }
            pieces.swap(halves);
        }
    }
};

} // namespace

DIFUSA_PLUGIN(sampler, "poisson-disk", PoissonDisk, "Maximal Poisson-disk sampling: blue noise that leaves no gap.", {})
