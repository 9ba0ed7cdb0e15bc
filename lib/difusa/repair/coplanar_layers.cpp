#include <difusa/repair/coplanar_layers.h>

#include <difusa/core/parallel.h>
#include <difusa/core/text.h>
#include <difusa/mesh/convex_polygon.h>
#include <difusa/mesh/parity_sets.h>
#include <difusa/mesh/shared_area.h>
#include <difusa/mesh/triangle_tree.h>
#include <difusa/mesh/twins.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

namespace difusa {

namespace {

using Vec2 = Eigen::Vector2d;

// A gap is below what counts as touching (wall_rounding in discretisation/separators.h), 2^-21 of the diameter.
constexpr double layer_of_diameter = 0x1p-20, layer_of_magnitude = 0x1p-37;
constexpr double gap_of_diameter = 0x1p-22, gap_of_magnitude = 0x1p-38;
constexpr double in_plane = 0.5; ///< of the gap: heights that count as none, such as those of single precision
constexpr double least_cosine = 1.0 - 1e-6; ///< cosine; corners are compared as well
constexpr double least_overlap = 1e-3;      ///< of the smaller triangle: neighbours overlap by the rounding of a file
constexpr double equal_areas = 1e-6;        ///< relative difference of areas that are equal but for rounding

/// A triangle without the coordinate along which its normal is longest, counterclockwise.
ConvexPolygon flattened(const std::array<Vec3, 3>& corners, const Vec3& origin, int dropped) {
    ConvexPolygon flat;
    for (const Vec3& corner : corners) {
        const Vec3 p = corner - origin;
        flat.add(Vec2(p[(dropped + 1) % 3], p[(dropped + 2) % 3]));
    }
    if (flat.area() < 0.0) {
        std::swap(flat.corner[1], flat.corner[2]);
    }
    return flat;
}

bool are_in_plane(const Mesh& mesh, Index own, Index other, double rounding) {
    for (int k = 0; k < 3; ++k) {
        if (!(std::abs(mesh.normals[own].dot(mesh.corner(other, k) - mesh.corner(own, 0))) <= rounding)) {
            return false;
        }
    }
    return true;
}

/// What triangles a and b have in common, if anything.
std::optional<Overlap> overlap_of(const Mesh& mesh, Index a, Index b, double rounding) {
    const Vec3& n = mesh.normals[a];
    const double cosine = n.dot(mesh.normals[b]);
    if (std::abs(cosine) < least_cosine || !are_in_plane(mesh, a, b, rounding) || !are_in_plane(mesh, b, a, rounding) ||
        !share_area(mesh.corners(a), mesh.corners(b), n, rounding)) {
        return std::nullopt;
    }
    int dropped = 0;
    n.cwiseAbs().maxCoeff(&dropped);
    const Vec3& origin = mesh.corner(a, 0);
    const ConvexPolygon window = flattened(mesh.corners(a), origin, dropped);
    ConvexPolygon common = flattened(mesh.corners(b), origin, dropped);
    for (std::size_t k = 0; k < 3 && common.count > 0; ++k) {
        const Vec2 &p = window.corner[k], &q = window.corner[(k + 1) % 3];
        const Vec2 inwards(p[1] - q[1], q[0] - p[0]);
        common = common.cut(-inwards.dot(p), inwards);
    }
    const double area = common.area() / std::abs(n[dropped]);
    if (common.count == 0 || !(area > least_overlap * std::min(mesh.areas[a], mesh.areas[b]))) {
        return std::nullopt;
    }
    const Vec2 middle = common.centroid();
    Vec3 place = Vec3::Zero();
    place[(dropped + 1) % 3] = middle[0];
    place[(dropped + 2) % 3] = middle[1];
    place[dropped] = -n.dot(place) / n[dropped];
    return Overlap{a, b, cosine > 0.0, area, origin + place};
}

} // namespace

CoplanarDistances::CoplanarDistances(const Mesh& mesh)
    : layer(std::max(layer_of_diameter * mesh.diameter(), layer_of_magnitude * mesh.magnitude())),
      gap(std::max(gap_of_diameter * mesh.diameter(), gap_of_magnitude * mesh.magnitude())) {}

double CoplanarDistances::rounding() const {
    return in_plane * gap;
}

std::optional<std::vector<Overlap>> find_overlaps(const Mesh& mesh, double rounding, const Execution& execution) {
    constexpr std::size_t grain = 256;
    const std::size_t count = mesh.triangles.size(), most = 1'000'000 + 100 * count;
    const BoxTree tree = tree_of_triangles(mesh);
    std::vector<std::vector<Overlap>> found((count + grain - 1) / grain);
    std::atomic<std::size_t> pairs{0}; // exceeds the limit or not, whatever the order
    parallel_for(count, grain, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        for (auto a = static_cast<Index>(begin); a < end && pairs <= most; ++a) {
            execution.check();
            std::size_t own = 0;
            const Vec3 margin = Vec3::Constant(rounding);
            const BoxTree::Box box = mesh.box(a);
            tree.visit({box.min() - margin, box.max() + margin}, [&](Index b, const BoxTree::Box&) {
                if (b > a) {
                    ++own;
                    if (const std::optional<Overlap> overlap = overlap_of(mesh, a, b, rounding)) {
                        found[begin / grain].push_back(*overlap);
                    }
                }
                return own > most;
            });
            pairs += own;
        }
    });
    if (pairs > most) {
        return std::nullopt;
    }
    std::vector<Overlap> all;
    for (const std::vector<Overlap>& part : found) {
        all.insert(all.end(), part.begin(), part.end());
    }
    std::sort(all.begin(), all.end(),
              [](const Overlap& x, const Overlap& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
    return all;
}

namespace {

NumberedSets numbered(ParitySets& sets, std::size_t triangles) {
    NumberedSets result{std::vector<Index>(triangles), 0};
    std::vector<Index> number(triangles, none);
    for (Index t = 0; t < triangles; ++t) {
        Index& own = number[sets.find(t).root];
        own = own == none ? static_cast<Index>(result.count++) : own;
        result.of[t] = own;
    }
    return result;
}

/// Where the surface continues across each side of a triangle, seen from its back: a body that stands on a floor and
/// shares points with it is closed by its own bottom (mesh/twins.h).
std::vector<Index> joined_behind(const Mesh& mesh) {
    std::vector<std::array<Index, 3>> turned = mesh.triangles;
    for (auto& triangle : turned) {
        std::swap(triangle[1], triangle[2]);
    }
    return join_sides(mesh.points, turned);
}

} // namespace

std::string place_of(const CoplanarFace& face, const char* relation, const Diagnosis& diagnosis) {
    return face_name(diagnosis, face.face) + relation + face_name(diagnosis, face.other) + " near " +
           coordinates(face.place);
}

std::vector<Finding> findings_of(Defect defect, const std::vector<CoplanarFace>& faces, bool given_up,
                                 const Diagnosis& diagnosis) {
    std::vector<Finding> findings;
    if (given_up) {
        findings.push_back(finding_of(Defect::coplanar_faces_unknown, 1, {}));
    }
    if (!faces.empty()) {
        std::vector<std::string> places;
        for (const CoplanarFace& face : faces) {
            places.push_back(place_of(face, defect == Defect::covered_parts ? " by " : " on ", diagnosis));
        }
        findings.push_back(finding_of(defect, faces.size(), std::move(places)));
    }
    return findings;
}

template <class Act> void CoplanarLayers::for_each_twin(const Act& act) const {
    for (std::size_t side = 0; side < twin_.size(); ++side) {
        if (twin_[side] != none && twin_[side] > side) {
            act(static_cast<Index>(side / 3), twin_[side] / 3);
        }
    }
}

NumberedSets CoplanarLayers::joined(bool within_planes) const {
    ParitySets sets(mesh_.triangles.size());
    for_each_twin([&](Index t, Index u) {
        if (!within_planes || (mesh_.normals[t].dot(mesh_.normals[u]) >= least_cosine &&
                               are_in_plane(mesh_, t, u, distances_.rounding()))) {
            sets.join(t, u, false);
        }
    });
    return numbered(sets, mesh_.triangles.size());
}

CoplanarLayers::CoplanarLayers(const Mesh& mesh, const CoplanarDistances& distances,
                               const std::vector<Overlap>& overlaps)
    : mesh_(mesh), distances_(distances), twin_(joined_behind(mesh)), parts_(joined(false)), patches_(joined(true)),
      area_(patches_.count, 0.0), shift_(patches_.count, 0.0), back_(patches_.count, none), stands_(patches_.count, 0) {
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        area_[patch(t)] += mesh.areas[t];
    }
    find_bodies();
    find_backs();
    find_contacts(overlaps);
    put_in_front(pairs_with_same_front(overlaps));
    for (const auto& [body, support] : contacts_) {
        shift_[body] = std::min(shift_[body], -distances_.gap - std::max(0.0, shift_[support]));
        if (back_[body] != none) {
            shift_[back_[body]] = -shift_[body];
        }
    }
}

bool CoplanarLayers::is_contact(const Overlap& overlap) const {
    const auto has = [&](Index body, Index support) {
        return std::binary_search(contacts_.begin(), contacts_.end(), std::pair(patch(body), patch(support)));
    };
    const bool are_bodies = is_body(overlap.a) && is_body(overlap.b) && parts_.of[overlap.a] != parts_.of[overlap.b];
    return !overlap.same_front && (are_bodies || has(overlap.a, overlap.b) || has(overlap.b, overlap.a));
}

Index CoplanarLayers::covered_one(const Overlap& overlap) const {
    const Index p = patch(overlap.a), q = patch(overlap.b);
    if (!overlap.same_front || stands_[p] != 0 || stands_[q] != 0 || shift_[p] == shift_[q]) {
        return none;
    }
    return shift_[p] < shift_[q] ? overlap.a : overlap.b;
}

std::vector<Index> CoplanarLayers::groups(const std::vector<Overlap>& overlaps) const {
    ParitySets joined_sets(mesh_.triangles.size());
    for_each_twin([&](Index t, Index u) { joined_sets.join(t, u, false); });
    for (const auto& [t, u] : sheets_) {
        joined_sets.join(t, u, false);
    }
    const NumberedSets sets = numbered(joined_sets, mesh_.triangles.size());
    std::vector<char> alone(patches_.count, 0);
    for (const Overlap& overlap : overlaps) {
        if (overlap.same_front && sets.of[overlap.a] == sets.of[overlap.b] && shift(overlap.a) != shift(overlap.b)) {
            alone[patch(shift(overlap.a) > shift(overlap.b) ? overlap.a : overlap.b)] = 1;
        }
    }
    std::vector<Index> group(sets.of);
    for (Index t = 0; t < mesh_.triangles.size(); ++t) {
        group[t] = alone[patch(t)] != 0 ? static_cast<Index>(sets.count) + patch(t) : group[t];
    }
    return group;
}

/// Parts without a border whose volume is positive.
void CoplanarLayers::find_bodies() {
    std::vector<char> open(parts_.count, 0);
    std::vector<double> volume(parts_.count, 0.0), area(parts_.count, 0.0);
    std::vector<Index> first(parts_.count, none);
    for (Index t = 0; t < mesh_.triangles.size(); ++t) {
        const Index part = parts_.of[t];
        first[part] = first[part] == none ? t : first[part];
        for (std::size_t k = 0; k < 3; ++k) {
            open[part] = open[part] != 0 || twin_[3 * std::size_t{t} + k] == none ? 1 : 0;
        }
        volume[part] += mesh_.areas[t] * mesh_.normals[t].dot(mesh_.corner(t, 0) - mesh_.corner(first[part], 0)) / 3.0;
        area[part] += mesh_.areas[t];
    }
    is_body_.resize(parts_.count);
    for (std::size_t part = 0; part < parts_.count; ++part) {
        is_body_[part] = open[part] == 0 && volume[part] > 1e-9 * area[part] * std::sqrt(area[part]) ? 1 : 0;
    }
}

/// Pairs of triangles that are the two sides of a sheet: not one of a body and one of the floor that it stands on.
void CoplanarLayers::find_backs() {
    std::vector<std::pair<std::array<Index, 3>, Index>> sorted; // corners and triangle
    sorted.reserve(mesh_.triangles.size());
    for (Index t = 0; t < mesh_.triangles.size(); ++t) {
        sorted.emplace_back(mesh_.triangles[t], t);
        std::sort(sorted.back().first.begin(), sorted.back().first.end());
    }
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 1; i < sorted.size(); ++i) {
        if (sorted[i].first != sorted[i - 1].first) {
            continue;
        }
        const Index t = sorted[i].second, u = sorted[i - 1].second, p = patch(t), q = patch(u);
        if (is_body(t) == is_body(u) || std::abs(area_[p] - area_[q]) <= equal_areas * area_[p]) {
            sheets_.emplace_back(u, t);
            back_[p] = q;
            back_[q] = p;
        }
    }
}

