#include <difusa/rays/visible_part.h>

#include <algorithm>
#include <utility>

namespace difusa {

namespace {

constexpr double shortest = 0x1p-40; ///< side, relative to its distance

} // namespace

SpatialPolygon::SpatialPolygon(std::span<const Vec3> corners)
    : count(std::min(corners.size(), most)), is_cut_short(corners.size() > most) {
    std::copy_n(corners.begin(), count, corner.begin());
}

SpatialPolygon SpatialPolygon::cut(const Vec3& normal, double offset) const {
    SpatialPolygon kept;
    kept.is_cut_short = is_cut_short;
    const auto add = [&](const Vec3& p) {
        if (kept.count < most) {
            kept.corner[kept.count++] = p;
        } else {
            kept.is_cut_short = true;
        }
    };
    for (std::size_t k = 0; k < count; ++k) {
        const Vec3 &p = corner[k], &q = corner[k + 1 < count ? k + 1 : 0];
        const double at_p = normal.dot(p) - offset, at_q = normal.dot(q) - offset;
        if (at_p >= 0.0) {
            add(p);
        }
        if ((at_p < 0.0 && at_q > 0.0) || (at_p > 0.0 && at_q < 0.0)) {
            add(p + at_p / (at_p - at_q) * (q - p));
        }
    }
    if (kept.count < 3) {
        kept.count = 0;
    }
    return kept;
}

bool subtract_shadow(const Vec3& x, const std::array<Vec3, 3>& triangle, const std::array<ClipPlane, 2>& within,
                     std::size_t most, std::vector<SpatialPolygon>& parts) {
    SpatialPolygon blocker(triangle);
    for (const ClipPlane& side : within) {
        blocker = blocker.cut(side.normal, side.offset);
    }
    if (blocker.count < 3) {
        return true;
    }
    // Planes through x and the sides, of which the inner half spaces bound what is hidden.
    Vec3 middle = Vec3::Zero();
    for (const Vec3& p : blocker.corners()) {
        middle += (p - x) / static_cast<double>(blocker.count);
    }
    std::vector<ClipPlane> inner;
    for (std::size_t k = 0; k < blocker.count; ++k) {
        const Vec3 p = blocker.corner[k] - x, q = blocker.corner[k + 1 < blocker.count ? k + 1 : 0] - x;
        Vec3 normal = (q - p).cross(p);
        const double length = normal.norm();
        if ((q - p).norm() > shortest * p.norm()) { // otherwise the direction of the side is lost to rounding
            normal *= normal.dot(middle) < 0.0 ? -1.0 / length : 1.0 / length;
            inner.push_back({normal, normal.dot(x)});
        }
    }
    std::vector<SpatialPolygon> left;
    for (const SpatialPolygon& part : parts) {
        SpatialPolygon hidden = part;
        for (const ClipPlane& side : inner) {
            hidden = hidden.cut(side.normal, side.offset);
        }
        if (hidden.count < 3) {
            left.push_back(part);
            continue;
        }
        SpatialPolygon rest = part;
        for (const ClipPlane& side : inner) {
            const SpatialPolygon outside = rest.cut(-side.normal, -side.offset);
            if (outside.count >= 3) {
                left.push_back(outside);
            }
            rest = rest.cut(side.normal, side.offset);
        }
        const bool is_cut_short =
            hidden.is_cut_short || rest.is_cut_short ||
            std::any_of(left.begin(), left.end(), [](const SpatialPolygon& each) { return each.is_cut_short; });
        if (left.size() > most || is_cut_short) {
            return false;
        }
    }
    parts = std::move(left);
    return true;
}

} // namespace difusa
