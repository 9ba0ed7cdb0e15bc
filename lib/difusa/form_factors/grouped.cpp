#include <difusa/form_factors/grouped.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/core/text.h>
#include <difusa/form_factors/blockers.h>
#include <difusa/form_factors/pair_exchange.h>
#include <difusa/form_factors/target_tree.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace difusa {

namespace {

constexpr std::size_t tasks_at_least = 1024;    ///< pairs of groups that are searched apart
constexpr double least_linked_distance = 1.25;  ///< of the centres of linked groups, in sums of their radii
constexpr double group_share = 0.1;             ///< of the tolerance, for the factors between groups
constexpr double largest_relative_error = 0.03; ///< of factors between groups with nothing in between
constexpr double least_hidden_share = 1.0 / 8;  ///< that cannot be told from what five points by five see

constexpr std::size_t rule_points = 5;
using Kernels = std::array<std::array<double, rule_points>, rule_points>;
constexpr std::array<double, rule_points> rule_weights{1.0 / 3, 1.0 / 6, 1.0 / 6, 1.0 / 6, 1.0 / 6};

/// What the search needs of a group.
struct Extent {
    std::array<Vec3, 8> hull; ///< a convex hull, as points: of a flat group in its plane
    std::size_t hull_size = 0;
    std::array<Vec3, rule_points> point; ///< of the rule, if it is flat
    Vec3 centre = Vec3::Zero();
    double radius = 0.0; ///< of a ball around the centre

    std::span<const Vec3> corners() const { return {hull.data(), hull_size}; }
};

/// The mean of r over a triangle, and of r rᵀ, times its area.
struct Moments {
    double area = 0.0;
    Vec3 first = Vec3::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();

    void add(const Mesh& mesh, Index t, const Vec3& origin) {
        const Vec3 a = mesh.corner(t, 0) - origin, b = mesh.corner(t, 1) - origin, c = mesh.corner(t, 2) - origin;
        const Vec3 sum = a + b + c;
        const double A = mesh.areas[t];
        area += A;
        first += A / 3.0 * sum;
        second += A / 12.0 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
    }
};

/// A frame in the plane with this normal along the principal axes of a covariance in it, and the variances.
struct PrincipalAxes {
    Vec3 u, v;
    double along_u = 0.0, along_v = 0.0;

