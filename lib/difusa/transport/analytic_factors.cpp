#include <difusa/transport/analytic_factors.h>

#include <difusa/discretisation/region_trees.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/mesh/triangle_tree.h>
#include <difusa/rays/lambert.h>
#include <difusa/rays/own_plane.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace difusa {

namespace {

/// Largest (A ΔK)² N / F of a group, where ΔK is how far the kernel is from linear: the error is at most an eighth of
/// the noise of N independent rays.
constexpr double most_variation = 1.0 / 64.0;

/// As many independent rays as have the noise of N even ones, whose variance falls as N to the power -1.5 (measured).
double independent_rays(double N) {
    return N * std::max(1.0, std::sqrt(N) / 8.0);
}

/// Fewer rays than this are not worth looking into what hides a part of a group: what is in sight has the mean light of
/// all.
constexpr double rays_of_smallest = 0.25;

/// Of a form factor: what is less is rounding.
constexpr double negligible_part = 1e-9;

/// Of the mean square distance of samples: what is less is rounding.
constexpr double slope_rounding = 1e-9;

/// Edges of an outline at whose start and middle the kernel is looked at.
constexpr std::size_t outline_samples = 8;

} // namespace

/// A point and the half space that it sees: above its face, and with a shading normal not only above the horizon of
/// that (Sight::lift).
struct AnalyticFactors::View {
    SurfacePoint x; ///< the ray origin
    Vec3 face;      ///< normal of its face
    Vec3 mirrored;  ///< the shading normal, mirrored at the face
    bool is_shaded; ///< they differ

    View(const Mesh& mesh, const SurfacePoint& at)
        : x(inset(mesh, at)), face(mesh.face_normal(at)), mirrored(at.normal - 2.0 * face.dot(at.normal) * face),
          is_shaded(at.normal != face) {}

    /// What of the irradiance at x a unit of radiosity and area at y contributes.
    double kernel(const Vec3& y, const Vec3& n_y) const {
        const Vec3 way = y - x.position;
        const double r2 = way.squaredNorm(), up = face.dot(way), at_y = -n_y.dot(way);
        if (!(up > 0.0) || !(at_y > 0.0)) {
            return 0.0;
        }
        double at_x = up;
        if (is_shaded) {
            at_x = std::max(0.0, x.normal.dot(way)) + std::max(0.0, mirrored.dot(way));
        }
        return at_x * at_y / (std::numbers::pi * r2 * r2);
    }

    /// Form factor of a convex polygon of at most 16 corners.
    double factor(std::span<const Vec3> polygon) const {
        if (!is_shaded) {
            return lambert_form_factor(x.position, face, polygon);
        }
        std::array<Vec3, most_lambert_corners + 1> above;
        std::size_t count = 0;
        for (std::size_t k = 0; k < polygon.size(); ++k) {
            const Vec3 &p = polygon[k], &q = polygon[k + 1 < polygon.size() ? k + 1 : 0];
            const double at_p = face.dot(p - x.position), at_q = face.dot(q - x.position);
            if (at_p >= 0.0) {
                above[count++] = p;
            }
            if ((at_p > 0.0 && at_q < 0.0) || (at_p < 0.0 && at_q > 0.0)) {
                above[count++] = p + at_p / (at_p - at_q) * (q - p);
            }
        }
        if (count < 3) {
            return 0.0;
        }
        const std::span<const Vec3> seen(above.data(), count);
        return lambert_form_factor(x.position, x.normal, seen) + lambert_form_factor(x.position, mirrored, seen);
    }

    /// Whether p is above the horizon of the face, and the same horizon as all others that are above.
    bool is_above(const Vec3& p, double rounding) const {
        const Vec3 way = p - x.position;
        return face.dot(way) >= -rounding && (!is_shaded || (x.normal.dot(way) >= 0.0 && mirrored.dot(way) <= 0.0));
    }
};

