#include <difusa/discretisation/patch_elements.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace difusa {

namespace {

constexpr double centre_rounding = 1e-6; ///< in barycentric coordinates, of sites that went through a file

std::array<double, 3> middle(const std::array<double, 3>& a, const std::array<double, 3>& b) {
    return {0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])};
}

} // namespace

PatchElements::PatchElements(const PatchMesh& patches) : patches_(&patches), elements_(patches.size()) {
    nodes_.resize(patches.size());
    for (Index f = 0; f < nodes_.size(); ++f) {
        nodes_[f].patch = f;
        nodes_[f].corner = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
    }
}

PatchElements::PatchElements(const PatchMesh& patches, std::span<const SurfacePoint> sites) : PatchElements(patches) {
    struct Member {
        Index site;
        Weights weight; ///< in the node
    };
    std::vector<std::vector<Member>> members(patches.size());
    for (Index j = 0; j < sites.size(); ++j) {
        const PatchMesh::Place place = patches.at(sites[j]);
        members[place.patch].push_back({j, place.weight});
    }
    std::vector<std::pair<Index, std::vector<Member>>> open;
    for (Index f = 0; f < patches.size(); ++f) {
        open.emplace_back(f, std::move(members[f]));
        while (!open.empty()) {
            const auto [node, own] = std::move(open.back());
            open.pop_back();
            if (own.size() > 1) {
                if (level(node) == most_levels) {
                    throw UsageError("sites " + std::to_string(own[0].site) + " and " + std::to_string(own[1].site) +
                                     " are at one place");
                }
                const Index first = quarter(node);
                std::array<std::vector<Member>, 4> parts;
                for (Member member : own) {
                    const Index part = quarter_at(nodes_[node], member.weight) - first;
                    parts[part].push_back(member);
                }
                for (Index k = 0; k < 4; ++k) {
                    open.emplace_back(first + k, std::move(parts[k]));
                }
            } else if (own.size() == 1) {
                const Weights& w = own.front().weight;
                const double off =
                    std::max({std::abs(w[0] - 1.0 / 3.0), std::abs(w[1] - 1.0 / 3.0), std::abs(w[2] - 1.0 / 3.0)});
                if (off > centre_rounding) {
                    throw UsageError("site " + std::to_string(own.front().site) + " is at no element's centre");
                }
                nodes_[node].site = own.front().site;
            }
        }
    }
}

std::vector<Index> PatchElements::elements() const {
    std::vector<Index> all, open;
    all.reserve(elements_);
    for (Index f = 0; f < patches_->size(); ++f) {
        open.push_back(f);
        while (!open.empty()) {
            const Node& node = nodes_[open.back()];
            if (node.first == none) {
                all.push_back(open.back());
                open.pop_back();
                continue;
            }
            open.pop_back();
            for (Index k = 4; k-- > 0;) {
                open.push_back(node.first + k);
            }
        }
    }
    return all;
}

Index PatchElements::quarter_at(const Node& node, Weights& w) {
    for (Index k = 0; k < 3; ++k) {
        if (w[k] >= 0.5) { // x = w'_k v_k + sum of w'_j (v_k + v_j)/2 over the others
            for (Index j = 0; j < 3; ++j) {
                w[j] = j == k ? 2.0 * w[j] - 1.0 : 2.0 * w[j];
            }
            return node.first + k;
        }
    }
    for (double& each : w) { // the corner opposite to v_j is the midpoint of the two others
        each = 1.0 - 2.0 * each;
    }
    return node.first + 3;
}

Index PatchElements::at(const PatchMesh::Place& place) const {
    Index node = place.patch;
    Weights w = place.weight;
    while (nodes_[node].first != none) {
        node = quarter_at(nodes_[node], w);
    }
    return node;
}

double PatchElements::area(Index node) const {
    return std::ldexp(patches_->area(nodes_[node].patch), -2 * nodes_[node].level);
}

SurfacePoint PatchElements::centre(Index node) const {
    const Node& own = nodes_[node];
    if (own.level == 0) {
        return patches_->centre(own.patch);
    }
    Weights mean{};
    for (std::size_t k = 0; k < 3; ++k) {
        mean[k] = (own.corner[0][k] + own.corner[1][k] + own.corner[2][k]) / 3.0;
    }
    return patches_->point(own.patch, mean);
}

std::array<Vec3, 3> PatchElements::corners(Index node) const {
    const Node& own = nodes_[node];
    const std::array<Index, 3>& vertex = patches_->corners(own.patch);
    std::array<Vec3, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) {
        corners[i] = Vec3::Zero();
        for (std::size_t k = 0; k < 3; ++k) {
            corners[i] += own.corner[i][k] * patches_->vertex(vertex[k]).position;
        }
    }
    return corners;
}

Index PatchElements::quarter(Index node) {
    DIFUSA_REQUIRE(nodes_[node].first == none && nodes_[node].level < most_levels);
    const auto first = static_cast<Index>(nodes_.size());
    nodes_[node].first = first;
    nodes_[node].site = none;
    const std::array<Weights, 3> v = nodes_[node].corner;
    const std::array<Weights, 3> opposite{middle(v[1], v[2]), middle(v[2], v[0]), middle(v[0], v[1])};
    Node part;
    part.patch = nodes_[node].patch;
    part.level = nodes_[node].level + 1;
    for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t j = 0; j < 3; ++j) {
            part.corner[j] = j == k ? v[k] : opposite[3 - j - k];
        }
        nodes_.push_back(part);
    }
    part.corner = opposite;
    nodes_.push_back(part);
    elements_ += 3;
    return first;
}

} // namespace difusa
