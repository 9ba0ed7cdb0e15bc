#include <difusa/discretisation/subdivision.h>

#include <difusa/algebra/dense.h>
#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/mesh/point_tree.h>

#include <map>
#include <queue>
#include <utility>

namespace difusa {

namespace {

constexpr std::size_t neighbours = 8; ///< of a site, that its gradient is fitted to
constexpr std::size_t gradients_at_once = 64;

/// Two unit vectors along a plane.
std::pair<Vec3, Vec3> along(const Vec3& normal) {
    const Vec3 s = normal.unitOrthogonal();
    return {s, normal.cross(s)};
}

} // namespace

double mean_square_variation(const std::array<Vec3, 3>& corners, const Vec3& gradient) {
    const Vec3 centre = (corners[0] + corners[1] + corners[2]) / 3.0;
    double sum = 0.0;
    for (const Vec3& corner : corners) {
        const double off = gradient.dot(corner - centre);
        sum += off * off;
    }
    return sum / 12.0;
}

Values gradients_at(const SiteSet& sites, const Values& values, const Execution& execution) {
    const Eigen::Index columns = values.cols();
    DIFUSA_REQUIRE(values.rows() >= static_cast<Eigen::Index>(sites.size()));
    std::map<Index, std::vector<Index>> members;
    for (Index i = 0; i < sites.size(); ++i) {
        members[sites.region[i]].push_back(i);
    }
    std::map<Index, PointTree> trees;
    for (auto& [region, own] : members) {
        trees.emplace(region, PointTree(sites.points, std::move(own)));
    }
    Values gradients = Values::Zero(static_cast<Eigen::Index>(sites.size()), 3 * columns);
    parallel_for(
        sites.size(), gradients_at_once, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
            std::array<Index, neighbours + 1> found{};
            std::array<double, neighbours + 1> squared{};
            for (std::size_t i = begin; i < end; ++i) {
                const SurfacePoint& x = sites.points[i];
                const auto [s, t] = along(x.normal);
                const std::size_t count = trees.at(sites.region[i]).nearest(x.position, found, squared);
                Eigen::MatrixXd steps(static_cast<Eigen::Index>(count), 2);
                Eigen::MatrixXd changes(static_cast<Eigen::Index>(count), columns);
                Eigen::Index rows = 0;
                for (std::size_t k = 0; k < count; ++k) {
                    const SurfacePoint& y = sites.points[found[k]];
                    const Vec3 step = y.position - x.position;
                    const double length = step.norm();
                    if (found[k] == i || !(length > 0.0) || !(x.normal.dot(y.normal) > 0.0)) {
                        continue;
                    }
                    steps.row(rows) = Eigen::RowVector2d(step.dot(s), step.dot(t)) / length;
                    changes.row(rows++) =
                        (values.row(static_cast<Eigen::Index>(found[k])) - values.row(static_cast<Eigen::Index>(i))) /
                        length;
                }
                if (rows == 0) {
                    continue;
                }
                const Eigen::MatrixXd fit = least_squares(
                    steps.topRows(rows), changes.topRows(rows)); // of least norm where the sites are in a line
                for (Eigen::Index c = 0; c < columns; ++c) {
                    gradients.row(static_cast<Eigen::Index>(i)).segment<3>(3 * c) =
                        (fit(0, c) * s + fit(1, c) * t).transpose();
                }
            }
        });
    return gradients;
}

std::vector<double> squared_misses(const PatchElements& elements, const SiteSet& sites, const Values& values,
                                   const Execution& execution) {
    const Values gradients = gradients_at(sites, values, execution);
    std::vector<double> miss(sites.size(), 0.0);
    for (const Index node : elements.elements()) {
        const Index site = elements.site(node);
        if (site == none) {
            continue;
        }
        const std::array<Vec3, 3> corners = elements.corners(node);
        for (Eigen::Index c = 0; c < values.cols(); ++c) {
            const Vec3 gradient = gradients.row(static_cast<Eigen::Index>(site)).segment<3>(3 * c).transpose();
            miss[site] += elements.area(node) * mean_square_variation(corners, gradient);
        }
    }
    return miss;
}

void quarter_worst(PatchElements& elements, const std::vector<double>& miss, const SubdivisionLimits& limits) {
    constexpr double share_of_quarter = 1.0 / 16.0;
    struct Candidate {
        double miss;
        Index node;
        bool operator<(const Candidate& other) const { // true if the other goes first
            return miss != other.miss ? miss < other.miss : node > other.node;
        }
    };
    std::priority_queue<Candidate> candidates;
    const auto consider = [&](double missed, Index node) {
        if (elements.level(node) < limits.levels && missed > limits.least * elements.area(node)) {
            candidates.push({missed, node});
        }
    };
    for (const Index node : elements.elements()) {
        if (elements.site(node) != none) {
            consider(miss[elements.site(node)], node);
        }
    }
    while (!candidates.empty() && elements.element_count() + 3 <= limits.elements) {
        const Candidate worst = candidates.top();
        candidates.pop();
        const Index first = elements.quarter(worst.node);
        for (Index k = 0; k < 4; ++k) {
            consider(share_of_quarter * worst.miss, first + k);
        }
    }
}

} // namespace difusa
