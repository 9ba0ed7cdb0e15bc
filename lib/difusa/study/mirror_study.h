// Form factors over mirror patches against what mirrors show exactly: the two situations of M, at several distances and
// granularities.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/plugin/registry.h>
#include <difusa/scene/scene.h>
#include <difusa/transport/mirror_patches.h>

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace difusa {

/// An emitter of radiosity 1 lights a receiver over mirrors only.
struct MirrorSituation {
    using Rectangle = std::array<Vec3, 4>; ///< counterclockwise seen from its front
    std::string name;                      ///< "single", "double"
    double to_mirror = 0.0;                ///< distance of the emitter from the (nearest) mirror
    double from_mirror = 0.0;              ///< that of the receiver
    Scene scene;                           ///< materials: emitter, receiver, mirror, black walls
    Rectangle emitter;
    std::vector<Rectangle> mirrors; ///< in the order in which the receiver sees them

    /// The irradiance at a point of the receiver in closed form: of the emitter's image, as far as the images of the
    /// mirrors show it.
    double exact(const SurfacePoint& x) const;
};

/// M, figures 1 to 3: unit squares that face a mirror above both, 1 apart from each other; they do not face each other.
MirrorSituation single_mirror(double to_mirror, double from_mirror);

/// M, figure 4, with two mirrors: a periscope of mirrors at 45° and 2 apart, between black walls; unit squares before
/// it and behind it, each at `distance`, at least 1.
MirrorSituation double_mirror(double distance);

/// How transport over mirrors errs in one situation.
struct MirrorTrial {
    std::string situation;
    double to_mirror = 0.0, from_mirror = 0.0;
    MirrorPathOptions paths;
    std::size_t sites = 0, patches = 0; ///< patches: before they are quartered
    double rays = 0.0;                  ///< over mirrors, for each site
    double mean = 0.0;                  ///< of the irradiance of the receiver's sites, over its exact value
    double rms = 0.0, largest = 0.0;    ///< errors at these sites over the rms of the exact irradiance
};

/// Form factors with the kernel `disc` and the basis `normalized-radial`.
MirrorTrial try_mirrors(const Registry& registry, const MirrorSituation& situation, double spacing,
                        const MirrorPathOptions& paths, std::uint64_t seed, const Execution& execution);

/// All situations with all kinds of paths: granularities 4, 2, 1 and 1/2, and 1 quartered adaptively. `tell` is called
/// with each trial.
std::vector<MirrorTrial> mirror_study(const Registry& registry, double spacing, std::uint64_t seed,
                                      const Execution& execution, const std::function<void(const MirrorTrial&)>& tell);

/// A row of a Markdown table, and its header.
std::string mirror_header();
std::string mirror_row(const MirrorTrial& trial);

} // namespace difusa
