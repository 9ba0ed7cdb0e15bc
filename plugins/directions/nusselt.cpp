// Directions `nusselt` (L 38): the unit disc under the hemisphere is divided into 3 n² cells of equal area, ring k of n
// into 3 (2k + 1) sectors, and a ray leaves through each. Since the projection onto the disc is the cosine, all have
// the same weight.
#include <difusa/plugin/plugin.h>
#include <difusa/rays/ring_cells.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace {

class Nusselt final : public difusa::Directions {
  public:
    explicit Nusselt(const difusa::Parameters& parameters) : fixed_(parameters.word("grid") == "fixed") {}

    std::size_t size(std::size_t count) const override { return 3 * rings(count) * rings(count); }
    bool is_fixed() const override { return fixed_; }

    difusa::DirectionSet make(std::size_t count, difusa::RandomStream stream) const override {
        const std::size_t n = rings(count);
        std::vector<double> border{0.0};
        std::vector<std::size_t> sectors;
        for (std::size_t k = 0; k < n; ++k) {
            border.push_back(static_cast<double>((k + 1) * (k + 1)) / static_cast<double>(n * n));
            sectors.push_back(3 * (2 * k + 1));
        }
        difusa::DirectionSet set = difusa::through_ring_cells(border, sectors, fixed_ ? nullptr : &stream);
        set.weight.assign(set.weight.size(), 1.0 / static_cast<double>(set.weight.size())); // equal to the bit
        return set;
    }

  private:
    static std::size_t rings(std::size_t count) {
        return std::max<std::size_t>(
            1, static_cast<std::size_t>(std::llround(std::sqrt(static_cast<double>(count) / 3.0))));
    }
    bool fixed_;
};

} // namespace

DIFUSA_PLUGIN(
    directions, "nusselt", Nusselt,
    "Nusselt's disc in 3 n² cells of equal area, a ray through each, equal weights (L 38).",
    {{"grid",
      difusa::ParameterSpec::Type::word,
      "random",
      "random: a random point of each cell, turned for each site; fixed: the same rays at every site, which alias",
      0,
      0,
      {"random", "fixed"}}})
