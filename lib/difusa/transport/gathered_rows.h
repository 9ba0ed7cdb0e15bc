// The rows of a gathered transport while they are filled: what each point sees, as surfels and parts of the sky.
#pragma once

#include <difusa/algebra/channel_rows.h>
#include <difusa/algebra/hit_lists.h>
#include <difusa/algebra/sparse_rows.h>
#include <difusa/transport/gathered.h>
#include <difusa/transport/glossy_rays.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace difusa {

/// Threads may fill different blocks of rows, those of each block in order.
class GatheredRows {
  public:
    /// All references must outlive this. Rows are HitLists if all directions of the pool have the same weight.
    GatheredRows(const Tracer& tracer, std::span<const SurfacePoint> points, const Surfels& surfels, const SkyBins& sky,
                 const DirectionPool& pool, std::size_t rows_per_block);

    /// Buffers of one thread.
    struct Scratch {
        std::vector<Index> bin;
        std::vector<double> weight;
        std::vector<std::pair<Index, double>> order;
        std::vector<std::pair<Index, Rgb>> reflected;
    };

    /// The bin of a ray: a surfel, or after these a part of the sky; none for the back of a face.
    Index bin_of(const Hit& hit, const Vec3& direction) const {
        if (hit.face == none) {
            return first_sky_ + sky_.at(direction);
        }
        return hit.front ? surfels_.at(hit.face, hit.u, hit.v) : none;
    }
    Index first_sky() const { return first_sky_; }
    bool has_lists() const { return lists_ != nullptr; }

    /// Sets row j to what the point sees with all of its rays.
    void set(std::size_t j, const Sight& around, Scratch& scratch);

    /// Sets row j of lists to these bins, and its shares; nothing of what is seen in mirrors.
    void set_bins(std::size_t j, std::vector<Index>& bins);

    /// Sets row j to that of a transport of which surfel s has the number numbers[s] here; `same`: all numbers are
    /// those of before. Nothing of what is seen in mirrors.
    void keep(std::size_t j, const LightTransport& from, const std::vector<Index>& numbers, bool same,
              Scratch& scratch);

    /// Sets what point j sees in mirrors, of which `around` has all rays that meet one first, in their order.
    void set_in_mirrors(std::size_t j, const Sight& around, Scratch& scratch);

    /// To be called once all rows of the block are set.
    void close_block(std::size_t first_row);

    LightTransport finish();

  private:
    const Surfels& surfels_;
    const SkyBins& sky_;
    const DirectionPool& pool_;
    Index first_sky_;
    LightTransport transport_;
    std::shared_ptr<HitLists> lists_;      ///< or
    std::shared_ptr<SparseRows> weighted_; ///< one of them
    std::shared_ptr<ChannelRows> in_mirrors_;
    std::shared_ptr<GlossyRays> glossy_;
};

} // namespace difusa