AnalyticFactors::AnalyticFactors(const Mesh& mesh, const Surfels& surfels, std::size_t rays, const Execution& execution)
    : AnalyticFactors(mesh, surfels, exposures(mesh, execution), overlaid_faces(mesh, execution), rays) {}

AnalyticFactors::AnalyticFactors(const Mesh& mesh, const Surfels& surfels, const std::vector<Exposure>& exposures,
                                 const std::vector<std::uint8_t>& overlaid, std::size_t rays)
    : mesh_(mesh), tree_(mesh, surfels, exposures, overlaid), shafts_(mesh, occluders(exposures)),
      faces_(tree_of_triangles(mesh)), rays_(independent_rays(static_cast<double>(rays))),
      rounding_(plane_rounding(mesh)) {}

void AnalyticFactors::find(const SurfacePoint& x, std::vector<Factor>& found, Worker& worker) const {
    found.clear();
    if (tree_.groups().size() == 0) {
        return;
    }
    const View view(mesh_, x);
    worker.open.assign(1, {static_cast<Index>(tree_.groups().size() - 1), !shafts_.any()});
    while (!worker.open.empty()) {
        const auto [group, open] = worker.open.back();
        worker.open.pop_back();
        ++worker.steps;
        look(view, group, open, found, worker);
    }
    std::sort(found.begin(), found.end());
}

AnalyticFactors::Measure AnalyticFactors::measure_polygon(const View& view, const SurfelTree::Node& node,
                                                          std::vector<Sample>& samples) const {
    if (node.normal.dot(view.x.position) - node.offset <= rounding_) {
        return {}; // seen from behind, or edge-on
    }
    const std::span<const Vec3> corners = tree_.corners(node);
    Measure measure;
    measure.facing = Facing::wholly;
    measure.factor = view.factor(corners);
    for (std::size_t k = 0; k < corners.size(); ++k) {
        // Between the corners, too: on a triangle two of three quadratic functions are linear at corners and centroid.
        const Vec3 between = 0.5 * (corners[k] + corners[k + 1 < corners.size() ? k + 1 : 0]);
        samples.push_back({corners[k], view.kernel(corners[k], node.normal)});
        samples.push_back({between, view.kernel(between, node.normal)});
    }
    return measure;
}

AnalyticFactors::Measure AnalyticFactors::measure_outline(const View& view, const SurfelTree::Node& node,
                                                          std::vector<Sample>& samples) const {
    if (node.flat ? node.normal.dot(view.x.position) - node.offset <= rounding_ : node.exposure == Exposure::behind) {
        return {};
    }
    if (!node.flat && node.exposure != Exposure::before) {
        return {Facing::partly};
    }
    const std::span<const SurfelTree::Edge> edges = tree_.edges(node);
    Measure measure;
    measure.facing = Facing::wholly;
    const std::size_t step = (edges.size() + outline_samples - 1) / outline_samples;
    for (std::size_t k = 0; k < edges.size(); ++k) {
        const Vec3 &from = mesh_.points[edges[k].from], &to = mesh_.points[edges[k].to];
        if (!view.is_above(from, rounding_) || !view.is_above(to, rounding_)) {
            return {Facing::partly};
        }
        if (k % step == 0) {
            for (const double part : {0.0, 0.5}) {
                const SurfacePoint y = along(edges[k], part);
                samples.push_back({y.position, view.kernel(y.position, y.normal)});
            }
        }
    }
    for (const SurfelTree::Edge& edge : edges) {
        measure.factor += lambert_edge(view.x.normal, mesh_.points[edge.from] - view.x.position,
                                       mesh_.points[edge.to] - view.x.position);
    }
    measure.factor = std::max(0.0, measure.factor);
    return measure;
}

/// On an edge, at this part of it from its start, on the side of its triangle. With the shading normal: that of a facet
/// of a smooth surface says little about those beside it.
SurfacePoint AnalyticFactors::along(const SurfelTree::Edge& edge, double part) const {
    const std::array<Index, 3>& corners = mesh_.triangles[edge.triangle];
    const auto weight = [&](Index corner) {
        return corner == edge.from ? 1.0 - part : (corner == edge.to ? part : 0.0);
    };
    return mesh_.shaded(mesh_.at(edge.triangle, weight(corners[1]), weight(corners[2])));
}

