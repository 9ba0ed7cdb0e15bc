#include <difusa/form_factors/pair_exchange.h>

#include <algorithm>

namespace difusa {

namespace {

/// Exact integrals are computed to this share of the tolerance: it costs little.
constexpr double clear_share = 1e-3;

} // namespace

std::vector<PolygonEnd> ends_of(const Mesh& mesh) {
    std::vector<PolygonEnd> ends;
    ends.reserve(mesh.triangles.size());
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        FlatPolygon triangle;
        for (int k = 0; k < 3; ++k) {
            triangle.add(mesh.corner(t, k));
        }
        ends.emplace_back(triangle, mesh.normals[t]);
    }
    return ends;
}

PlaneSide side_of(const Plane& plane, std::span<const Vec3> points, double rounding) {
    double low = plane.height(points[0]), high = low;
    for (const Vec3& p : points.subspan(1)) {
        low = std::min(low, plane.height(p));
        high = std::max(high, plane.height(p));
    }
    return high <= rounding ? PlaneSide::behind : low >= -rounding ? PlaneSide::in_front : PlaneSide::across;
}

bool PairExchange::narrow(std::span<const Vec3> from, std::span<const Vec3> to, std::size_t first, std::size_t last) {
    if (first == last) {
        return true;
    }
    Vec3 low = from[0], high = from[0];
    for (const std::span<const Vec3> points : {from, to}) {
        for (const Vec3& p : points) {
            low = low.cwiseMin(p);
            high = high.cwiseMax(p);
        }
    }
    for (std::size_t k = first; k < last; ++k) {
        const Obstacle* const obstacle = between[k];
        if ((obstacle->low().array() > high.array()).any() || (obstacle->high().array() < low.array()).any()) {
            continue;
        }
        const Obstruction what = obstruction(*obstacle, from, to, rounding_);
        if (what == Obstruction::complete) {
            return false;
        }
        if (what == Obstruction::partial) {
            between.push_back(obstacle);
        }
    }
    return true;
}

Estimate PairExchange::of(Index p, Index q, std::size_t first, std::size_t last, double allowed) {
    execution_.check();
    const PolygonEnd *P = &ends_[p], *Q = &ends_[q];
    const PlaneSide of_P = side_of(Q->plane, P->polygon.corners(), rounding_),
                    of_Q = side_of(P->plane, Q->polygon.corners(), rounding_);
    if (of_P == PlaneSide::behind || of_Q == PlaneSide::behind) {
        return {};
    }
    if (of_P == PlaneSide::across) {
        cut_p_ = PolygonEnd(P->polygon.above(Q->plane, rounding_), P->plane.normal);
    }
    if (of_Q == PlaneSide::across) {
        cut_q_ = PolygonEnd(Q->polygon.above(P->plane, rounding_), Q->plane.normal);
    }
    P = of_P == PlaneSide::across ? &cut_p_ : P;
    Q = of_Q == PlaneSide::across ? &cut_q_ : Q;
    if (P->polygon.empty() || Q->polygon.empty()) {
        return {};
    }
    const std::size_t start = between.size();
    for (std::size_t k = first; k < last; ++k) {
        const Obstacle* const obstacle = between[k];
        if (obstacle->rises_above(P->plane, rounding_) && obstacle->rises_above(Q->plane, rounding_)) {
            between.push_back(obstacle);
        }
    }
    const std::size_t before = between.size();
    Estimate exchange;
    if (!narrow(P->polygon.corners(), Q->polygon.corners(), start, before)) {
        ++counts.hidden;
    } else if (between.size() == before) {
        ++counts.clear;
        exchange = unblocked_exchange(*P, *Q, clear_share * allowed);
    } else {
        ++counts.partial;
        const std::span<const Obstacle* const> obstacles(between.data() + before, between.size() - before);
        exchange = blocked_exchange(*P, *Q, obstacles, rounding_, allowed, view_, execution_);
    }
    between.resize(start);
    return exchange;
}

} // namespace difusa
