// Sampler `view-driven` (T 4.2.6): sites where an observer looks, and where the light that reaches those surfaces comes
// from. Rays through a regular grid from the observer give the first sites; then, a number of times, every site sends
// rays in directions near its normal, whose hits are added. A hit closer to a site than the spacing is discarded on
// arrival. Unlike `poisson-disk` it leaves surfaces that nothing looked at without sites.
//
// Without a given observer, one is chosen: the centre of the scene looking all around, or, if no front is visible from
// there, a point outside the bounding box looking at its centre.
#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/discretisation/sampler.h>
#include <difusa/discretisation/site_grid.h>
#include <difusa/plugin/plugin.h>
#include <difusa/rays/direction_pool.h>
#include <difusa/rays/visibility.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

namespace {

using difusa::Dart;
using difusa::Hit;
using difusa::Mesh;
using difusa::Ray;
using difusa::SiteGrid;
using difusa::SurfacePoint;
using difusa::Vec3;

constexpr double all_around = 360.0;

struct Observer {
    Vec3 eye;
    Vec3 target;
    double fov; ///< degrees across; 360: all around
};

std::optional<Vec3> point_of(const difusa::Parameters& parameters, const char* name) {
    const std::vector<double> v = parameters.vector(name);
    if (v.empty()) {
        return std::nullopt;
    }
    if (v.size() != 3) {
        throw difusa::UsageError("sampler view-driven: " + std::string(name) + " takes three numbers, x/y/z");
    }
    return Vec3(v[0], v[1], v[2]);
}

/// The sites so far. Rays are cast many at a time, whose hits become sites in the order of the rays: as if they were
/// cast one at a time.
class Sites {
  public:
    Sites(const Mesh& mesh, const difusa::Visibility& visibility, double spacing, std::size_t limit,
          const difusa::Execution& execution)
        : mesh_(mesh), visibility_(visibility), execution_(execution), grid_(mesh, spacing, limit) {}

    std::size_t count() const { return grid_.sites().size(); }
    SurfacePoint at(std::size_t i) const { return grid_.sites()[i]; }
    std::vector<SurfacePoint> take() { return grid_.take(); }

    void add(const Ray& ray) {
        rays_.push_back(ray);
        if (rays_.size() == most_rays) {
            cast();
        }
    }

    /// How many more rays there will be, about.
    void expect(std::size_t rays) { expected_ = cast_ + rays; }

    /// Casts the rays added since the last time.
    void cast() {
        execution_.check();
        cast_ += rays_.size();
        if (execution_.progress != nullptr) {
            execution_.progress->advance(std::min(1.0, static_cast<double>(cast_) / static_cast<double>(expected_)));
        }
        std::vector<Hit> hits(rays_.size());
        const difusa::Execution silent = execution_.silent(); // one of many loops
        difusa::parallel_for(rays_.size(), 4096, silent, [&](std::size_t begin, std::size_t end, unsigned) {
            visibility_.first_hits(std::span(rays_).subspan(begin, end - begin),
                                   std::span(hits).subspan(begin, end - begin));
        });
        rays_.clear();
        std::vector<Dart> darts; // earliest first
        for (const Hit& hit : hits) {
            if (hit.face != difusa::none && hit.front) {
                darts.push_back({mesh_.at(hit.face, hit.u, hit.v), darts.size()});
            }
        }
        grid_.insert(darts, execution_);
    }

  private:
    static constexpr std::size_t most_rays = std::size_t{1} << 17U;
    const Mesh& mesh_;
    const difusa::Visibility& visibility_;
    const difusa::Execution& execution_;
    SiteGrid grid_;
    std::vector<Ray> rays_;
    std::size_t cast_ = 0, expected_ = 1;
};

class ViewDriven final : public difusa::Sampler {
  public:
    explicit ViewDriven(const difusa::Parameters& parameters)
        : eye_(point_of(parameters, "eye")), target_(point_of(parameters, "target")), fov_(parameters.real("fov")),
          grid_(static_cast<std::size_t>(parameters.integer("grid"))),
          passes_(static_cast<std::size_t>(parameters.integer("passes"))),
          secondary_(static_cast<std::size_t>(parameters.integer("secondary"))), spread_(parameters.real("spread")) {
        if (target_ && !eye_) {
            throw difusa::UsageError("sampler view-driven: a target needs an eye, eye=x/y/z");
        }
        if (eye_ && target_ && *eye_ == *target_) {
            throw difusa::UsageError("sampler view-driven: eye and target are the same point");
        }
    }

    bool needs_visibility() const override { return true; }

