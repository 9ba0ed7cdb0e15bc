// Visibility `cgal`: a CGAL AABB tree over the mesh's own index arrays, in double precision: the reference. CGAL builds
// the tree and traverses it, nearer child first; boxes and triangles are tested here, so that a subtree beyond the
// nearest hit so far is not entered, and triangles are intersected without gaps along their edges.
#include <difusa/core/error.h>
#include <difusa/plugin/plugin.h>
#include <difusa/rays/brute_force.h>
#include <difusa/rays/visibility.h>
#include <difusa/rays/watertight.h>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Simple_cartesian.h>

#include <boost/iterator/counting_iterator.hpp>

#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace {

using difusa::Index;
using difusa::Mesh;
using difusa::Vec3;
using Kernel = CGAL::Simple_cartesian<double>;

/// A triangle of the mesh by its number; the coordinates remain in the mesh.
class Primitive {
  public:
    using Id = Index;
    using Point = Kernel::Point_3;
    using Datum = Kernel::Triangle_3;
    using Shared_data = const Mesh*;

    Primitive(boost::counting_iterator<Id> number, const Mesh* /*mesh*/) : id_(*number) {}
    const Id& id() const { return id_; }
    static Shared_data construct_shared_data(const Mesh* mesh) { return mesh; }
    Datum datum(const Mesh* mesh) const { return {point(mesh, 0), point(mesh, 1), point(mesh, 2)}; }
    Point reference_point(const Mesh* mesh) const { return point(mesh, 0); }

  private:
    Point point(const Mesh* mesh, int k) const {
        const Vec3& p = mesh->corner(id_, k);
        return {p[0], p[1], p[2]};
    }
    Id id_;
};

using Traits = CGAL::AABB_traits<Kernel, Primitive>;
using Tree = CGAL::AABB_tree<Traits>;
using Node = CGAL::AABB_node<Traits>;

/// Where the ray [0, limit] enters a box, or infinity if it misses it. Boxes are widened on all sides by the rounding
/// of the triangle test (`WatertightRay::rounding`): of the two triangles sharing an edge it may find the one whose box
/// the exact ray misses. The far end is additionally widened by the rounding of the three products (Ize, "Robust BVH
/// Ray Traversal", JCGT 2(2), 2013). No box is thus missed due to rounding.
class BoxTest {
  public:
    BoxTest(const Mesh& mesh, const Vec3& origin, const Vec3& direction)
        : margin_(difusa::WatertightRay::rounding(origin, mesh.low, mesh.high)) {
        for (int axis = 0; axis < 3; ++axis) {
            origin_[axis] = origin[axis];
            inverse_[axis] = 1.0 / direction[axis];
        }
    }
    double entry(const CGAL::Bbox_3& box, double limit) const {
        double enter = 0.0, leave = limit;
        for (int axis = 0; axis < 3; ++axis) {
            const double a = ((box.min)(axis)-origin_[axis] - margin_) * inverse_[axis];
            const double b = ((box.max)(axis)-origin_[axis] + margin_) * inverse_[axis];
            // 0 times infinity, NaN, only arises if the ray runs along a face of the widened box, outside the box
            // itself: either result of the comparisons below is correct.
            const double low = a < b ? a : b, high = (a < b ? b : a) * (1.0 + 0x1p-50);
            enter = low > enter ? low : enter;
            leave = high < leave ? high : leave;
        }
        return enter <= leave ? enter : std::numeric_limits<double>::infinity();
    }

  private:
    double margin_;
    double origin_[3];
    double inverse_[3];
};

/// CGAL's traversal traits for the first hit. The limit shrinks with each hit.
class FirstHitTraits {
  public:
    using Priority = double;
    FirstHitTraits(const Mesh& mesh, const difusa::OwnPlane& own_plane, const difusa::Ray& ray)
        : mesh_(mesh), own_plane_(own_plane), ray_(ray), box_(mesh, ray.origin, ray.direction),
          watertight_(ray.origin, ray.direction),
          rise_(ray.face == difusa::none ? 0.0 : std::abs(mesh.normals[ray.face].dot(ray.direction))),
          slack_(own_plane.slack(ray.direction)) {}