void CoplanarLayers::find_contacts(const std::vector<Overlap>& overlaps) {
    std::map<std::pair<Index, Index>, double> common; // of a body's patch and a sheet's
    for (const Overlap& overlap : overlaps) {
        for (const auto& [body, sheet] : {std::pair(overlap.a, overlap.b), std::pair(overlap.b, overlap.a)}) {
            if (!overlap.same_front && is_body(body) && !is_body(sheet)) {
                common[{patch(body), patch(sheet)}] += overlap.area;
            }
        }
    }
    for (const auto& [pair, area] : common) {
        if (area < (1.0 - equal_areas) * area_[pair.second]) {
            contacts_.push_back(pair);
        }
    }
    for (const auto& [body, support] : contacts_) {
        stands_[body] = 1;
    }
}

/// The area of each patch with those of its material that lie under, or on, the same other one: tiles are a floor.
std::vector<double> CoplanarLayers::areas_with_tiles(const std::vector<std::pair<Index, Index>>& pairs) const {
    std::vector<Index> material(patches_.count, none);
    for (Index t = 0; t < mesh_.triangles.size(); ++t) {
        material[patch(t)] = mesh_.material[t];
    }
    ParitySets tiles(patches_.count);
    std::map<std::pair<Index, Index>, Index> first; // patch and material: that of those which overlap it
    for (const auto& [p, q] : pairs) {
        tiles.join(first.try_emplace({p, material[q]}, q).first->second, q, false);
        tiles.join(first.try_emplace({q, material[p]}, p).first->second, p, false);
    }
    std::vector<double> sum(patches_.count, 0.0), all(patches_.count);
    for (Index p = 0; p < patches_.count; ++p) {
        sum[tiles.find(p).root] += area_[p];
    }
    for (Index p = 0; p < patches_.count; ++p) {
        all[p] = sum[tiles.find(p).root];
    }
    return all;
}