/// The form factor of what is in sight of a patch that faces x, and has the factor `factor` if nothing hides it.
/// Nothing if too much is in between.
std::optional<double> AnalyticFactors::visible_factor(const View& view, const SurfelTree::Node& node, double factor,
                                                      Worker& worker) const {
    if (node.shape == SurfelTree::Shape::outline) {
        const bool open = node.exposure != Exposure::both && !shafts_.may_reach_between(view.x.position, node.box);
        return open ? std::optional(factor) : std::nullopt;
    }
    const PolygonInSight::Extent extent =
        worker.sight.look(shafts_, view.x, tree_.corners(node), {node.normal, node.offset}, PolygonInSight::Limits());
    worker.steps += worker.sight.blockers().size();
    if (extent == PolygonInSight::Extent::unknown) {
        return {};
    }
    const auto factor_of = [&](std::span<const Vec3> piece) { return view.factor(piece); };
    return extent == PolygonInSight::Extent::whole ? factor : std::min(worker.sight.sum(factor_of), factor);
}

/// Whether one of the faces meets the plane of a polygon within its box.
bool AnalyticFactors::stands_on(const SurfelTree::Node& node, const std::vector<Index>& faces) const {
    // The box of a level patch has no height, which the foot of a wall on it may miss by rounding.
    const BoxTree::Box around = grown(node.box, rounding_);
    return std::any_of(faces.begin(), faces.end(), [&](Index face) {
        double least = std::numeric_limits<double>::infinity();
        BoxTree::Box foot;
        for (const Vec3& corner : mesh_.corners(face)) {
            const double height = node.normal.dot(corner) - node.offset;
            least = std::min(least, height);
            if (height <= rounding_) {
                foot.extend(corner);
            }
        }
        return least < -rounding_ ? around.intersects(mesh_.box(face)) : around.intersects(foot);
    });
}

/// Whether a polygon reaches below the plane of the face that x is on, where a face in that plane meets it: behind the
/// wall that x is on, the polygon often has another light than before it.
bool AnalyticFactors::reaches_behind(const View& view, const SurfelTree::Node& node) const {
    const Plane own{view.face, view.face.dot(view.x.position)};
    const std::span<const Vec3> corners = tree_.corners(node);
    if (std::all_of(corners.begin(), corners.end(), [&](const Vec3& p) { return own.height(p) >= -rounding_; })) {
        return false;
    }
    return faces_.visit(grown(node.box, rounding_), [&](Index face, const BoxTree::Box&) {
        const auto triangle = mesh_.corners(face);
        return std::all_of(triangle.begin(), triangle.end(),
                           [&](const Vec3& p) { return std::abs(own.height(p)) <= rounding_; });
    });
}

/// A linear function over a group, and how far the kernel is from it.
struct AnalyticFactors::Linear {
    double mean; ///< at the centroid
    Vec3 centre, slope;
    double deviation = 0.0; ///< largest, where the kernel was looked at

    Linear(std::span<const Sample> samples, double at_centre, const Vec3& centroid, const Vec3& steepness)
        : mean(at_centre), centre(centroid), slope(steepness) {
        for (const Sample& sample : samples) {
            deviation = std::max(deviation, std::abs(sample.kernel - mean - slope.dot(sample.place - centre)));
        }
    }
};