    PrincipalAxes(const Vec3& normal, const Eigen::Matrix3d& covariance) {
        const Vec3 s = normal.unitOrthogonal(), t = normal.cross(s);
        const double ss = s.dot(covariance * s), tt = t.dot(covariance * t), st = s.dot(covariance * t);
        const double angle = 0.5 * std::atan2(2.0 * st, ss - tt), half = std::hypot(0.5 * (ss - tt), st);
        u = std::cos(angle) * s + std::sin(angle) * t;
        v = normal.cross(u);
        along_u = std::max(0.0, 0.5 * (ss + tt) + half);
        along_v = std::max(0.0, 0.5 * (ss + tt) - half);
    }
};

/// The surface as the search sees it.
struct GroupedProblem {
    const Mesh& mesh;
    double tolerance, rounding;
    TargetTree tree;
    std::vector<Extent> extents; ///< of its nodes
    std::vector<double> area;    ///< likewise
    ObstacleSet obstacles;
    std::vector<PolygonEnd> ends;
};

Extent extent_of(const Mesh& mesh, const TargetTree& tree, const TargetTree::Node& node, double& area) {
    Extent extent;
    const Vec3 origin = mesh.corner(tree.order()[node.first], 0);
    Moments moments;
    for (Index i = node.first; i < node.last; ++i) {
        moments.add(mesh, tree.order()[i], origin);
    }
    area = moments.area;
    const Vec3 mean = moments.area > 0.0 ? Vec3(moments.first / moments.area) : Vec3(Vec3::Zero());
    extent.centre = origin + mean;
    const auto for_corners = [&](const auto& visit) {
        for (Index i = node.first; i < node.last; ++i) {
            for (int k = 0; k < 3; ++k) {
                visit(mesh.corner(tree.order()[i], k));
            }
        }
    };
    for_corners([&](const Vec3& p) { extent.radius = std::max(extent.radius, (p - extent.centre).norm()); });
    if (!node.flat) {
        extent.hull = node.corner;
        extent.hull_size = extent.hull.size();
        return extent;
    }
    const PrincipalAxes axes(
        node.plane.normal, moments.area > 0.0 ? Eigen::Matrix3d(moments.second / moments.area - mean * mean.transpose())
                                              : Eigen::Matrix3d(Eigen::Matrix3d::Zero()));
    const Vec3 step_u = std::sqrt(3.0 * axes.along_u) * axes.u, step_v = std::sqrt(3.0 * axes.along_v) * axes.v;
    extent.point = {extent.centre, extent.centre + step_u, extent.centre - step_u, extent.centre + step_v,
                    extent.centre - step_v};
    if (node.last - node.first == 1) {
        extent.hull_size = 3;
        for (unsigned k = 0; k < 3; ++k) {
            extent.hull[k] = mesh.corner(tree.order()[node.first], static_cast<int>(k));
        }
        return extent;
    }
    Eigen::Vector2d low = Eigen::Vector2d::Zero(), high = low;
    for_corners([&](const Vec3& p) {
        const Eigen::Vector2d at((p - extent.centre).dot(axes.u), (p - extent.centre).dot(axes.v));
        low = low.cwiseMin(at);
        high = high.cwiseMax(at);
    });
    extent.hull_size = 4;
    extent.hull[0] = extent.centre + low[0] * axes.u + low[1] * axes.v;
    extent.hull[1] = extent.centre + high[0] * axes.u + low[1] * axes.v;
    extent.hull[2] = extent.centre + high[0] * axes.u + high[1] * axes.v;
    extent.hull[3] = extent.centre + low[0] * axes.u + high[1] * axes.v;
    return extent;
}

/// The factors from points of one group to all of the other, whose area is `area`, as a function of the point.
struct FactorsOfGroup {
    double most = 0.0;                   ///< the largest
    double variation = 0.0;              ///< from the mean to a corner, if they are linear
    double curvature = 0.0;              ///< what is left of that beside a linear function, if they are quadratic
    double along_u = 0.0, along_v = 0.0; ///< of the kernel, from the centroid to the points of the rule

    FactorsOfGroup(const std::array<double, rule_points>& kernel, double mean, double area)
        : most(area * *std::max_element(kernel.begin(), kernel.end())), along_u(0.5 * (kernel[1] - kernel[2])),
          along_v(0.5 * (kernel[3] - kernel[4])) {
        const auto off = [&](std::size_t k) { return std::abs(kernel[k] - mean); };
        const auto second = [&](std::size_t k) { return std::abs(kernel[k] + kernel[k + 1] - 2.0 * kernel[0]); };
        variation = area * (std::max(off(1), off(2)) + std::max(off(3), off(4)));
        curvature = area * (second(1) + second(3)) / 3.0; // of x² less its mean, at three times the variance
    }
};

/// The exchange of two groups, from the kernel between the points of the rule.
struct GroupExchange {
    double mean;
    FactorsOfGroup a, b;

    static GroupExchange of(const Kernels& kernel, double area_a, double area_b) {
        std::array<double, rule_points> from_a{}, from_b{};
        for (std::size_t i = 0; i < rule_points; ++i) {
            for (std::size_t j = 0; j < rule_points; ++j) {
                from_a[i] += rule_weights[j] * kernel[i][j];
                from_b[j] += rule_weights[i] * kernel[i][j];
            }
        }
        double mean = 0.0;
        for (std::size_t i = 0; i < rule_points; ++i) {
            mean += rule_weights[i] * from_a[i];
        }
        return {mean, {from_a, mean, area_b}, {from_b, mean, area_a}};
    }
};

using Link = GroupedFormFactors::Link;

/// Links of pairs of groups. Scratch of one thread.
class GroupedWorker {
  public:
    GroupedWorker(const GroupedProblem& problem, const Execution& execution)
        : problem_(problem), pair_(problem.ends, problem.rounding, execution) {}

