// Directions `fibonacci`: point i of N has the area (i + s) / N of the unit disc within its radius and lies i golden
// angles further than a start; s and the start are drawn at random, then the disc is lifted to the hemisphere: equal
// weights under the cosine (the Nusselt analogue). The points are a Fibonacci lattice of the unit square, shifted at
// random (Cranley and Patterson 1976), by the map that preserves area and has no seam in angle. Hits of a scene have
// jumps along its edges; there it takes about two thirds of the points that a scrambled Sobol sequence needs.
#include <difusa/plugin/plugin.h>
#include <difusa/rays/directions.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace {

class Fibonacci final : public difusa::Directions {
  public:
    explicit Fibonacci(const difusa::Parameters& /*parameters*/) {}

    difusa::DirectionSet make(std::size_t count, difusa::RandomStream stream) const override {
        const double first = stream.uniform(), start = stream.uniform();
        const auto n = static_cast<double>(count);
        difusa::DirectionSet set;
        set.weight.assign(count, 1.0 / n);
        set.direction.reserve(count);
        for (std::size_t i = 0; i < count; ++i) {
            // Strictly inside the disc, so that the direction is strictly above the horizon.
            const double area = std::min((static_cast<double>(i) + first) / n, 1.0 - 0x1p-33);
            const double turns = start + static_cast<double>(i) * (std::numbers::phi - 1.0);
            const double radius = std::sqrt(area), angle = 2.0 * std::numbers::pi * (turns - std::floor(turns));
            set.direction.emplace_back(radius * std::cos(angle), radius * std::sin(angle), std::sqrt(1.0 - area));
        }
        return set;
    }
};

} // namespace

DIFUSA_PLUGIN(directions, "fibonacci", Fibonacci,
              "Fibonacci lattice, randomly shifted, cosine-weighted; any number of rays.", {})
