// Directions `sphere` (L 47): the hemisphere is divided into n bands of equal height in angle and these into sectors,
// about square, and a ray leaves through each element. Its weight is the delta factor of the element, its integral of
// the cosine over pi: for a band from the angle a to b with m sectors (sin² b - sin² a)/m. As L 47 says, this exchanges
// the geometry of the hemicube for ray casting; elements near the normal and near the horizon weigh little, so that
// equal weights (`nusselt`) make better use of the rays.
#include <difusa/plugin/plugin.h>
#include <difusa/rays/ring_cells.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace {

class Sphere final : public difusa::Directions {
  public:
    explicit Sphere(const difusa::Parameters& parameters) : fixed_(parameters.word("grid") == "fixed") {}

    std::size_t size(std::size_t count) const override {
        std::size_t sum = 0;
        for (const std::size_t each : sectors(bands(count))) {
            sum += each;
        }
        return sum;
    }
    bool equal_weights() const override { return false; }
    bool is_fixed() const override { return fixed_; }

    difusa::DirectionSet make(std::size_t count, difusa::RandomStream stream) const override {
        const std::size_t n = bands(count);
        std::vector<double> border{0.0};
        for (std::size_t k = 1; k < n; ++k) {
            const double sine = std::sin(height(n) * static_cast<double>(k));
            border.push_back(sine * sine);
        }
        border.push_back(1.0);
        return difusa::through_ring_cells(border, sectors(n), fixed_ ? nullptr : &stream);
    }

  private:
    static double height(std::size_t n) { return 0.5 * std::numbers::pi / static_cast<double>(n); }

    /// n bands have about 8 n²/pi elements.
    static std::size_t bands(std::size_t count) {
        return std::max<std::size_t>(
            1, static_cast<std::size_t>(std::llround(std::sqrt(std::numbers::pi / 8.0 * static_cast<double>(count)))));
    }
    static std::vector<std::size_t> sectors(std::size_t n) {
        std::vector<std::size_t> all;
        for (std::size_t k = 0; k < n; ++k) {
            const double around = 2.0 * std::numbers::pi * std::sin(height(n) * (static_cast<double>(k) + 0.5));
            all.push_back(std::max<std::size_t>(3, static_cast<std::size_t>(std::llround(around / height(n)))));
        }
        return all;
    }
    bool fixed_;
};

} // namespace

DIFUSA_PLUGIN(
    directions, "sphere", Sphere,
    "Discretised sphere: a ray through each element, weighted by its delta factor (L 47).",
    {{"grid",
      difusa::ParameterSpec::Type::word,
      "random",
      "random: a random point of each element, turned for each site; fixed: the same rays at every site, which alias",
      0,
      0,
      {"random", "fixed"}}})