    struct Pair {
        Index a, b;
    };

    /// Adds the links between two groups, or within one.
    void run(Pair pair, std::vector<Link>& links) {
        links_ = &links;
        open_ = nullptr;
        start(pair);
    }

    /// One step of the search: links, or the pairs that are left.
    void divide(Pair pair, std::vector<Link>& links, std::vector<Pair>& open) {
        links_ = &links;
        open_ = &open;
        start(pair);
    }

    FormFactorCounts& counts() { return pair_.counts; }

  private:
    void start(Pair pair) {
        pair_.between.clear();
        for (const Obstacle& obstacle : problem_.obstacles.all()) {
            pair_.between.push_back(&obstacle);
        }
        visit(pair, 0, pair_.between.size());
    }

    void descend(Pair pair, std::size_t first, std::size_t last) {
        if (open_ != nullptr) {
            open_->push_back(pair);
        } else {
            visit(pair, first, last);
        }
    }

    void add(const Link& link) {
        if (link.kernel > 0.0) {
            links_->push_back(link);
        }
    }

    void visit(Pair pair, std::size_t first, std::size_t last) {
        const TargetTree::Node &a = problem_.tree.node(pair.a), &b = problem_.tree.node(pair.b);
        if (pair.a == pair.b) {
            if (!a.flat) {
                descend({pair.a + 1, pair.a + 1}, first, last);
                descend({pair.a + 1, a.right}, first, last);
                descend({a.right, a.right}, first, last);
            }
            return;
        }
        const Extent &at_a = problem_.extents[pair.a], &at_b = problem_.extents[pair.b];
        const PlaneSide of_a = b.flat ? side_of(b.plane, at_a.corners(), problem_.rounding) : PlaneSide::across,
                        of_b = a.flat ? side_of(a.plane, at_b.corners(), problem_.rounding) : PlaneSide::across;
        if (of_a == PlaneSide::behind || of_b == PlaneSide::behind) {
            return;
        }
        const std::size_t before = pair_.between.size();
        if (!pair_.narrow(at_a.corners(), at_b.corners(), first, last)) {
            ++pair_.counts.hidden;
            pair_.between.resize(before);
            return;
        }
        const std::size_t after = pair_.between.size();
        const bool in_front = of_a == PlaneSide::in_front && of_b == PlaneSide::in_front;
        if (a.right == none && b.right == none) {
            const double least = std::min(problem_.area[pair.a], problem_.area[pair.b]);
            const Estimate exchange = pair_.of(problem_.tree.order()[a.first], problem_.tree.order()[b.first], before,
                                               after, problem_.tolerance * least);
            add({pair.a, pair.b, exchange.value / (problem_.area[pair.a] * problem_.area[pair.b]), Vec3::Zero(),
                 Vec3::Zero(), static_cast<float>(exchange.error / least)});
        } else if (!(in_front && link(pair, before, after))) {
            const bool first_one = b.right == none || (a.right != none && at_a.radius >= at_b.radius);
            const Index node = first_one ? pair.a : pair.b, right = first_one ? a.right : b.right;
            descend(first_one ? Pair{node + 1, pair.b} : Pair{pair.a, node + 1}, before, after);
            descend(first_one ? Pair{right, pair.b} : Pair{pair.a, right}, before, after);
        }
        pair_.between.resize(before);
    }