/// The slope of the kernel by least squares; less steep if the linear function that has the mean of the kernel at the
/// centroid would be negative somewhere, so that no light of one place takes from that of another.
Vec3 AnalyticFactors::slope_of(std::span<const Sample> samples, const Vec3& centre, double mean) {
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    Vec3 products = Vec3::Zero(), middle = Vec3::Zero();
    for (const Sample& sample : samples) {
        middle += sample.place / static_cast<double>(samples.size());
    }
    for (const Sample& sample : samples) {
        const Vec3 way = sample.place - middle;
        squares += way * way.transpose();
        products += sample.kernel * way;
    }
    squares.diagonal().array() += slope_rounding * squares.trace(); // in a plane there is no slope across it
    const Vec3 slope = squares.inverse() * products;
    if (!slope.allFinite()) { // the samples are in one place
        return Vec3::Zero();
    }
    double lowest = 0.0;
    for (const Sample& sample : samples) {
        lowest = std::min(lowest, slope.dot(sample.place - centre));
    }
    return lowest < -mean ? Vec3(mean / -lowest * slope) : slope;
}

/// Adds the group, leaves it to the rays, or opens its halves.
void AnalyticFactors::look(const View& view, Index group, bool open, std::vector<Factor>& found, Worker& worker) const {
    const SurfelTree::Node& node = tree_.node(group);
    const SurfelGroups::Group& halves = tree_.groups()[group];
    const Vec3 centre = node.box.center(), half = 0.5 * node.box.sizes();
    if (view.face.dot(centre - view.x.position) + view.face.cwiseAbs().dot(half) <= rounding_) {
        return; // below the horizon
    }
    const double distance = (centre - view.x.position).norm(), radius = half.norm();
    const bool leaf = halves.second == none;
    const auto descend = [&](bool is_open) {
        if (!leaf) {
            worker.open.emplace_back(halves.second, is_open);
            worker.open.emplace_back(halves.first, is_open);
        }
    };
    if (node.shape == SurfelTree::Shape::bundle) {
        // What is within a ball of this radius has a form factor of at most radius² / distance².
        if (distance <= radius || rays_ * radius * radius >= rays_of_smallest * distance * distance) {
            descend(open);
        }
        return;
    }
    worker.samples.clear();
    const Measure measure = node.shape == SurfelTree::Shape::polygon ? measure_polygon(view, node, worker.samples)
                                                                     : measure_outline(view, node, worker.samples);
    if (measure.facing == Facing::away) {
        return;
    }
    const bool is_mixed = !leaf && node.shape == SurfelTree::Shape::polygon && reaches_behind(view, node);
    if (measure.facing == Facing::partly || is_mixed) {
        descend(open);
        return;
    }
    if (!open) {
        const std::optional<double> visible = visible_factor(view, node, measure.factor, worker);
        if (visible && *visible <= negligible_part * measure.factor) {
            return;
        }
        open = visible && *visible >= (1.0 - negligible_part) * measure.factor;
        if (!open) {
            // Where what hides a part stands on the surface, the other part often has another light.
            const bool mixed = visible && stands_on(node, worker.sight.blockers());
            if (!leaf && (mixed || rays_ * measure.factor > rays_of_smallest)) {
                descend(false);
            } else if (visible) {
                found.push_back({group, *visible, Vec3::Zero()});
            }
            return;
        }
    }
    if (leaf) { // of a single surfel the mean light alone is known
        if (measure.factor > 0.0) {
            found.push_back({group, measure.factor, Vec3::Zero()});
        }
        return;
    }
    const double mean = measure.factor / halves.area;
    const bool is_near = node.box.squaredExteriorDistance(view.x.position) < 0.25 * radius * radius;
    const auto represents = [&](const Linear& kernel) {
        // The kernel may be greatest where it is not looked at.
        const double variation = halves.area * (is_near ? std::max(kernel.deviation, mean) : kernel.deviation);
        return measure.factor > 0.0 && variation * variation * rays_ <= most_variation * measure.factor;
    };
    if (represents({worker.samples, mean, halves.centre, Vec3::Zero()})) {
        found.push_back({group, measure.factor, Vec3::Zero()});
        return;
    }
    const Vec3 slope = slope_of(worker.samples, halves.centre, mean);
    if (represents({worker.samples, mean, halves.centre, slope})) {
        found.push_back({group, measure.factor, halves.area * slope});
        return;
    }
    descend(true);
}

} // namespace difusa
