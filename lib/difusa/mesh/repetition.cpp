#include <difusa/mesh/repetition.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/mesh/mesh.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace difusa {

namespace {

constexpr double fitting = 1e-5;    ///< of angles and unit vectors
constexpr double most_at_edge = 36; ///< planes of a wedge: each image of a lamp takes memory
constexpr double series = 4096.0;   ///< cells that a length which leads out of an infinite series of them passes

std::string plane_name(std::size_t i) {
    return "symmetry plane " + std::to_string(i + 1);
}

bool perpendicular_to(const Vec3& a, const Vec3& b) {
    return std::abs(a.dot(b)) <= fitting;
}

bool parallel_to(const Vec3& a, const Vec3& b) {
    return a.cross(b).norm() <= fitting;
}

/// The number n of planes that meet at the edge of two whose normals have this scalar product, which is -cos(pi/n).
double planes_at_edge(double cosine) {
    return std::numbers::pi / std::acos(std::clamp(-cosine, -1.0, 1.0));
}

/// Brings planes and periods into place.
class Fitting {
  public:
    explicit Fitting(Repetition& given) : planes_(given.planes), periods_(given.periods) {}

    void fit() {
        for (Repetition::Plane& plane : planes_) {
            const double length = plane.normal.stableNorm();
            if (!(length > 0.0 && std::isfinite(length) && plane.point.allFinite())) {
                throw InputError("a symmetry plane has no normal, or a point that is not finite");
            }
            plane.normal /= length;
        }
        std::vector<char> settled(planes_.size(), 0);
        for (std::size_t i = 0; i < planes_.size(); ++i) {
            const std::size_t partner = partner_of(i);
            if (settled[i] != 0) {
                continue;
            }
            Vec3& normal = planes_[i].normal;
            normal = free_part(normal);
            std::vector<Vec3> own{normal};
            if (partner < planes_.size()) {
                pair(normal, planes_[partner].normal, own);
                settled[partner] = 1;
            }
            frame_.insert(frame_.end(), own.begin(), own.end());
        }
        for (std::size_t k = 0; k < periods_.size(); ++k) {
            fit_period(k);
        }
    }

  private:
    /// The plane that is not at right angles to plane i; #planes if all are.
    std::size_t partner_of(std::size_t i) const {
        std::size_t partner = planes_.size();
        for (std::size_t j = 0; j < planes_.size(); ++j) {
            if (j == i || perpendicular_to(planes_[i].normal, planes_[j].normal)) {
                continue;
            }
            check_pair(std::min(i, j), std::max(i, j));
            if (partner < planes_.size()) {
                throw InputError(plane_name(i) + " is at right angles neither to " + plane_name(partner) + " nor to " +
                                 plane_name(j) +
                                 ": only two planes can be parallel or meet at another angle than 90 "
                                 "degrees; use a period, or a larger part of the scene");
            }
            partner = j;
        }
        return partner;
    }

    void check_pair(std::size_t i, std::size_t j) const {
        const Repetition::Plane &a = planes_[i], &b = planes_[j];
        const std::string both = plane_name(i) + " and " + plane_name(j);
        if (parallel_to(a.normal, b.normal)) {
            if (a.normal.dot(b.normal) > 0.0) {
                throw InputError(both + " face the same way: the scene is before one and behind the other; remove one");
            }
            if (!(a.normal.dot(b.point - a.point) > 0.0)) {
                throw InputError(both + " are parallel and face away from each other: turn their normals to the scene "
                                        "between them, or remove one");
            }
            return;
        }
        const double n = planes_at_edge(a.normal.dot(b.normal)), angle = std::numbers::pi / n;
        if (n > most_at_edge + 0.5) { // any large n is near a whole number
            throw InputError(both + " are nearly parallel, at an angle of " +
                             text_of(180.0 * std::numbers::inv_pi * angle) +
                             " degrees: make them parallel, or let them meet at 5 degrees at least");
        }
        if (!(n > 1.5 && std::abs(angle - std::numbers::pi / std::round(n)) <= fitting)) {
            throw InputError(both + " meet at an angle of " + text_of(180.0 * std::numbers::inv_pi * angle) +
                             " degrees: images fit together at 180 degrees divided by a whole number only (90, 60, "
                             "45, 36, ...)");
        }
    }

