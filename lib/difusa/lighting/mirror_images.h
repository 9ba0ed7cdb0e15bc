// The sharp sources of a scene as they are seen in mirrors. A plane mirror shows an image of each source behind its
// plane, which is visible through the outline of the mirror and sends light like the source itself; a chain of mirrors
// shows images of images. Curved mirrors are meshes, each face of which is a plane mirror.
#pragma once

#include <difusa/core/random.h>
#include <difusa/lighting/light_shares.h>
#include <difusa/lighting/shadow_batches.h>
#include <difusa/rays/tracer.h>
#include <difusa/scene/scene.h>

#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace difusa {

class MirrorImages {
  public:
    /// All sources are followed over chains of mirrors to the same length: at most Mirrors::most, and while there are
    /// no more than this many images of suns and point lights, and of area lights. Over one mirror they always are.
    static constexpr std::size_t most_images = 8192;

    /// Suns and point lights with the numbers of their sets; `lamps`: triangles of area lights. Keeps references to the
    /// scene and what the tracer refers to.
    MirrorImages(const Scene& scene, const Tracer& tracer, std::span<const std::pair<Sun, Index>> suns,
                 std::span<const std::pair<PointLight, Index>> points, std::span<const Index> lamps,
                 std::span<const Index> set_of_material);

    /// False: no mirror shows a source.
    bool any() const { return !points_.empty() || !lamps_.empty(); }

    /// Mirrors in a row over which every source was followed; longer chains are left out if `is_complete` is false.
    std::size_t followed() const { return followed_; }
    bool is_complete() const { return complete_; }

    /// About as many rays as `sample` casts for a place that sees all images.
    std::size_t rays_per_sample() const { return 2 * (points_.size() + (lamps_.empty() ? 0 : 1)); }

    /// An upper bound on the rays that `irradiance` casts for a point, outside or inside of penumbras.
    std::size_t rays_per_point(std::size_t samples, bool penumbra) const {
        return 2 * (points_.size() * (extended_ ? ShadowBatches::batches * samples_of_batch(samples) : 1) +
                    (lamps_.empty() ? 0 : shadow_batches(samples).all_rays(penumbra)));
    }

    /// A visible part of the image of an area light.
    struct Part {
        std::array<Vec3, 3> corner;
        Index lamp = none;
        double form_factor = 0.0;
        double light = 0.0;    ///< mean irradiance from it, if nothing is in the way
        std::size_t share = 0; ///< in `shares`
        double below = 0.0;    ///< LightShares::divide
        double factor = 1.0;
    };
    struct Worker {
        std::vector<Index> candidates; ///< images of area lights that may be seen
        std::vector<Part> parts;
        LightShares shares;
        Rgb variance = Rgb::Zero(); ///< of the last `irradiance`, as its paths tell it, W²/m⁴
        std::size_t cast = 0;
        bool near = false; ///< `sample`: places among or between the last ones may see images, whether these do or not
    };

    /// Adds what x receives from all images, in W/m², to H[set]: suns and point lights by one path each (`samples` of
    /// them where they have an extent), area lights by the form factors of what of their images the outlines of the
    /// mirrors show, times the share of paths to them that is not blocked, of which there are `samples` or more
    /// (lighting/shadow_batches.h).
    void irradiance(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker,
                    std::span<Rgb> H) const;

    /// Unbiased estimates of the same at each x, H[i #sets + set], with one path for each image of a sun or point light
    /// and one for all images of area lights. The contribution of suns and point lights is also added to
    /// `from_outside`, #x unless it is empty. Quickest for places close to each other.
    void sample(std::span<const SurfacePoint> x, RandomStream& stream, Worker& worker, std::span<Rgb> H,
                std::span<Rgb> from_outside) const;

  private:
    /// The faces of mirrors that lie in one plane, n·p = offset, and a ball around them.
    struct Plane {
        Vec3 normal = Vec3::UnitZ(), centre = Vec3::Zero();
        double offset = 0.0, radius = 0.0;
        std::vector<Index> faces;
        Rgb colour = Rgb::Zero(); ///< mean reflectance
        double height(const Vec3& p) const { return normal.dot(p) - offset; }
        /// The linear part of the reflection in the plane, to which `shift` is added.
        Eigen::Matrix3d reflection() const { return Eigen::Matrix3d::Identity() - 2.0 * normal * normal.transpose(); }
        Vec3 shift() const { return 2.0 * offset * normal; }
    };
    /// Reflections one after another, p -> linear p + offset; the planes are in the order in which a point sees them.
    struct Chain {
        std::vector<Index> planes;
        Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
        Vec3 offset = Vec3::Zero();
        Rgb colour = Rgb::Ones(); ///< product of the colours of the planes
        Vec3 operator()(const Vec3& p) const { return linear * p + offset; }
    };
    /// Of a sun, where `at` is the direction towards it, or of a point light.
    struct PointImage {
        Chain chain;
        Vec3 at;
        Index source = none;
        bool is_sun = false;
    };
    struct LampImage {
        Chain chain;
        std::vector<Vec3> polygon; ///< counterclockwise seen from its front
        Vec3 centre = Vec3::Zero();
        double radius = 0.0;
        Index triangle = none;
        /// The faces of each plane of the chain as they are seen, corner by corner; none where they are too many, and
        /// paths alone decide.
        std::vector<std::vector<std::array<Vec3, 3>>> windows;
        bool has_all_windows = true;
    };

