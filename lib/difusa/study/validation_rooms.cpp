#include <difusa/study/validation_rooms.h>

#include <difusa/algebra/quadrature.h>
#include <difusa/core/error.h>
#include <difusa/import/shapes.h>

#include <Eigen/Geometry>

namespace difusa {

namespace {

Index new_material(Scene& scene, const std::string& name, double rho, double emission) {
    Material material;
    material.name = name;
    material.reflectance = Rgb::Constant(rho);
    material.emission = Rgb::Constant(emission);
    scene.materials.push_back(std::move(material));
    return static_cast<Index>(scene.materials.size() - 1);
}

} // namespace

void add_rectangle(Scene& scene, const std::string& name, const Vec3& a, const Vec3& u, const Vec3& v, double rho,
                   double emission) {
    add(scene.mesh, rectangle(a, u, v), new_material(scene, name, rho, emission));
}

void add_rectangle_around(Scene& scene, const std::string& name, const Vec3& a, const Vec3& u, const Vec3& v,
                          const Rectangle& hole) {
    Index material = none;
    for (const Rectangle& part :
         {Rectangle{0.0, 1.0, 0.0, hole.y0}, Rectangle{0.0, 1.0, hole.y1, 1.0},
          Rectangle{0.0, hole.x0, hole.y0, hole.y1}, Rectangle{hole.x1, 1.0, hole.y0, hole.y1}}) {
        if (part.area() > 0.0) {
            material = material == none ? new_material(scene, name, 0.0, 0.0) : material;
            add(scene.mesh, rectangle(a + part.x0 * u + part.y0 * v, (part.x1 - part.x0) * u, (part.y1 - part.y0) * v),
                material);
        }
    }
}

RoomSide room_side(const Vec3& size, RoomFace side) {
    const Vec3 x = size.x() * Vec3::UnitX(), y = size.y() * Vec3::UnitY(), z = size.z() * Vec3::UnitZ();
    switch (side) {
    case RoomFace::floor:
        return {"floor", Vec3::Zero(), x, y};
    case RoomFace::ceiling:
        return {"ceiling", z, y, x};
    case RoomFace::y_low:
        return {"wall at y low", Vec3::Zero(), z, x};
    case RoomFace::y_high:
        return {"wall at y high", y, x, z};
    case RoomFace::x_low:
        return {"wall at x low", Vec3::Zero(), y, z};
    case RoomFace::x_high:
        break;
    }
    return {"wall at x high", x, z, y};
}

void add_sides(Scene& scene, const Vec3& size, std::initializer_list<RoomFace> sides, double rho) {
    for (const RoomFace side : sides) {
        const RoomSide one = room_side(size, side);
        add_rectangle(scene, one.name, one.a, one.u, one.v, rho);
    }
}

void add_side_nodes(ValidationCase& one, const Vec3& size, std::initializer_list<RoomFace> sides, std::size_t count,
                    double factor) {
    for (const RoomFace side : sides) {
        const RoomSide each = room_side(size, side);
        add_nodes(one, each.a, each.u, each.v, count, factor);
    }
}

std::vector<std::string> letters(char first, std::size_t count, const std::string& suffix) {
    std::vector<std::string> names;
    for (std::size_t k = 0; k < count; ++k) {
        names.push_back(static_cast<char>(first + static_cast<char>(k)) + suffix);
    }
    return names;
}

void add_points(ValidationCase& one, const std::vector<std::string>& names, const Vec3& first, const Vec3& step,
                const Vec3& n, const std::vector<double>& published) {
    DIFUSA_REQUIRE(published.empty() || published.size() == names.size());
    for (std::size_t k = 0; k < names.size(); ++k) {
        ValidationReading reading;
        reading.name = names[k];
        reading.places = {{first + static_cast<double>(k) * step, n}};
        reading.weight = {1.0};
        if (!published.empty()) {
            reading.published = published[k];
        }
        one.readings.push_back(std::move(reading));
    }
}

void add_nodes(ValidationCase& one, const Vec3& a, const Vec3& u, const Vec3& v, std::size_t count, double factor) {
    const QuadratureRule rule = gauss_legendre(count);
    const Vec3 area = u.cross(v);
    ValidationReading& reading = one.readings.back();
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = 0; j < count; ++j) {
            reading.places.push_back({a + rule.node[i] * u + rule.node[j] * v, Vec3(area.normalized())});
            reading.weight.push_back(factor * rule.weight[i] * rule.weight[j] * area.norm());
        }
    }
}

void fill_exact(ValidationCase& one) {
    for (ValidationReading& reading : one.readings) {
        if (reading.places.size() == 1) {
            reading.exact = one.exact(reading.places.front().position, reading.places.front().normal.value());
        }
    }
}

} // namespace difusa