    /// What of a direction is at right angles to all before, as a unit vector.
    Vec3 free_part(Vec3 direction) const {
        for (const Vec3& known : frame_) {
            direction -= known.dot(direction) * known;
        }
        return direction.normalized();
    }

    void pair(const Vec3& first, Vec3& second, std::vector<Vec3>& own) const {
        if (parallel_to(first, second)) {
            second = -first;
            return;
        }
        const double angle = std::numbers::pi / std::round(planes_at_edge(first.dot(second)));
        Vec3 across = free_part(second);
        across = (across - first.dot(across) * first).normalized();
        second = -std::cos(angle) * first + std::sin(angle) * across;
        own.push_back(across);
    }

    void fit_period(std::size_t k) {
        const std::string name = "period " + std::to_string(k + 1);
        const double length = periods_[k].stableNorm();
        if (!(length > 0.0 && std::isfinite(length))) {
            throw InputError(name + " has no length, or one that is not finite");
        }
        const Vec3 along = periods_[k] / length;
        for (std::size_t i = 0; i < planes_.size(); ++i) {
            if (!perpendicular_to(along, planes_[i].normal)) {
                throw InputError(name + " is not at right angles to the normal of " + plane_name(i) +
                                 (parallel_to(along, planes_[i].normal)
                                      ? ": give the plane of symmetry half a period further on instead of the period"
                                      : ": the images do not fit together"));
            }
        }
        for (std::size_t j = 0; j < k; ++j) {
            if (!perpendicular_to(along, periods_[j].normalized())) {
                throw InputError(name + " is not at right angles to period " + std::to_string(j + 1) +
                                 ": give periods that are, of a larger cell if need be");
            }
        }
        const Vec3 fitted = free_part(along);
        periods_[k] = length * fitted;
        frame_.push_back(fitted);
    }

    std::vector<Repetition::Plane>& planes_;
    std::vector<Vec3>& periods_;
    std::vector<Vec3> frame_; ///< orthonormal: spanned by normals and periods that are in place
};

/// The corner of the mesh that is farthest along a direction.
struct Extreme {
    double along = 0.0;
    Index face = none; ///< number in the file
    Vec3 corner = Vec3::Zero();
};

Extreme farthest(const Mesh& mesh, const Vec3& direction) {
    Extreme extreme;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const double along = direction.dot(mesh.corner(t, k));
            if (extreme.face == none || along > extreme.along) {
                extreme = {along, mesh.original_face[t], mesh.corner(t, k)};
            }
        }
    }
    return extreme;
}

using NameOfFace = std::function<std::string(Index)>;

void add_plane(const Mesh& mesh, std::size_t i, const NameOfFace& name, Repetition& result) {
    const Repetition::Plane& plane = result.planes[i];
    const double offset = plane.normal.dot(plane.point);
    const Extreme behind = farthest(mesh, -plane.normal);
    const double depth = behind.along + offset;
    if (depth > Repetition::tolerance * mesh.diameter()) {
        throw InputError(name(behind.face) + " reaches " + coordinates(behind.corner) + ", " + text_of(depth) +
                         " m behind " + plane_name(i) + ", through " + coordinates(plane.point) + " with the normal " +
                         coordinates(plane.normal) +
                         ": remove what is behind the plane, or turn its normal to the side of the scene");
    }
    result.walls.push_back({plane.normal, offset, true, Vec3::Zero()});
}

void add_period(const Mesh& mesh, std::size_t k, const NameOfFace& name, Repetition& result) {
    const Vec3& period = result.periods[k];
    const double length = period.norm();
    const Vec3 along = period / length;
    const Extreme last = farthest(mesh, along), first = farthest(mesh, -along);
    const double low = -first.along, extent = last.along - low;
    if (extent > length + Repetition::tolerance * mesh.diameter()) {
        throw InputError(name(last.face) + " reaches " + coordinates(last.corner) + ", " + text_of(extent) +
                         " m from " + coordinates(first.corner) + " of " + name(first.face) + " along period " +
                         std::to_string(k + 1) + ", which is " + text_of(length) +
                         " m long: one period of the scene has to fit into it; remove what the neighbours repeat");
    }
    result.walls.push_back({along, low, false, period});
    result.walls.push_back({-along, -(low + length), false, -period});
    result.endless.push_back(along);
}