    std::vector<SurfacePoint> sample(const Mesh& mesh, const difusa::Visibility* visibility, double spacing,
                                     std::size_t limit, difusa::RandomStream stream,
                                     const difusa::Execution& execution) const override {
        DIFUSA_REQUIRE(visibility != nullptr);
        Sites sites(mesh, *visibility, spacing, limit, execution);
        for (const Observer& observer : observers(mesh)) {
            sites.expect(grid_ * grid_);
            add_primary_rays(observer, sites);
            if (sites.count() > 0) {
                break;
            }
        }
        if (sites.count() == 0) {
            throw difusa::InputError("sampler view-driven: the observer sees no front of any face; give another "
                                     "eye=x/y/z and target=x/y/z, check the orientation of the faces, or use "
                                     "--sampler poisson-disk");
        }
        for (std::size_t pass = 0; pass < passes_; ++pass) {
            const std::size_t before = sites.count();
            sites.expect((passes_ - pass) * before * secondary_);
            for (std::size_t i = 0; i < before; ++i) {
                add_secondary_rays(sites.at(i), stream, sites);
            }
            sites.cast();
        }
        return sites.take();
    }

  private:
    std::vector<Observer> observers(const Mesh& mesh) const {
        const Vec3 centre = 0.5 * (mesh.low + mesh.high);
        if (eye_) {
            return {{*eye_, target_.value_or(*eye_ + Vec3::UnitX()), target_ ? fov_ : all_around}};
        }
        return {{centre, centre + Vec3::UnitX(), all_around},
                {centre + mesh.diameter() * Vec3(0.9, -1.2, 0.8), centre, fov_}};
    }

    /// One ray through the centre of each cell: of a square in front of the observer, or of the sphere of directions
    /// divided into cells of equal solid angle.
    void add_primary_rays(const Observer& observer, Sites& sites) const {
        const Vec3 forward = (observer.target - observer.eye).normalized();
        Vec3 right, up;
        difusa::tangents(forward, right, up);
        const double half = std::tan(std::min(observer.fov, 179.0) * std::numbers::pi / 360.0);
        for (std::size_t row = 0; row < grid_; ++row) {
            for (std::size_t column = 0; column < grid_; ++column) {
                const double a = (static_cast<double>(column) + 0.5) / static_cast<double>(grid_);
                const double b = (static_cast<double>(row) + 0.5) / static_cast<double>(grid_);
                Vec3 direction;
                if (observer.fov >= all_around) {
                    const double z = 2.0 * b - 1.0, radius = std::sqrt(1.0 - z * z);
                    direction = Vec3(radius * std::cos(2.0 * std::numbers::pi * a),
                                     radius * std::sin(2.0 * std::numbers::pi * a), z);
                } else {
                    direction = forward + half * ((2.0 * a - 1.0) * right + (2.0 * b - 1.0) * up);
                }
                sites.add({observer.eye, direction, difusa::none});
            }
        }
        sites.cast();
    }

    /// Directions whose angle to the normal is at most `spread`, uniform in solid angle.
    void add_secondary_rays(const SurfacePoint& x, difusa::RandomStream& stream, Sites& sites) const {
        Vec3 t, b;
        difusa::tangents(x.normal, t, b);
        const double least_cosine = std::cos(spread_ * std::numbers::pi / 180.0);
        for (std::size_t i = 0; i < secondary_; ++i) {
            const double z = 1.0 - stream.uniform() * (1.0 - least_cosine);
            const double angle = 2.0 * std::numbers::pi * stream.uniform();
            const double radius = std::sqrt(std::max(0.0, 1.0 - z * z));
            sites.add({x.position, radius * std::cos(angle) * t + radius * std::sin(angle) * b + z * x.normal, x.face});
        }
    }

    std::optional<Vec3> eye_, target_;
    double fov_;
    std::size_t grid_, passes_, secondary_;
    double spread_;
};

using ParameterType = difusa::ParameterSpec::Type;

} // namespace

DIFUSA_PLUGIN(
    sampler, "view-driven", ViewDriven, "Sites where an observer looks and where the light there comes from (T 4.2.6).",
    {{"eye", ParameterType::vector, "", "observer x/y/z; chosen automatically if omitted", 0, 0, {}},
     {"target", ParameterType::vector, "", "point looked at, x/y/z; all around the eye if omitted", 0, 0, {}},
     {"fov", ParameterType::real, "60", "degrees across the square view", 1.0, 179.0, {}},
     {"grid", ParameterType::integer, "256", "primary rays across the view", 1, 8192, {}},
     {"passes", ParameterType::integer, "4", "number of times all sites send secondary rays", 0, 64, {}},
     {"secondary", ParameterType::integer, "8", "secondary rays per site and pass", 1, 1024, {}},
     {"spread", ParameterType::real, "60", "largest angle of a secondary ray to the normal, degrees", 0.0, 89.9, {}}})
