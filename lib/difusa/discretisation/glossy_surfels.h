// Which surfels are glossy.
#pragma once

#include <difusa/discretisation/surfels.h>

#include <vector>

namespace difusa {

/// A surfel reflects with the lobes of its faces, each with their mean reflectance over the whole surfel.
class GlossySurfels {
  public:
    struct Part {
        Index surfel, lobe;            ///< lobe: in GlossySurfaces::lobes
        Rgb reflectance = Rgb::Zero(); ///< not 0
    };

    GlossySurfels(const Mesh& mesh, const Surfels& surfels);

    /// Parts of one surfel follow each other.
    const std::vector<Part>& parts() const { return parts_; }

    /// The parts of a surfel, or of a bin that is none: from `begin` to `end`.
    struct Range {
        Index begin = 0, end = 0;
        bool empty() const { return begin == end; }
    };
    Range of(Index bin) const { return bin < first_.size() - 1 ? Range{first_[bin], first_[bin + 1]} : Range{}; }

    /// For each lobe and each region of the mesh, whether the region has faces of that lobe.
    bool has(Index lobe, Index region) const { return in_region_[lobe * regions_ + region] != 0; }

  private:
    std::vector<Part> parts_;
    std::vector<Index> first_; ///< #surfels + 1: the first part of each
    std::vector<char> in_region_;
    std::size_t regions_;
};

} // namespace difusa
