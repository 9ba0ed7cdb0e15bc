// Form factors from a surface element to many triangles at once.
#pragma once

#include <difusa/mesh/mesh.h>

#include <cstddef>
#include <span>
#include <vector>

namespace difusa {

/// Triangles, arranged so that several of them are handled with one vector instruction.
class LambertBatch {
  public:
    LambertBatch() = default;
    LambertBatch(const Mesh& mesh, std::span<const Index> triangles);

    std::size_t size() const { return size_; }

    /// The unoccluded form factors F (#size) from a surface element at x with unit normal n: lambert_form_factor
    /// (rays/lambert.h), from which they differ by rounding alone. The same bits on processors with and without AVX2.
    void form_factors(const Vec3& x, const Vec3& n, std::span<double> F) const;

    static constexpr std::size_t lanes = 8; ///< triangles that are handled together

    /// Coordinates of so many triangles, one array each. Those that complete the last block face nowhere.
    struct Block {
        double corner[3][3][lanes] = {}; ///< of each corner, and each coordinate
        double normal[3][lanes] = {};    ///< as long as twice the area
    };

  private:
    std::size_t size_ = 0;
    std::vector<Block> blocks_;
};

} // namespace difusa