    static ShadowBatches shadow_batches(std::size_t samples) { return {samples, 1, 8}; }
    /// For images of suns and luminaires.
    static std::size_t samples_of_batch(std::size_t samples) {
        return std::max<std::size_t>(2, samples / ShadowBatches::batches);
    }

    void find_planes();
    bool see_each_other(const Plane& a, const Plane& b) const;
    Chain before(Index plane, const Chain& chain) const;
    void follow_sources();
    template <class Image> void add_images(std::vector<Image>& images);
    /// The image of an image in one more mirror; none if that is behind the mirror.
    std::optional<PointImage> in_mirror(const PointImage& source, Index plane) const;
    std::optional<LampImage> in_mirror(const LampImage& source, Index plane) const;
    void add_windows(LampImage& image) const;

    bool may_show(const Plane& plane, const Vec3& x, double spread, const Vec3& target, double radius) const;
    bool may_show(const PointImage& image, const Vec3& x, double spread) const;
    bool shows_place(const Plane& plane, const Vec3& x, const Vec3& way, bool endless) const;
    /// The colour of the mirrors on the way from `from` to the image `target` (a direction if `source` is null), zero
    /// if it is blocked. `last`: the direction of its last part.
    Rgb follow(const SurfacePoint& from, const Chain& chain, const Vec3& target, const Vec3* source, Index source_face,
               Vec3& last, Worker& worker) const;
    bool is_extended(const PointImage& image) const;
    double radius(const PointImage& image) const; ///< of a ball around the source of a point light
    Rgb light_of(const PointImage& image, const SurfacePoint& x, const SurfacePoint& from,
                 const std::array<double, 2>& place, Worker& worker) const;
    /// For each image of a sun or luminaire that has an extent, paths are cast in `batches` of `samples`.
    void add_points(const SurfacePoint& x, std::size_t batches, std::size_t samples, RandomStream& stream,
                    Worker& worker, std::span<Rgb> H, Rgb* from_outside) const;
    void find_candidates(const Vec3& x, double spread, Worker& worker) const;
    void collect(const SurfacePoint& x, Worker& worker) const;
    void sample_lamps(const SurfacePoint& x, RandomStream& stream, Worker& worker, std::span<Rgb> H) const;
    void look_through(const LampImage& image, std::size_t window, Index lamp, const SurfacePoint& x,
                      const std::vector<Vec3>& polygon, Worker& worker) const;
    /// A batch of paths to the parts of images, spread over them and their areas by `start`, added to
    /// `worker.shares`.
    void cast_batch(const SurfacePoint& x, const SurfacePoint& from, std::size_t paths,
                    const std::array<double, 3>& start, Worker& worker) const;
    void add_part(const std::vector<Vec3>& polygon, Index lamp, const SurfacePoint& x, Worker& worker) const;
    struct Sampled {
        Rgb unblocked = Rgb::Zero(), seen = Rgb::Zero(); ///< irradiance over the probability
    };
    Sampled sample_part(const Part& part, const SurfacePoint& x, const SurfacePoint& from, double u, double v,
                        Worker& worker) const;
    const Rgb& emission(const LampImage& lamp) const {
        return scene_.materials[scene_.mesh.material[lamp.triangle]].emission;
    }
    /// What the mirrors leave of it.
    Rgb light(const LampImage& lamp) const { return lamp.chain.colour * emission(lamp); }
    Index set_of(const LampImage& lamp) const { return set_of_material_[scene_.mesh.material[lamp.triangle]]; }

    const Scene& scene_;
    Tracer tracer_;
    std::vector<std::pair<Sun, Index>> suns_;
    std::vector<std::pair<PointLight, Index>> point_lights_;
    std::vector<Index> lamp_triangles_, set_of_material_;
    std::vector<Plane> planes_;
    std::vector<Index> plane_of_face_; ///< #T
    std::vector<PointImage> points_;
    std::vector<LampImage> lamps_;
    bool extended_ = false; ///< some sun or luminaire has an extent
    double reach_;          ///< leads out of the scene from any of its points
    double rounding_;       ///< of positions
    std::size_t followed_ = 0;
    bool complete_ = true;
};

} // namespace difusa
