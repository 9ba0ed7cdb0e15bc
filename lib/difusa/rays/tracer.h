// Ray casting against a surface, and the rays that a point sends out, on over mirrors.
#pragma once

#include <difusa/core/random.h>
#include <difusa/mesh/mesh.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/direction_pool.h>
#include <difusa/rays/visibility.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace difusa {

/// A mesh and the engine built over it. A small value type that keeps references to both.
class Tracer {
  public:
    Tracer(const Mesh& mesh, const Visibility& engine) : mesh_(&mesh), engine_(&engine) {}

    const Mesh& mesh() const { return *mesh_; }
    const Visibility& engine() const { return *engine_; }

    /// False if the surface is convex, so that nothing blocks the view between two of its points.
    bool can_block() const { return !mesh_->convex; }

    void first_hits(std::span<const Ray> rays, std::span<Hit> hits) const { engine_->first_hits(rays, hits); }

    /// Segments may lead out of the scene. Returns the number cast.
    std::size_t occluded(std::span<const Segment> segments, std::span<std::uint8_t> blocked) const {
        engine_->occluded(segments, blocked);
        return segments.size();
    }

    /// The same for segments between points of the surface; if it is convex, none is blocked.
    std::size_t occluded_between(std::span<const Segment> segments, std::span<std::uint8_t> blocked) const {
        if (!can_block()) {
            std::fill(blocked.begin(), blocked.end(), std::uint8_t{0});
            return 0;
        }
        return occluded(segments, blocked);
    }

  private:
    const Mesh* mesh_;
    const Visibility* engine_;
};

/// The ray that goes on where a ray of this direction has hit a mirror.
inline Ray reflected_ray(const Mesh& mesh, const Hit& hit, const Vec3& direction) {
    const SurfacePoint from = inset(mesh, mesh.at(hit.face, hit.u, hit.v));
    return {from.position, mirrored(direction, mesh.normals[hit.face]), from.face};
}

/// A ray that goes on where a ray of this direction has hit a glossy surface, drawn from its lobe around the normal n
/// (unit; that of the face, or a shading normal), and what it is to be multiplied with: 0 if it leads below the face.
struct DrawnRay {
    Ray ray;
    Rgb colour = Rgb::Zero();
};
inline DrawnRay drawn_ray(const Mesh& mesh, const Hit& hit, const Vec3& direction, const Vec3& n,
                          RandomStream& stream) {
    const Index kind = mesh.glossy.kind(hit.face);
    const double u = stream.uniform(), v = stream.uniform(), w = stream.uniform();
    const GlossyLobe::Draw drawn = mesh.glossy.lobe_of(kind).draw(n, -direction.normalized(), {u, v, w});
    const bool above = mesh.normals[hit.face].dot(drawn.direction) > 0.0;
    const SurfacePoint from = inset(mesh, mesh.at(hit.face, hit.u, hit.v));
    return {{from.position, drawn.direction, from.face},
            (above ? drawn.weight : 0.0) * mesh.glossy.kinds[kind].reflectance};
}

/// What a ray meets that was reflected by one mirror or glossy surface, or more.
struct ReflectedHit {
    Hit hit;                  ///< t is that of the last part of its way
    Vec3 direction;           ///< of that part
    double weight = 0.0;      ///< of the ray
    Rgb colour = Rgb::Ones(); ///< product of the reflectances of these, and of the weights of drawn directions
    bool cut_off = false;     ///< it should have been reflected once more than Mirrors::most
};

/// A ray that has met a glossy surface. What comes to it from other surfaces is followed; light that has no surface is
/// for the caller to add.
struct GlossyHit {
    Hit hit;
    Vec3 direction; ///< of the ray that met it
    double weight = 0.0;
    Rgb colour = Rgb::Ones(); ///< product of all reflectances on the way, and of this one
};

/// What a point sees: weighted rays and their hits. Scratch of one thread; keeps references. Derived classes choose the
/// rays.
///
/// A ray that meets the front of a mirror goes on from there: `for_each` calls the mirror like any surface (it may also
/// reflect diffusely, or emit), and `for_each_in_mirrors` what is seen in it. Where the caller gives random numbers, a
/// ray that meets the front of a glossy surface goes on likewise, in a direction drawn from the lobe: what is seen
/// there is, in the mean, what the surface reflects.
class Sight {
  public:
    std::size_t count() const { return rays_.size(); }

