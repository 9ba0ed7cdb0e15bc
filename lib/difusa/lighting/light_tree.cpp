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

double angle_between(const Vec3& a, const Vec3& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
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
    for (Index i = first; i < last; ++i) {
        const Index t = triangles[order_[i]];
        for (int k = 0; k < 3; ++k) {
            node.radius = std::max(node.radius, (mesh.corner(t, k) - node.centre).norm());
        }
        node.spread = std::max(node.spread, angle_between(node.axis, mesh.normals[t]));
    }
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
    // Half the angle under which x sees the ball; a margin for rounding, so that 0 really means 0.
    const double half = std::asin(node.radius / distance) + 1e-6;
    const double below = angle_between(n, way) - half;                         // smallest angle to the normal of x
    const double beside = angle_between(node.axis, -way) - half - node.spread; // and to the normals of the lights
    if (below >= 0.5 * std::numbers::pi || beside >= 0.5 * std::numbers::pi) {
        return 0.0;
    }
    return node.power * std::cos(std::max(0.0, below)) * std::cos(std::max(0.0, beside)) / (distance * distance);
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