    bool go_further() const { return true; }
    bool do_intersect(const difusa::Ray& /*ray*/, const Node& node) const {
        return box_.entry(node.bbox(), hit_.t + slack_) < std::numeric_limits<double>::infinity();
    }
    std::pair<bool, Priority> do_intersect_with_priority(const difusa::Ray& /*ray*/, const Node& node) const {
        const double entry = box_.entry(node.bbox(), hit_.t + slack_);
        return {entry < std::numeric_limits<double>::infinity(), -entry};
    }
    void intersection(const difusa::Ray& /*ray*/, const Primitive& primitive) {
        const Index f = primitive.id();
        difusa::WatertightRay::Meeting m;
        if (watertight_.meets(mesh_.corner(f, 0), mesh_.corner(f, 1), mesh_.corner(f, 2), m) && m.t >= 0.0 &&
            m.t <= hit_.t + slack_ && !own_plane_.exempts(ray_.face, f, m.t * rise_)) {
            const difusa::Hit hit{f, m.front, false, m.t, m.u, m.v};
            hit_ = difusa::comes_before(hit, hit_, slack_) ? hit : hit_;
        }
    }
    const difusa::Hit& hit() const { return hit_; }

  private:
    const Mesh& mesh_;
    const difusa::OwnPlane& own_plane_;
    const difusa::Ray& ray_;
    BoxTest box_;
    difusa::WatertightRay watertight_;
    double rise_, slack_;
    difusa::Hit hit_;
};

/// CGAL's traversal traits for "does anything block the segment?".
class AnyBlockerTraits {
  public:
    AnyBlockerTraits(const Mesh& mesh, const difusa::OwnPlane& own_plane, const difusa::Segment& segment)
        : mesh_(mesh), own_plane_(own_plane), segment_(segment), box_(mesh, segment.from, segment.to - segment.from),
          watertight_(segment.from, segment.to - segment.from) {}

    bool go_further() const { return !blocked_; }
    bool do_intersect(const difusa::Segment& /*segment*/, const Node& node) const {
        return box_.entry(node.bbox(), 1.0) < std::numeric_limits<double>::infinity();
    }
    void intersection(const difusa::Segment& /*segment*/, const Primitive& primitive) {
        const Index f = primitive.id();
        difusa::WatertightRay::Meeting m;
        blocked_ = blocked_ || (watertight_.meets(mesh_.corner(f, 0), mesh_.corner(f, 1), mesh_.corner(f, 2), m) &&
                                difusa::blocks(segment_, mesh_, own_plane_, f, m.t));
    }
    bool blocked() const { return blocked_; }

  private:
    const Mesh& mesh_;
    const difusa::OwnPlane& own_plane_;
    const difusa::Segment& segment_;
    BoxTest box_;
    difusa::WatertightRay watertight_;
    bool blocked_ = false;
};

class CgalVisibility final : public difusa::Visibility {
  public:
    explicit CgalVisibility(const difusa::Parameters& /*parameters*/) {}

    void build(const Mesh& mesh) override {
        mesh_ = &mesh;
        own_plane_.emplace(mesh);
        using Number = boost::counting_iterator<Index>;
        tree_.insert(Number(0), Number(static_cast<Index>(mesh.triangles.size())), mesh_);
        tree_.build();
    }

    void first_hits(std::span<const difusa::Ray> rays, std::span<difusa::Hit> hits) const override {
        DIFUSA_REQUIRE(rays.size() == hits.size());
        for (std::size_t i = 0; i < rays.size(); ++i) {
            FirstHitTraits search(*mesh_, *own_plane_, rays[i]);
            tree_.traversal_with_priority(rays[i], search);
            hits[i] = search.hit();
        }
    }

    void occluded(std::span<const difusa::Segment> segments, std::span<std::uint8_t> blocked) const override {
        DIFUSA_REQUIRE(segments.size() == blocked.size());
        for (std::size_t i = 0; i < segments.size(); ++i) {
            AnyBlockerTraits search(*mesh_, *own_plane_, segments[i]);
            tree_.traversal(segments[i], search);
            blocked[i] = search.blocked() ? 1 : 0;
        }
    }

  private:
    const Mesh* mesh_ = nullptr;
    std::optional<difusa::OwnPlane> own_plane_;
    Tree tree_;
};

} // namespace

DIFUSA_PLUGIN(visibility, "cgal", CgalVisibility, "CGAL AABB tree in double precision: the reference.", {})
