#include <difusa/radiosity/energy.h>

#include <utility>

namespace difusa {

namespace {

/// ∫ E dA.
Eigen::ArrayXd emitted_power(const Scene& scene, Eigen::Index channels) {
    Eigen::ArrayXd power = Eigen::ArrayXd::Zero(channels);
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        const Material& material = scene.materials[scene.mesh.material[t]];
        if (!material.emits_unevenly()) {
            power += scene.mesh.areas[t] * material.emission.head(channels);
            continue;
        }
        // Edge midpoints: exact for second-degree patterns on each triangle.
        for (const auto& [u, v] : {std::pair(0.5, 0.0), std::pair(0.5, 0.5), std::pair(0.0, 0.5)}) {
            power += scene.mesh.areas[t] / 3.0 * scene.emission(scene.mesh.at(t, u, v)).head(channels);
        }
    }
    return power;
}

/// Converts values at the points to means over the surfels.
Values on_surfels(const Discretisation& discretisation, const Values& at_points, const Execution& execution) {
    Values means;
    discretisation.averages->apply(discretisation.projection->coefficients(at_points, execution), means, execution);
    return means;
}

} // namespace

EnergyBalance energy_balance(const Scene& scene, const Discretisation& discretisation, const LightTransport& transport,
                             const SurfelLight& light, const Values& irradiance, const Values& from_sky,
                             const Execution& execution) {
    const Eigen::Index channels = irradiance.cols();
    const Eigen::ArrayXd zero = Eigen::ArrayXd::Zero(channels);
    EnergyBalance balance{emitted_power(scene, channels), zero, zero, zero, zero, zero, zero};
    const auto column = [](const std::vector<double>& share) {
        return Values(Eigen::Map<const Eigen::VectorXd>(share.data(), static_cast<Eigen::Index>(share.size())));
    };
    const Values sky = on_surfels(discretisation, column(transport.sky), execution);
    const Values back = on_surfels(discretisation, column(transport.back), execution);
    const Values H_sky = on_surfels(discretisation, from_sky, execution);
    for (Index s = 0; s < discretisation.surfels->size(); ++s) {
        const double area = discretisation.surfels->area(s);
        const Eigen::ArrayXd rho = light.reflectance.row(s).transpose(), H = irradiance.row(s).transpose();
        const Eigen::ArrayXd B = light.all_emission.row(s).transpose().array() + rho * H;
        balance.absorbed += area * (1.0 - rho) * H;
        balance.from_sky += area * H_sky.row(s).transpose().array();
        balance.escaped += area * sky(s, 0) * B;
        balance.blocked += area * back(s, 0) * B;
        balance.from_lights += area * light.from_outside.row(s).transpose().array();
    }
    const Eigen::ArrayXd in = balance.emitted + balance.from_lights + balance.from_sky;
    balance.imbalance = (in > 0.0).select((in - balance.absorbed - balance.escaped - balance.blocked) / in, 0.0);
    return balance;
}

} // namespace difusa