Repetition::Image reflection_in(const Repetition::Wall& wall) {
    return {Eigen::Matrix3d::Identity() - 2.0 * wall.normal * wall.normal.transpose(), 2.0 * wall.offset * wall.normal};
}

Repetition::Image composed(const Repetition::Image& outer, const Repetition::Image& inner) {
    return {outer.linear * inner.linear, outer(inner.offset)};
}

/// s, s t, s t s, ... of the reflections s and t: the cells that follow each other beyond the wall of s.
void add_chain(const Repetition::Wall& s, const Repetition::Wall& t, std::size_t length,
               std::vector<Repetition::Image>& images) {
    const Repetition::Image in_s = reflection_in(s), in_t = reflection_in(t);
    Repetition::Image image;
    for (std::size_t k = 0; k < length; ++k) {
        image = composed(image, k % 2 == 0 ? in_s : in_t);
        images.push_back(image);
    }
}

/// The images that the walls `i` and, if they belong together, `j` make.
std::vector<Repetition::Image> images_between(const Repetition::Wall& wall, const Repetition::Wall* other,
                                              std::size_t depth) {
    std::vector<Repetition::Image> images(1);
    if (other == nullptr) {
        images.push_back(reflection_in(wall));
    } else if (!wall.reflects) {
        for (std::size_t k = 1; k <= depth; ++k) {
            const Vec3 shift = static_cast<double>(k) * wall.shift;
            images.push_back({Eigen::Matrix3d::Identity(), shift});
            images.push_back({Eigen::Matrix3d::Identity(), -shift});
        }
    } else if (parallel_to(wall.normal, other->normal)) {
        add_chain(wall, *other, depth, images);
        add_chain(*other, wall, depth, images);
    } else {
        const auto n = static_cast<std::size_t>(std::lround(planes_at_edge(wall.normal.dot(other->normal))));
        add_chain(wall, *other, n, images); // the longest of either chain are the same
        add_chain(*other, wall, n - 1, images);
    }
    return images;
}

} // namespace

std::vector<Repetition::Image> Repetition::images(std::size_t depth) const {
    std::vector<Image> all(1);
    std::vector<char> done(walls.size(), 0);
    for (std::size_t i = 0; i < walls.size(); ++i) {
        if (done[i] != 0) {
            continue;
        }
        const Wall* other = nullptr;
        for (std::size_t j = i + 1; j < walls.size(); ++j) {
            if (!perpendicular_to(walls[i].normal, walls[j].normal)) {
                other = &walls[j];
                done[j] = 1;
            }
        }
        std::vector<Image> product;
        for (const Image& outer : all) {
            for (const Image& inner : images_between(walls[i], other, depth)) {
                product.push_back(composed(outer, inner));
            }
        }
        all = std::move(product);
    }
    return all;
}

void settle_repetition(Mesh& mesh, const NameOfFace& name) {
    Repetition& repetition = mesh.repetition;
    repetition.walls.clear();
    repetition.endless.clear();
    if (repetition.planes.empty() && repetition.periods.empty()) {
        return;
    }
    Fitting(repetition).fit();
    for (std::size_t i = 0; i < repetition.planes.size(); ++i) {
        add_plane(mesh, i, name, repetition);
        for (std::size_t j = 0; j < i; ++j) {
            if (parallel_to(repetition.planes[i].normal, repetition.planes[j].normal)) {
                repetition.endless.push_back(repetition.planes[j].normal);
            }
        }
    }
    for (std::size_t k = 0; k < repetition.periods.size(); ++k) {
        add_period(mesh, k, name, repetition);
    }
    mesh.convex = false;
    mesh.shading = ShadingNormals(mesh);
}

void settle_repetition(Mesh& mesh) {
    settle_repetition(mesh, [](Index face) { return "face " + std::to_string(face); });
}

double reach_out_of(const Mesh& mesh) {
    const Repetition& repetition = mesh.repetition;
    double reach = 2.0 * mesh.diameter();
    const Vec3 centre = 0.5 * (mesh.low + mesh.high);
    for (const Repetition::Wall& wall : repetition.walls) {
        reach += 2.0 * std::abs(wall.height(centre)) + mesh.diameter();
    }
    return repetition.endless.empty() ? reach : series * reach;
}

} // namespace difusa
