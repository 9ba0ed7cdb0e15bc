#include <difusa/render/tone_map.h>

#include <algorithm>
#include <cmath>

namespace difusa {

double filmic(double x) {
    return std::clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

Rgb tone_map(const Rgb& light, double exposure, ToneCurve curve) {
    const Rgb exposed = exposure * light;
    return curve == ToneCurve::linear ? Rgb(exposed.max(0.0).min(1.0)) : Rgb(exposed.unaryExpr(&filmic));
}

double exposure_for(std::vector<float> luminances) {
    if (luminances.empty()) {
        return 1.0;
    }
    const auto bright = luminances.begin() + std::lround(0.95 * static_cast<double>(luminances.size() - 1));
    std::nth_element(luminances.begin(), bright, luminances.end());
    // If light is confined to less than a twentieth of the picture, all of it counts.
    const float value = *bright > 0.0F ? *bright : *std::max_element(luminances.begin(), luminances.end());
    return value > 0.0F ? 0.9 / static_cast<double>(value) : 1.0;
}

} // namespace difusa
