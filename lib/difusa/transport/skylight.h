// Gathered transport in which light from the sky through openings, such as windows, comes by rays aimed at these.
#pragma once

#include <difusa/algebra/hit_lists.h>
#include <difusa/algebra/sparse_rows.h>
#include <difusa/rays/sky_openings.h>
#include <difusa/transport/gathered.h>
#include <difusa/transport/light_transport.h>
#include <difusa/transport/mirrored.h>

#include <memory>
#include <span>
#include <vector>

namespace difusa {

/// W [b; sky] = diag(s) D b + Y sky: D are the surfels that the rays of a row meet, Y what rays to the openings see of
/// the sky, and other rays that escape elsewhere. s scales the rays that meet surfels or backs, so that each row adds
/// up to 1 with what backs take. A row whose point is too near to an opening keeps its rays, with s = 1.
class SkylightTransport final : public RefinedTransport {
  public:
    /// Of each row: s, the share of the rays that meet surfels or backs (-1: the row keeps its rays), and the form
    /// factor of what rays are aimed at.
    struct Row {
        double scale = 1.0, share = -1.0, aimed_at = 0.0;
    };
    SkylightTransport(std::shared_ptr<const HitLists> by_rays, std::size_t surfels, std::vector<Row> rows,
                      SparseRows skylight, std::size_t segments);

    const HitLists& by_rays() const override { return *by_rays_; }
    const std::shared_ptr<const HitLists>& lists() const { return by_rays_; } ///< the same
    std::size_t segments() const { return segments_; }                        ///< cast for it
    std::size_t rows() const override { return by_rays_->rows(); }
    std::size_t columns() const override { return by_rays_->columns(); }
    void apply(const Values& x, Values& y, const Execution& execution) const override;
    void apply_single(const SingleValues& x, Values& y, const Execution& execution) const override;
    bool prefers_single() const override { return true; }
    void apply_transpose(const Values& x, Values& y, const Execution& execution) const override;
    std::size_t entry_count() const override { return by_rays_->entry_count() + skylight_.entry_count(); }
    Values variance_of_rays(const Values& x, const Execution& execution) const override;

    /// Bytes beside those of `by_rays`.
    std::size_t bytes() const;

  private:
    template <class Operand> bool is_sky_dark(const Operand& x) const; ///< as in each bounce
    Values without_sky(const Values& x) const;
    void scale_rows(Values& y) const;

    std::shared_ptr<const HitLists> by_rays_;
    std::size_t surfels_;
    std::vector<Row> rows_;
    SparseRows skylight_; ///< Y
    std::size_t segments_;
};

/// The transport with rays to the openings of the scene, a quarter as many again from each point, if there are any:
/// else unchanged, as with mirrors, gloss, symmetry planes or periods, and with rows that are no HitLists. Points,
/// directions and seed: those that the transport was gathered with. Rays to openings, those that find them, and those
/// that are cast again because they may pass them, count as segments. Phase "rays to openings".
LightTransport with_skylight(LightTransport transport, const Tracer& tracer, std::span<const SurfacePoint> points,
                             const Directions& directions, std::uint64_t seed, const Execution& execution);

/// The same with known openings, or null, and with parts of the sky as the transport has them.
LightTransport with_skylight(LightTransport transport, const Tracer& tracer, std::span<const SurfacePoint> points,
                             const SkyBins& sky, std::shared_ptr<const SkyOpenings> openings,
                             const Directions& directions, std::uint64_t seed, const Execution& execution);

/// The transport as it was before `with_skylight`; others unchanged.
LightTransport by_rays_alone(LightTransport transport);

} // namespace difusa