    /// Links two flat groups, each in front of the other, if that is accurate enough.
    bool link(Pair pair, std::size_t first, std::size_t last) {
        const Extent &at_a = problem_.extents[pair.a], &at_b = problem_.extents[pair.b];
        if (!((at_b.centre - at_a.centre).norm() > least_linked_distance * (at_a.radius + at_b.radius))) {
            return false;
        }
        const Vec3 &n_a = problem_.tree.node(pair.a).plane.normal, &n_b = problem_.tree.node(pair.b).plane.normal;
        Kernels kernel;
        for (std::size_t i = 0; i < rule_points; ++i) {
            for (std::size_t j = 0; j < rule_points; ++j) {
                const Vec3 way = at_b.point[j] - at_a.point[i];
                const double square = way.squaredNorm();
                kernel[i][j] = std::numbers::inv_pi * std::max(0.0, n_a.dot(way)) * std::max(0.0, -n_b.dot(way)) /
                               (square * square);
            }
        }
        const double area_a = problem_.area[pair.a], area_b = problem_.area[pair.b];
        GroupExchange exchange = GroupExchange::of(kernel, area_a, area_b);
        double error = std::max(exchange.a.curvature, exchange.b.curvature);
        const double factor = std::max(exchange.a.most, exchange.b.most), mean = exchange.mean;
        const double most = group_share * problem_.tolerance;
        if (!(error <= largest_relative_error * factor)) {
            return false;
        }
        if (first != last) {
            if (!(error + least_hidden_share * factor <= most)) {
                return false;
            }
            hide(at_a, at_b, kernel, first, last);
            exchange = GroupExchange::of(kernel, area_a, area_b);
            const double seen = mean > 0.0 ? exchange.mean / mean : 0.0;
            error += factor * std::max(least_hidden_share, std::min(seen, 1.0 - seen));
        }
        Link link{pair.a, pair.b, exchange.mean, Vec3::Zero(), Vec3::Zero(), 0.0F};
        if (exchange.mean > 0.0) {
            link.gradient_a = gradient(at_a, exchange.a, exchange.mean, error);
            link.gradient_b = gradient(at_b, exchange.b, exchange.mean, error);
        }
        if (!(error <= most)) {
            return false;
        }
        ++(first == last ? pair_.counts.clear : pair_.counts.partial);
        link.error = static_cast<float>(error);
        add(link);
        return true;
    }

    /// Of the factor at points of a group relative to its mean, limited so that it is not negative at any corner;
    /// `error` becomes at least the error of the factor if that changes more.
    static Vec3 gradient(const Extent& at, const FactorsOfGroup& of, double mean, double& error) {
        const Vec3 u = at.point[1] - at.centre, v = at.point[3] - at.centre;
        const double uu = u.squaredNorm(), vv = v.squaredNorm();
        const Vec3 slope = ((uu > 0.0 ? of.along_u / uu : 0.0) * u + (vv > 0.0 ? of.along_v / vv : 0.0) * v) / mean;
        double least = 0.0;
        for (const Vec3& corner : at.corners()) {
            least = std::min(least, slope.dot(corner - at.centre));
        }
        if (least >= -1.0) {
            return slope;
        }
        error = std::max(error, of.curvature + (1.0 + 1.0 / least) * of.variation);
        return -slope / least;
    }

    /// The kernel becomes 0 between points that do not see each other.
    void hide(const Extent& at_a, const Extent& at_b, Kernels& kernel, std::size_t first, std::size_t last) const {
        for (std::size_t i = 0; i < rule_points; ++i) {
            for (std::size_t j = 0; j < rule_points; ++j) {
                for (std::size_t k = first; k < last && kernel[i][j] > 0.0; ++k) {
                    if (pair_.between[k]->is_crossed(at_a.point[i], at_b.point[j], problem_.rounding)) {
                        kernel[i][j] = 0.0;
                    }
                }
            }
        }
    }

    const GroupedProblem& problem_;
    PairExchange pair_;
    std::vector<Link>* links_ = nullptr;
    std::vector<Pair>* open_ = nullptr; ///< null: the search goes on to its end
};

/// Linear functions of place for each group: what its triangles have from it at their centroids.
class OfGroups {
  public:
    OfGroups(const GroupedFormFactors& F)
        : F_(F), value_(F.groups.size(), 0.0), gradient_(F.groups.size(), Vec3::Zero()) {}

    void add(Index group, double at_centre, const Vec3& gradient = Vec3::Zero()) {
        value_[group] += at_centre;
        gradient_[group] += gradient;
    }

