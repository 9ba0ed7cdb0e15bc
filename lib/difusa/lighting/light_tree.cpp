#include <difusa/lighting/light_tree.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace difusa {

namespace {

Vec3 centroid(const Mesh& mesh, Index t) {
    return (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3.0;
}

double angle_of_normals(const Vec3& a, const Vec3& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// A margin for rounding of cosines, so that 0 really means 0.
constexpr double margin = 1e-6;

double sine_of(double cosine) {
    return std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
}

/// An upper bound of cos(max(0, a - b)) for angles 0 <= a, b <= pi that have these cosines, and b this sine; 0 only if
/// a - b is at least a right angle.
double cosine_beyond(double cos_a, double cos_b, double sin_b) {
    return cos_a >= cos_b ? 1.0 : std::clamp(cos_a * cos_b + sine_of(cos_a) * sin_b + margin, 0.0, 1.0);
}

} // namespace

LightTree::LightTree(const Mesh& mesh, std::span<const Index> triangles, std::span<const double> power)
    : order_(triangles.size()) {
    DIFUSA_REQUIRE(!triangles.empty() && triangles.size() == power.size());
    std::iota(order_.begin(), order_.end(), Index{0});
    nodes_.reserve(2 * triangles.size());
    build(mesh, triangles, power, 0, static_cast<Index>(triangles.size()));
}

Index LightTree::build(const Mesh& mesh, std::span<const Index> triangles, std::span<const double> power, Index first,
                       Index last) {
    const auto number = static_cast<Index>(nodes_.size());
    nodes_.emplace_back();
    Node node;
    node.first = first;
    node.last = last;
    Eigen::AlignedBox3d box, centres;
    for (Index i = first; i < last; ++i) {
        const Index t = triangles[order_[i]];
        box.extend(mesh.box(t));
        centres.extend(centroid(mesh, t));
        node.axis += power[order_[i]] * mesh.normals[t];
        node.power += power[order_[i]];
    }
    node.centre = box.center();
    node.axis =
        node.axis.norm() > 1e-3 * node.power ? Vec3(node.axis.normalized()) : mesh.normals[triangles[order_[first]]];
    double spread = 0.0;
    for (Index i = first; i < last; ++i) {
        const Index t = triangles[order_[i]];
        for (int k = 0; k < 3; ++k) {
            node.radius = std::max(node.radius, (mesh.corner(t, k) - node.centre).norm());
        }
        spread = std::max(spread, angle_of_normals(node.axis, mesh.normals[t]));
    }
    node.cos_spread = std::cos(spread);
    node.sin_spread = std::sin(spread);
    if (last - first > 1) {
        Eigen::Index axis = 0;
        centres.sizes().maxCoeff(&axis);
        const Index middle = first + (last - first) / 2;
        std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last, [&](Index a, Index b) {
            const double at_a = centroid(mesh, triangles[a])[axis], at_b = centroid(mesh, triangles[b])[axis];
            return at_a != at_b ? at_a < at_b : a < b;
        });
        build(mesh, triangles, power, first, middle);
        node.right = build(mesh, triangles, power, middle, last);
    }
    nodes_[number] = node;
    return number;
}

/// An estimate of what x receives from the node; 0 only if nothing.
double LightTree::importance(const Node& node, const Vec3& x, const Vec3& n) const {
    const Vec3 way = node.centre - x;
    const double distance = way.norm();
    if (!(distance > node.radius)) {
        return node.power / std::max(node.radius * node.radius, std::numeric_limits<double>::min());
    }
    // x sees the ball under twice this angle.
    const double sin_half = node.radius / distance, cos_half = sine_of(sin_half);
    const double below = cosine_beyond(n.dot(way) / distance, cos_half, sin_half);
    // The cone of the normals is widened by the same angle; together they may be all directions.
    const double sin_wide = sin_half * node.cos_spread + cos_half * node.sin_spread;
    const double beside = sin_wide <= 0.0
                              ? 1.0
                              : cosine_beyond(-node.axis.dot(way) / distance,
                                              cos_half * node.cos_spread - sin_half * node.sin_spread, sin_wide);
    return node.power * below * beside / (distance * distance);
}

void LightTree::cut(const Vec3& x, const Vec3& n, double opening, std::vector<Index>& nodes) const {
    nodes.clear();
    std::vector<Index> open{root};
    while (!open.empty()) {
        const Index number = open.back();
        const Node& node = nodes_[number];
        open.pop_back();
        if (!(importance(node, x, n) > 0.0)) {
            continue;
        }
        if (node.right == none || 2.0 * node.radius < opening * (node.centre - x).norm()) {
            nodes.push_back(number);
            continue;
        }
        open.push_back(node.right);
        open.push_back(number + 1);
    }
}

void LightTree::represent(const Vec3& x, const Vec3& n, double opening, double count, RandomStream& stream,
                          std::vector<Index>& scratch, std::vector<Part>& parts,
                          std::vector<Representative>& chosen) const {
    chosen.clear();
    parts.clear();
    cut(x, n, opening, scratch);
    double all = 0.0;
    for (const Index number : scratch) {
        parts.push_back({number, 0.0, importance(nodes_[number], x, n)});
        all += parts.back().end;
    }
    double end = 0.0;
    for (Part& part : parts) {
        part.begin = end;
        end += std::max(1.0, count * (part.end / all));
        part.end = end;
    }
    const double shift = stream.uniform(); // picks are at shift, shift + 1, ...
    while (!parts.empty()) {
        const auto [number, begin, last] = parts.back();
        parts.pop_back();
        const Node& node = nodes_[number];
        const double picks = last - begin; // in the mean
        if (picks >= static_cast<double>(node.last - node.first)) {
            for (Index i = node.first; i < node.last; ++i) {
                chosen.push_back({order_[i], 1.0});
            }
            continue;
        }
        if (!(std::ceil(last - shift) > std::ceil(begin - shift))) {
            continue;
        }
        if (node.right == none) {
            chosen.push_back({order_[node.first], 1.0 / picks});
            continue;
        }
        const double left = importance(nodes_[number + 1], x, n), right = importance(nodes_[node.right], x, n);
        if (left + right > 0.0) {
            const double middle = begin + picks * (left / (left + right));
            parts.push_back({node.right, middle, last});
            parts.push_back({number + 1, begin, middle});
        }
    }
}

std::optional<LightTree::Pick> LightTree::pick(Index number, const Vec3& x, const Vec3& n, double u) const {
    double probability = 1.0;
    while (nodes_[number].right != none) {
        const double left = importance(nodes_[number + 1], x, n),
                     right = importance(nodes_[nodes_[number].right], x, n);
        if (!(left + right > 0.0)) {
            return std::nullopt;
        }
        const double part = left / (left + right);
        if (u < part) {
            u /= part;
            probability *= part;
            number += 1;
        } else {
            u = (u - part) / (1.0 - part);
            probability *= 1.0 - part;
            number = nodes_[number].right;
        }
        u = std::min(u, 0x1.fffffffffffffp-1);
    }
    return Pick{order_[nodes_[number].first], probability};
}

} // namespace difusa
