#include <difusa/transport/transport.h>

#include <algorithm>

namespace difusa {

Values direct_irradiance(const Scene& scene, const LightGroup& group, const Transport& transport, int channels,
                         const Execution& execution) {
    const auto materials = static_cast<Eigen::Index>(scene.materials.size());
    Values E = Values::Zero(materials, channels), ones = Values::Zero(materials, 1);
    for (std::size_t m = 0; m < scene.materials.size(); ++m) {
        if (group.materials[m] != 0) {
            E.row(static_cast<Eigen::Index>(m)) = scene.materials[m].emission.head(channels).matrix().transpose();
            ones(static_cast<Eigen::Index>(m), 0) = 1.0;
        }
    }
    Values H, column;
    transport.L.multiply(E, H, execution);
    for (int c = 0; c < channels; ++c) {
        const SparseRows& uneven = transport.uneven[static_cast<std::size_t>(c)];
        if (uneven.nonzeros() > 0) {
            uneven.multiply(ones, column, execution);
            H.col(c) += column;
        }
    }
    if (group.sky && scene.has_sky()) {
        const Eigen::RowVectorXd sky = scene.sky.head(channels).matrix().transpose();
        for (Eigen::Index j = 0; j < H.rows(); ++j) {
            H.row(j) += transport.sky[static_cast<std::size_t>(j)] * sky;
        }
        if (transport.dome.rows() > 0) {
            H += transport.dome.leftCols(channels);
        }
    }
    return H;
}

} // namespace difusa
