// Directions `hemicube` (L 39-45): the half cube of height 1 over a point, its top divided into n by n pixels and each
// side into n by n/2, of area dA = (2/n)². A ray leaves through each pixel, and the nearest surface it meets is the one
// that a depth buffer would keep (L 41). Its weight is the pixel's delta factor (L 44),
//     top:  dA / (pi (x² + y² + 1)²),     side:  z dA / (pi (y² + z² + 1)²),
// divided by the sum of all, which differs from 1 by O(1/n²), so that closed surroundings have a form factor of 1.
#include <difusa/plugin/plugin.h>
#include <difusa/rays/directions.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace {

class Hemicube final : public difusa::Directions {
  public:
    explicit Hemicube(const difusa::Parameters& parameters)
        : resolution_(parameters.given("resolution") ? even(parameters.integer("resolution")) : 0),
          fixed_(parameters.word("grid") == "fixed") {}

    std::size_t size(std::size_t count) const override {
        const std::size_t n = pixels(count);
        return 3 * n * n;
    }
    bool equal_weights() const override { return false; }
    bool is_fixed() const override { return fixed_; }

    difusa::DirectionSet make(std::size_t count, difusa::RandomStream stream) const override {
        const std::size_t n = pixels(count);
        const double step = 2.0 / static_cast<double>(n);
        // Where in pixel number i along a side: in its middle, or anywhere.
        const auto place = [&](std::size_t i) {
            return step * (static_cast<double>(i) + (fixed_ ? 0.5 : std::max(stream.uniform(), 0x1p-33)));
        };
        difusa::DirectionSet set;
        const auto add = [&](double x, double y, double z, double cosine) {
            const double squared = x * x + y * y + z * z;
            set.direction.emplace_back(difusa::Vec3(x, y, z) / std::sqrt(squared));
            set.weight.push_back(cosine * step * step / (std::numbers::pi * squared * squared));
        };
        for (std::size_t j = 0; j < n; ++j) {
            for (std::size_t i = 0; i < n; ++i) {
                const double x = place(i) - 1.0, y = place(j) - 1.0;
                add(x, y, 1.0, 1.0);
                for (int side = 0; side < 4 && j < n / 2; ++side) {
                    const double along = place(i) - 1.0, z = place(j); // above 0, strictly above the horizon
                    const double outwards = side < 2 ? 1.0 : -1.0;
                    add(side % 2 == 0 ? outwards : along, side % 2 == 0 ? along : outwards, z, z);
                }
            }
        }
        const double sum = std::accumulate(set.weight.begin(), set.weight.end(), 0.0);
        for (double& weight : set.weight) {
            weight /= sum;
        }
        return set;
    }

  private:
    static std::size_t even(long n) { return 2 * static_cast<std::size_t>((n + 1) / 2); }

    /// Along a side of the top; even, so that the sides have n/2 rows.
    std::size_t pixels(std::size_t count) const {
        if (resolution_ > 0) {
            return resolution_;
        }
        const double half = 0.5 * std::sqrt(static_cast<double>(count) / 3.0);
        return 2 * std::max<std::size_t>(1, static_cast<std::size_t>(std::llround(half)));
    }
    std::size_t resolution_; ///< 0: from the number of rays
    bool fixed_;
};

} // namespace

DIFUSA_PLUGIN(
    directions, "hemicube", Hemicube,
    "Hemicube: a ray through each of 3 n² pixels, weighted by its delta factor (L 44).",
    {{"resolution",
      difusa::ParameterSpec::Type::integer,
      "",
      "pixels along a side of the top, rounded up to an even number; empty: about as many rays as --rays",
      2,
      2048,
      {}},
     {"grid",
      difusa::ParameterSpec::Type::word,
      "random",
      "random: a random point of each pixel, turned for each site; fixed: the same rays at every site, which alias",
      0,
      0,
      {"random", "fixed"}}})