/// But for those that are drawn into bodies.
std::vector<std::pair<Index, Index>> CoplanarLayers::pairs_with_same_front(const std::vector<Overlap>& overlaps) const {
    std::vector<std::pair<Index, Index>> pairs;
    for (const Overlap& overlap : overlaps) {
        const Index p = patch(overlap.a), q = patch(overlap.b);
        if (overlap.same_front && p != q && stands_[p] == 0 && stands_[q] == 0) {
            pairs.emplace_back(std::min(p, q), std::max(p, q));
        }
    }
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    return pairs;
}

/// One layer on the other.
void CoplanarLayers::put_in_front(const std::vector<std::pair<Index, Index>>& pairs) {
    const std::vector<double> with_tiles = areas_with_tiles(pairs);
    std::vector<Index> order(patches_.count); // from the back to the front
    std::iota(order.begin(), order.end(), Index{0});
    const auto key = [&](Index p) { // in single precision, which makes most of those equal that are alike
        return std::tuple(-static_cast<float>(with_tiles[p]), -static_cast<float>(area_[p]), p);
    };
    std::sort(order.begin(), order.end(), [&](Index p, Index q) { return key(p) < key(q); });
    std::vector<Index> rank(patches_.count);
    for (Index i = 0; i < order.size(); ++i) {
        rank[order[i]] = i;
    }
    std::vector<std::vector<Index>> behind(patches_.count);
    for (const auto& [p, q] : pairs) {
        behind[rank[p] > rank[q] ? p : q].push_back(rank[p] > rank[q] ? q : p);
    }
    const auto is_larger = [&](Index p, Index q) {
        return with_tiles[p] > (1.0 + equal_areas) * with_tiles[q] || area_[p] > (1.0 + equal_areas) * area_[q];
    };
    std::vector<int> level(patches_.count, 0);
    for (const Index p : order) {
        if (back_[p] != none && shift_[back_[p]] != 0.0) {
            shift_[p] = -shift_[back_[p]]; // its other side has been moved
            continue;
        }
        std::vector<int> taken; // by others of the same size
        for (const Index q : behind[p]) {
            if (is_larger(q, p)) {
                level[p] = std::max(level[p], level[q] + 1);
            } else {
                taken.push_back(level[q]);
            }
        }
        while (std::find(taken.begin(), taken.end(), level[p]) != taken.end()) {
            ++level[p];
        }
        shift_[p] = distances_.layer * level[p];
    }
}

} // namespace difusa
