#include <difusa/lighting/lamp_images.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace difusa {

LampImages LampImages::of(const Mesh& mesh, std::size_t lamps) {
    const Repetition& repetition = mesh.repetition;
    if (!repetition.any() || lamps == 0) {
        return {};
    }
    LampImages result{{}, std::max<std::size_t>(1, mesh.mirrors.most)};
    const std::size_t most = std::min(most_of_one, most_of_all / lamps);
    // About as many as a cube of so many cells has, before any is made.
    const auto dimensions = static_cast<double>(repetition.endless.size());
    if (dimensions > 0.0) {
        const double edge = std::pow(static_cast<double>(most), 1.0 / dimensions);
        result.depth = std::clamp<std::size_t>(static_cast<std::size_t>(0.5 * edge), 1, result.depth);
    }
    result.images = repetition.images(result.depth);
    while (result.depth > 1 && !repetition.endless.empty() && result.images.size() > most) {
        result.images = repetition.images(--result.depth);
    }
    return result;
}

PointLight image_of(const PointLight& light, const Repetition::Image& image) {
    PointLight result = light;
    result.position = image(light.position);
    result.direction = image.linear * light.direction;
    result.c0 = image.linear * light.c0;
    result.c90 = image.linear * light.c90;
    return result;
}

std::vector<PointLight> with_images(const PointLight& light, const LampImages& images, const Mesh& mesh) {
    const double same = 1e-6 * mesh.diameter();
    const auto& walls = mesh.repetition.walls;
    const bool is_on_plane = std::any_of(walls.begin(), walls.end(), [&](const Repetition::Wall& wall) {
        return wall.reflects && std::abs(wall.height(light.position)) <= same;
    });
    std::vector<PointLight> result{light};
    for (std::size_t k = 1; k < images.images.size(); ++k) {
        PointLight image = image_of(light, images.images[k]);
        const bool known = is_on_plane && std::any_of(result.begin(), result.end(), [&](const PointLight& other) {
                               return (other.position - image.position).norm() <= 4.0 * same;
                           });
        if (!known) {
            result.push_back(std::move(image));
        }
    }
    return result;
}

std::shared_ptr<const Mesh> with_images(std::span<const Index> triangles, const LampImages& images, const Mesh& mesh) {
    auto lamps = std::make_shared<Mesh>();
    for (const Repetition::Image& image : images.images) {
        const bool reflects = image.reflects();
        for (const Index t : triangles) {
            const auto first = static_cast<Index>(lamps->points.size());
            for (int k = 0; k < 3; ++k) {
                lamps->points.push_back(image(mesh.corner(t, k)));
            }
            // A reflection turns it over.
            lamps->triangles.push_back({first, reflects ? first + 2 : first + 1, reflects ? first + 1 : first + 2});
            lamps->material.push_back(mesh.material[t]);
            lamps->normals.emplace_back(image.linear * mesh.normals[t]);
            lamps->areas.push_back(mesh.areas[t]);
        }
    }
    return lamps;
}

} // namespace difusa