    /// For each ray calls `on_front(hit, weight)`, `on_sky(direction, weight)` or, if it hits the back of a face or is
    /// cut off, neither.
    template <class OnFront, class OnSky> void for_each(const OnFront& on_front, const OnSky& on_sky) const {
        for (std::size_t d = 0; d < hits_.size(); ++d) {
            if (hits_[d].face == none) {
                if (!hits_[d].cut_off) {
                    on_sky(rays_[d].direction, weights_[d]);
                }
            } else if (hits_[d].front) {
                on_front(hits_[d], weights_[d]);
            }
        }
    }

    /// Calls `on_ray(hit, direction, weight)` for each.
    template <class OnRay> void for_each_ray(const OnRay& on_ray) const {
        for (std::size_t d = 0; d < hits_.size(); ++d) {
            on_ray(hits_[d], rays_[d].direction, weights_[d]);
        }
    }

    /// The rays that have met glossy surfaces, if these are followed.
    std::span<const GlossyHit> glossy_hits() const { return glossy_hits_; }

    /// Total weight of the rays that are cut off in an infinite series of cells (Hit::cut_off).
    double cut_off() const {
        double sum = 0.0;
        for (std::size_t d = 0; d < hits_.size(); ++d) {
            sum += hits_[d].cut_off ? weights_[d] : 0.0;
        }
        return sum;
    }

    /// For each hit after a mirror calls `on_front(hit, weight, colour)`, `on_sky(direction, weight, colour)` or
    /// `on_loss(weight, colour, cut_off)`, if it hits the back of a face or is cut off.
    template <class OnFront, class OnSky, class OnLoss>
    void for_each_in_mirrors(const OnFront& on_front, const OnSky& on_sky, const OnLoss& on_loss) const {
        for (const ReflectedHit& each : reflected_) {
            if (each.cut_off) {
                on_loss(each.weight, each.colour, true);
            } else if (each.hit.face == none) {
                on_sky(each.direction, each.weight, each.colour);
            } else if (each.hit.front) {
                on_front(each.hit, each.weight, each.colour);
            } else {
                on_loss(each.weight, each.colour, false);
            }
        }
    }

  protected:
    explicit Sight(const Tracer& tracer) : tracer_(tracer) {}

    /// If x, at which `rays_` start, has a shading normal, directions below the plane of its face are mirrored to above
    /// it, since the smooth surface described by that normal does not block them.
    void lift(const SurfacePoint& x);

    /// Casts `rays_`, which have `weights_`, and follows them over mirrors and, with random numbers, glossy surfaces.
    void cast(RandomStream* stream = nullptr);

    const Tracer tracer_;
    std::vector<Ray> rays_;
    std::span<const double> weights_;

  private:
    void follow_reflections(RandomStream* stream);
    void reflect(const Hit& hit, const Vec3& direction, double weight, const Rgb& colour, RandomStream* stream);

    std::vector<Hit> hits_;
    std::vector<ReflectedHit> reflected_;
    std::vector<GlossyHit> glossy_hits_;
    std::vector<Ray> reflected_rays_; ///< of one generation
    std::vector<Hit> reflected_hits_;
};

/// The rays of one hemisphere.
class Hemisphere final : public Sight {
  public:
    Hemisphere(const Tracer& tracer, const DirectionPool& pool) : Sight(tracer), pool_(pool) {
        rays_.resize(pool.count());
    }

    /// Casts the rays of point number `number` (DirectionPool::rays) from x, or from just beside it if it is on an
    /// edge. Glossy surfaces are followed if there is a stream.
    void look(const SurfacePoint& x, std::size_t number, RandomStream* stream = nullptr) {
        aim(x, number);
        cast(stream);
    }

    /// Only makes these rays.
    void aim(const SurfacePoint& x, std::size_t number) {
        weights_ = pool_.rays(inset(tracer_.mesh(), x), number, rays_);
        lift(x);
    }

    std::span<const Ray> rays() const { return rays_; }
    std::span<const double> weights() const { return weights_; }

  private:
    const DirectionPool& pool_;
};

/// Any rays.
class ChosenRays final : public Sight {
  public:
    explicit ChosenRays(const Tracer& tracer) : Sight(tracer) {}

    /// The weights must outlive what is asked of this.
    void look(std::span<const Ray> rays, std::span<const double> weights) {
        rays_.assign(rays.begin(), rays.end());
        weights_ = weights;
        cast();
    }
};

} // namespace difusa
