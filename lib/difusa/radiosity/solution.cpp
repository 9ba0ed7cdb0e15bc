#include <difusa/radiosity/solution.h>

#include <difusa/core/colour.h>

namespace difusa {

namespace {

/// The light of one field, and the difference of two halves if it was gathered.
struct Light {
    Irradiance H;
    Values noise;
};

Light light_of(const Field& field, std::span<const SurfacePoint> x, std::size_t final_gather, std::uint64_t seed,
               const std::string& purpose, const Execution& execution) {
    if (final_gather == 0) {
        return {field.evaluate(x, seed, purpose, execution), {}};
    }
    const std::size_t half = (final_gather + 1) / 2;
    Light light{field.gather(x, half, seed, purpose + ", first", execution), {}};
    const Irradiance other = field.gather(x, half, seed, purpose + ", second", execution);
    light.noise = 0.5 * (field.radiosity(x, light.H.direct + light.H.indirect) -
                         field.radiosity(x, other.direct + other.indirect));
    light.H.direct = 0.5 * (light.H.direct + other.direct);
    light.H.indirect = 0.5 * (light.H.indirect + other.indirect);
    light.H.rays += other.rays;
    light.H.segments += other.segments;
    light.H.clear += other.clear;
    return light;
}

void add(Values& sum, const Values& values) {
    sum = sum.rows() == 0 ? values : Values(sum + values);
}

} // namespace

PointValues Solution::at(std::span<const SurfacePoint> x, std::size_t final_gather, std::uint64_t seed,
                         const std::string& purpose, const Execution& execution) const {
    const Scene& scene = *field->parts().scene;
    const auto count = static_cast<Eigen::Index>(x.size());
    PointValues values;
    values.rho.resize(count, 3);
    values.E.resize(count, 3);
    for (Eigen::Index i = 0; i < count; ++i) {
        const SurfacePoint& point = x[static_cast<std::size_t>(i)];
        values.rho.row(i) = scene.reflectance(point).matrix().transpose();
        values.E.row(i) = scene.emission(point).matrix().transpose();
    }
    const auto take = [&](const Field& part) {
        const Light light = light_of(part, x, final_gather, seed, purpose, execution);
        add(values.H_direct, three_channels(light.H.direct));
        add(values.H_indirect, three_channels(light.H.indirect));
        if (final_gather > 0) {
            add(values.noise, light.noise);
        }
        values.rays += light.H.rays;
        values.segments += light.H.segments;
        values.clear += light.H.clear;
        return three_channels(light.H.direct + light.H.indirect);
    };
    if (groups.empty()) {
        values.H = take(*field);
    }
    for (const auto& group : groups) {
        const Values H = take(*group);
        values.groups.push_back({group->parts().group.name, three_channels(group->radiosity(x, H)), H});
    }
    if (!groups.empty()) {
        values.H = values.H_direct + values.H_indirect;
    }
    // With E and rho of the very point their edges stay sharp whatever the basis.
    values.B = values.E + values.rho.cwiseProduct(values.H);
    return values;
}

} // namespace difusa