    /// Pushes them down to the triangles.
    std::vector<double> of_triangles() && {
        std::vector<double> result(F_.area.size(), 0.0);
        for (std::size_t g = 0; g < F_.groups.size(); ++g) {
            const GroupedFormFactors::Group& group = F_.groups[g];
            if (group.right == none) {
                result[F_.order[group.first]] = value_[g];
                continue;
            }
            for (const std::size_t half : {g + 1, std::size_t{group.right}}) {
                value_[half] += value_[g] + gradient_[g].dot(F_.groups[half].centre - group.centre);
                gradient_[half] += gradient_[g];
            }
        }
        return result;
    }

  private:
    const GroupedFormFactors& F_;
    std::vector<double> value_;
    std::vector<Vec3> gradient_;
};

} // namespace

std::vector<double> GroupedFormFactors::row_sums() const {
    OfGroups sums(*this);
    for (const Link& link : links) {
        const double area_a = groups[link.a].area, area_b = groups[link.b].area;
        sums.add(link.a, area_b * link.kernel, area_b * link.kernel * link.gradient_a);
        sums.add(link.b, area_a * link.kernel, area_a * link.kernel * link.gradient_b);
    }
    return std::move(sums).of_triangles();
}

std::vector<double> GroupedFormFactors::row_errors() const {
    OfGroups sums(*this);
    for (const Link& link : links) {
        sums.add(link.a, link.error);
        sums.add(link.b, link.error);
    }
    return std::move(sums).of_triangles();
}

GroupedFormFactors grouped_form_factors(const Mesh& mesh, const FormFactorOptions& options, const Execution& execution,
                                        FormFactorCounts* counts) {
    check_tolerance(options);
    execution.phase("form factors");
    GroupedFormFactors F;
    F.area = mesh.areas;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        F.centroid.emplace_back((mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3.0);
    }
    if (mesh.triangles.empty()) {
        return F;
    }
    const std::vector<Index> parts = flat_parts(mesh), ranks(mesh.triangles.size(), 0);
    GroupedProblem problem{mesh,
                           options.tolerance,
                           plane_rounding(mesh),
                           TargetTree(mesh, parts, ranks, 1),
                           {},
                           {},
                           ObstacleSet(mesh.convex ? std::vector<Blocker>() : blockers_of(mesh, parts, execution)),
                           ends_of(mesh)};
    const TargetTree& tree = problem.tree;
    problem.extents.resize(tree.size());
    problem.area.resize(tree.size());
    parallel_for(tree.size(), 256, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t g = begin; g < end; ++g) {
            problem.extents[g] = extent_of(mesh, tree, tree.node(static_cast<Index>(g)), problem.area[g]);
        }
    });
    F.order = tree.order();
    for (std::size_t g = 0; g < tree.size(); ++g) {
        const TargetTree::Node& node = tree.node(static_cast<Index>(g));
        F.groups.push_back({node.first, node.last, node.right, problem.area[g], problem.extents[g].centre});
    }
    std::vector<GroupedWorker> workers(execution.threads, GroupedWorker(problem, execution));
    std::vector<GroupedWorker::Pair> open{{TargetTree::root, TargetTree::root}};
    while (!open.empty() && open.size() < tasks_at_least) {
        std::vector<GroupedWorker::Pair> next;
        for (const GroupedWorker::Pair& pair : open) {
            workers.front().divide(pair, F.links, next);
        }
        open = std::move(next);
    }
    std::vector<std::vector<Link>> found(open.size());
    parallel_for(open.size(), 1, execution, [&](std::size_t begin, std::size_t end, unsigned worker) {
        for (std::size_t k = begin; k < end; ++k) {
            workers[worker].run(open[k], found[k]);
        }
    });
    for (std::vector<Link>& each : found) {
        F.links.insert(F.links.end(), each.begin(), each.end());
        each = {};
    }
    if (counts != nullptr) {
        for (GroupedWorker& worker : workers) {
            *counts += worker.counts();
        }
    }
    return F;
}

} // namespace difusa
