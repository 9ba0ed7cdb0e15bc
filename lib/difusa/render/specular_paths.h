// Rays from the eye, and what goes on from them over mirrors and glossy surfaces.
#pragma once

#include <difusa/core/random.h>
#include <difusa/rays/tracer.h>

#include <cstddef>
#include <vector>

namespace difusa {

/// What a ray from the eye shows: its first hit, or with `cull_backs` its first hit on a front.
Hit first_shown(const Mesh& mesh, const Visibility& visibility, Ray ray, bool cull_backs);

/// What a mirror or a glossy surface shows, and the colour of those on the way.
struct SeenInMirror {
    Hit hit;
    Vec3 direction; ///< in which it is seen
    Rgb colour = Rgb::Ones();
};

/// Where a glossy surface is seen: what it reflects of lights that have no surface is still to be added.
struct SeenGloss {
    SurfacePoint at;
    Index kind = none; ///< in GlossySurfaces::kinds
    Vec3 direction;
    Rgb colour = Rgb::Ones();
};

/// Goes on from what rays from the eye have hit.
class SpecularPaths {
  public:
    /// `glossy_rays`: where a glossy surface is met first. Keeps references.
    SpecularPaths(const Mesh& mesh, const Visibility& visibility, std::size_t glossy_rays)
        : mesh_(mesh), visibility_(visibility), glossy_rays_(glossy_rays) {}

    /// Adds all that is seen in one mirror or glossy surface after another, of which the first is met at `hit`.
    void follow(const Hit& hit, const Vec3& direction, RandomStream& stream, std::vector<SeenInMirror>& sights,
                std::vector<SeenGloss>& glossy) const;

  private:
    void follow_one(Hit hit, Vec3 direction, double share, RandomStream& stream, std::vector<SeenInMirror>& sights,
                    std::vector<SeenGloss>& glossy) const;

    const Mesh& mesh_;
    const Visibility& visibility_;
    std::size_t glossy_rays_;
};

} // namespace difusa
