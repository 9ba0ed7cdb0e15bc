#include <difusa/radiosity/energy.h>

#include <utility>

namespace difusa {

EnergyBalance energy_balance(const Scene& scene, const Transport& transport, const std::vector<double>& weight,
                             const Values& rho, const Values& h, const Values& E, const Values& sun) {
    const Eigen::Index channels = h.cols();
    const Eigen::ArrayXd zero = Eigen::ArrayXd::Zero(channels);
    EnergyBalance balance{zero, zero, zero, zero, std::nullopt, std::nullopt, std::nullopt};
    std::vector<char> patterned(scene.materials.size(), 0);
    for (std::size_t m = 0; m < patterned.size(); ++m) {
        patterned[m] = scene.materials[m].emits_unevenly() ? 1 : 0;
    }
    for (std::size_t t = 0; t < scene.mesh.triangles.size(); ++t) {
        if (patterned[scene.mesh.material[t]] != 0) {
            // Midpoints of edges: exact for patterns of second degree on each triangle.
            for (const auto& [u, v] : {std::pair(0.5, 0.0), std::pair(0.5, 0.5), std::pair(0.0, 0.5)}) {
                balance.emitted += scene.mesh.areas[t] / 3.0 *
                                   scene.emission(scene.mesh.at(static_cast<Index>(t), u, v)).head(channels);
            }
            continue;
        }
        balance.emitted += scene.mesh.areas[t] * scene.materials[scene.mesh.material[t]].emission.head(channels);
    }
    const bool rays = !transport.sky.empty();
    Eigen::ArrayXd escaped = zero, blocked = zero;
    for (Eigen::Index j = 0; j < h.rows(); ++j) {
        const auto site = static_cast<std::size_t>(j);
        const Eigen::ArrayXd rho_j = rho.row(j).transpose(), h_j = h.row(j).transpose();
        if (sun.rows() > 0) {
            balance.from_lights += weight[site] * sun.row(j).transpose().array();
        }
        balance.absorbed += weight[site] * (1.0 - rho_j) * h_j;
        if (rays) {
            const Eigen::ArrayXd B_j = E.row(j).transpose().array() + rho_j * h_j;
            balance.from_sky += weight[site] * transport.sky[site] * scene.sky.head(channels);
            if (transport.dome.rows() > 0) {
                balance.from_sky += weight[site] * transport.dome.row(j).head(channels).transpose().array();
            }
            escaped += weight[site] * transport.sky[site] * B_j;
            blocked += weight[site] * transport.back[site] * B_j;
        }
    }
    if (rays) {
        const Eigen::ArrayXd in = balance.emitted + balance.from_lights + balance.from_sky;
        balance.imbalance = (in > 0.0).select((in - balance.absorbed - escaped - blocked) / in, 0.0);
        balance.escaped = escaped;
        balance.blocked = blocked;
    }
    return balance;
}

} // namespace difusa
