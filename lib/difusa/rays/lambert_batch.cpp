// Compiled with -fno-math-errno -fno-trapping-math, so that the loops over lanes become vectors.
#include <difusa/rays/lambert_batch.h>

#include <difusa/algebra/wide_vectors.h>
#include <difusa/core/angle.h>
#include <difusa/core/error.h>
#include <difusa/rays/lambert.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace difusa {

namespace {

using Block = LambertBatch::Block;
constexpr std::size_t lanes = LambertBatch::lanes;

/// What a surface element sees of the triangles of a block.
struct BlockInView {
    double front[lanes];        ///< negative: seen from the front
    double lowest[lanes];       ///< height above the horizon of the lowest corner
    double highest[lanes];      ///< of the highest one
    double sum[lanes];          ///< over the edges, if all of the triangle is above the horizon
    double corner[3][3][lanes]; ///< as in Block, relative to the element
};

/// The term of an edge in the sum of rays/lambert.h, times 2 pi.
inline double edge_term(double nx, double ny, double nz, double fx, double fy, double fz, double tx, double ty,
                        double tz) {
    const double ex = tx - fx, ey = ty - fy, ez = tz - fz;
    const double cx = ey * fz - ez * fy, cy = ez * fx - ex * fz, cz = ex * fy - ey * fx; // lambert_edge tells why
    const double length = std::sqrt(cx * cx + cy * cy + cz * cz);
    const double angle = angle_between(length, fx * tx + fy * ty + fz * tz);
    const double term = angle * (nx * cx + ny * cy + nz * cz) / length;
    return length > 0.0 ? term : 0.0;
}

/// All of a view but its sums.
inline void place(const Block& block, const double* x, const double* n, BlockInView& view) {
    for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t d = 0; d < 3; ++d) {
            for (std::size_t i = 0; i < lanes; ++i) {
                view.corner[k][d][i] = block.corner[k][d][i] - x[d];
            }
        }
    }
    const auto& p = view.corner;
    for (std::size_t i = 0; i < lanes; ++i) {
        view.front[i] =
            p[0][0][i] * block.normal[0][i] + p[0][1][i] * block.normal[1][i] + p[0][2][i] * block.normal[2][i];
        const double a = n[0] * p[0][0][i] + n[1] * p[0][1][i] + n[2] * p[0][2][i];
        const double b = n[0] * p[1][0][i] + n[1] * p[1][1][i] + n[2] * p[1][2][i];
        const double c = n[0] * p[2][0][i] + n[1] * p[2][1][i] + n[2] * p[2][2][i];
        const double low = a < b ? a : b, high = a < b ? b : a;
        view.lowest[i] = low < c ? low : c;
        view.highest[i] = high < c ? c : high;
    }
}

/// Of the first `count` triangles, a constant.
template <std::size_t count> void sum_edges(const double* n, BlockInView& view) {
    const double nx = n[0], ny = n[1], nz = n[2];
    const auto& p = view.corner;
    for (std::size_t i = 0; i < count; ++i) {
        const double ax = p[0][0][i], ay = p[0][1][i], az = p[0][2][i];
        const double bx = p[1][0][i], by = p[1][1][i], bz = p[1][2][i];
        const double cx = p[2][0][i], cy = p[2][1][i], cz = p[2][2][i];
        view.sum[i] = edge_term(nx, ny, nz, ax, ay, az, bx, by, bz) + edge_term(nx, ny, nz, bx, by, bz, cx, cy, cz) +
                      edge_term(nx, ny, nz, cx, cy, cz, ax, ay, az);
    }
}

bool is_seen(const BlockInView& view, std::size_t lane) {
    return view.front[lane] < 0.0 && view.highest[lane] > 0.0;
}

/// The form factor to a triangle of which a part is below the horizon.
double clipped_form_factor(const Block& block, std::size_t lane, const Vec3& x, const Vec3& n) {
    const auto corner = [&](std::size_t k) {
        return Vec3(block.corner[k][0][lane], block.corner[k][1][lane], block.corner[k][2][lane]);
    };
    return lambert_form_factor(x, n, corner(0), corner(1), corner(2));
}

} // namespace

LambertBatch::LambertBatch(const Mesh& mesh, std::span<const Index> triangles)
    : size_(triangles.size()), blocks_((triangles.size() + lanes - 1) / lanes) {
    for (std::size_t t = 0; t < size_; ++t) {
        Block& block = blocks_[t / lanes];
        const auto corners = mesh.corners(triangles[t]);
        const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        for (Eigen::Index d = 0; d < 3; ++d) {
            for (std::size_t k = 0; k < 3; ++k) {
                block.corner[k][d][t % lanes] = corners[k][d];
            }
            block.normal[d][t % lanes] = normal[d];
        }
    }
}

void LambertBatch::form_factors(const Vec3& x, const Vec3& n, std::span<double> F) const {
    DIFUSA_REQUIRE(F.size() == size_);
    BlockInView view;
    for (std::size_t first = 0; first < size_; first += lanes) {
        const Block& block = blocks_[first / lanes];
        const std::size_t count = std::min(lanes, size_ - first);
        bool any = false;
        with_wide_vectors([&] {
            place(block, x.data(), n.data(), view);
            for (std::size_t i = 0; i < count; ++i) {
                any = any || (is_seen(view, i) && view.lowest[i] >= 0.0);
            }
            if (any && count <= lanes / 2) {
                sum_edges<lanes / 2>(n.data(), view);
            } else if (any) {
                sum_edges<lanes>(n.data(), view);
            }
        });
        for (std::size_t i = 0; i < count; ++i) {
            F[first + i] = !is_seen(view, i)      ? 0.0
                           : view.lowest[i] < 0.0 ? clipped_form_factor(block, i, x, n)
                                                  : std::max(0.0, view.sum[i] / (2.0 * std::numbers::pi));
        }
    }
}

} // namespace difusa
