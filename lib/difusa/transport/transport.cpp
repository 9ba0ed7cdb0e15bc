#include <difusa/transport/transport.h>

namespace difusa {

std::vector<char> emitting_materials(const Scene& scene) {
    std::vector<char> emits(scene.materials.size(), 0);
    for (std::size_t m = 0; m < emits.size(); ++m) {
        emits[m] = (scene.materials[m].emission > 0.0).any() ? 1 : 0;
    }
    return emits;
}

Values direct_irradiance(const Scene& scene, const Transport& transport, int channels, const Execution& execution) {
    Values E(static_cast<Eigen::Index>(scene.materials.size()), channels);
    for (std::size_t m = 0; m < scene.materials.size(); ++m) {
        E.row(static_cast<Eigen::Index>(m)) = scene.materials[m].emission.head(channels).matrix().transpose();
    }
    Values H;
    transport.L.multiply(E, H, execution);
    if (scene.has_sky()) {
        const Eigen::RowVectorXd sky = scene.sky.head(channels).matrix().transpose();
        for (Eigen::Index j = 0; j < H.rows(); ++j) {
            H.row(j) += transport.sky[static_cast<std::size_t>(j)] * sky;
        }
    }
    return H;
}

} // namespace difusa
