#include <difusa/mesh/glossy_lobe.h>

#include <difusa/algebra/quadrature.h>
#include <difusa/core/frame.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace difusa {

namespace {

constexpr std::size_t nodes = 513;        ///< of the table of E
constexpr std::size_t facet_samples = 64; ///< by 64, for E of GGX
constexpr double grazing = 1e-4;          ///< the least cosine at which formulae are evaluated

/// ∫ max(0, a + b cos phi) dphi, b >= 0, around the circle.
double positive_part_around(double a, double b) {
    if (a >= b) {
        return 2.0 * std::numbers::pi * a;
    }
    if (a <= -b) {
        return 0.0;
    }
    const double end = std::acos(-a / b);
    return 2.0 * (a * end + b * std::sin(end));
}

Vec3 mirrored_at_z(const Vec3& v) {
    return {-v.x(), -v.y(), v.z()};
}

} // namespace

GlossyLobe::GlossyLobe(const LobeShape& shape) : shape_(shape) {
    if (shape.model == LobeShape::Model::ggx) {
        alpha2_ = std::pow(shape.sharpness, 4.0);
    }
    for (std::size_t k = 0; k < nodes; ++k) {
        const double cosine = static_cast<double>(k) / static_cast<double>(nodes - 1);
        reflected_.push_back(std::min(1.0, reflected_by_formula(std::max(grazing, cosine))));
    }
    // 2 ∫ E cos dcos of the interpolated table, exactly.
    double mean = 0.0;
    const double h = 1.0 / static_cast<double>(nodes - 1);
    for (std::size_t k = 0; k + 1 < nodes; ++k) {
        const double at = static_cast<double>(k) * h, E = reflected_[k], next = reflected_[k + 1];
        mean += 2.0 * h * (0.5 * (E + next) * at + h * (E / 6.0 + next / 3.0));
    }
    rest_ = 1.0 - mean > 1e-9 ? 1.0 / (std::numbers::pi * (1.0 - mean)) : 0.0;
}

double GlossyLobe::reflected(double cosine) const {
    const double at = std::clamp(cosine, 0.0, 1.0) * static_cast<double>(nodes - 1);
    const auto k = std::min(static_cast<std::size_t>(at), nodes - 2);
    const double along = at - static_cast<double>(k);
    return (1.0 - along) * reflected_[k] + along * reflected_[k + 1];
}

/// Of Phong in the cosine c of the angle to the mirror direction, by t = c^(n + 1); of GGX by visible facets.
double GlossyLobe::reflected_by_formula(double cosine) const {
    const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
    if (shape_.model == LobeShape::Model::phong) {
        static const QuadratureRule rule = gauss_legendre(256);
        const double n = shape_.sharpness;
        double sum = 0.0;
        for (std::size_t k = 0; k < rule.size(); ++k) {
            const double c = std::pow(rule.node[k], 1.0 / (n + 1.0)), s = std::sqrt(std::max(0.0, 1.0 - c * c));
            sum += rule.weight[k] * positive_part_around(c * cosine, s * sine);
        }
        return (n + 2.0) / (n + 1.0) / (2.0 * std::numbers::pi) * sum;
    }
    const Vec3 out(sine, 0.0, cosine);
    double sum = 0.0, whole = 0.0;
    for (std::size_t i = 0; i < facet_samples; ++i) {
        // Few facets are steep, and these lose most: nodes crowd there.
        const double t = (static_cast<double>(i) + 0.5) / facet_samples, t3 = t * t * t;
        for (std::size_t j = 0; j < facet_samples; ++j) {
            const Draw drawn = draw_lobe(out, 1.0 - t3 * t, (static_cast<double>(j) + 0.5) / facet_samples);
            sum += t3 * drawn.weight * std::max(0.0, drawn.direction.z());
            whole += t3;
        }
    }
    return sum / whole;
}

/// Smith's Λ.
double GlossyLobe::lambda(double cosine) const {
    const double c2 = cosine * cosine;
    return 0.5 * (std::sqrt(1.0 + alpha2_ * (1.0 - c2) / c2) - 1.0);
}

/// D, for the cosine of the angle between facet and normal.
double GlossyLobe::facets(double cosine) const {
    const double d = cosine * cosine * (alpha2_ - 1.0) + 1.0;
    return alpha2_ / (std::numbers::pi * d * d);
}

/// The formula, in the frame of the normal.
double GlossyLobe::lobe(const Vec3& in, const Vec3& out) const {
    if (!(in.z() > 0.0) || !(out.z() > 0.0)) {
        return 0.0;
    }
    if (shape_.model == LobeShape::Model::phong) {
        const double n = shape_.sharpness, c = mirrored_at_z(in).dot(out);
        return c > 0.0 ? (n + 2.0) / (2.0 * std::numbers::pi) * std::pow(c, n) : 0.0;
    }
    const double i = std::max(grazing, in.z()), o = std::max(grazing, out.z());
    return facets((in + out).normalized().z()) / (4.0 * i * o * (1.0 + lambda(i) + lambda(o)));
}

/// With which `draw_lobe` draws `in`.
double GlossyLobe::density(const Vec3& in, const Vec3& out) const {
    if (shape_.model == LobeShape::Model::phong) {
        const double n = shape_.sharpness, c = mirrored_at_z(out).dot(in);
        return c > 0.0 ? (n + 1.0) / (2.0 * std::numbers::pi) * std::pow(c, n) : 0.0;
    }
    const Vec3 sum = in + out;
    const double length = sum.norm(), o = std::max(grazing, out.z());
    return length > 0.0 ? facets(sum.z() / length) / (4.0 * o * (1.0 + lambda(o))) : 0.0;
}

GlossyLobe::Draw GlossyLobe::draw_lobe(const Vec3& out, double u, double v) const {
    const double angle = 2.0 * std::numbers::pi * v;
    if (shape_.model == LobeShape::Model::phong) {
        const double n = shape_.sharpness, c = std::pow(1.0 - u, 1.0 / (n + 1.0));
        const double s = std::sqrt(std::max(0.0, 1.0 - c * c));
        Vec3 t, b;
        const Vec3 mirror = mirrored_at_z(out);
        tangents(mirror, t, b);
        const Vec3 in = c * mirror + s * std::cos(angle) * t + s * std::sin(angle) * b;
        return {in, in.z() > 0.0 ? (n + 2.0) / (n + 1.0) : 0.0};
    }
    // A facet that is visible from `out` (E. Heitz, "Sampling the GGX distribution of visible normals", 2018).
    const double alpha = std::sqrt(alpha2_);
    const Vec3 stretched = Vec3(alpha * out.x(), alpha * out.y(), out.z()).normalized();
    Vec3 t(-stretched.y(), stretched.x(), 0.0);
    t = t.squaredNorm() > 0.0 ? Vec3(t.normalized()) : Vec3(Vec3::UnitX());
    const double r = std::sqrt(u), s = 0.5 * (1.0 + stretched.z());
    const double x = r * std::cos(angle),
                 y = (1.0 - s) * std::sqrt(std::max(0.0, 1.0 - x * x)) + s * r * std::sin(angle);
    const Vec3 flat = x * t + y * stretched.cross(t) + std::sqrt(std::max(0.0, 1.0 - x * x - y * y)) * stretched;
    const Vec3 facet = Vec3(alpha * flat.x(), alpha * flat.y(), std::max(0.0, flat.z())).normalized();
    const Vec3 in = 2.0 * facet.dot(out) * facet - out;
    if (!(in.z() > 0.0)) {
        return {in, 0.0};
    }
    const double o = std::max(grazing, out.z()), i = std::max(grazing, in.z());
    return {in, (1.0 + lambda(o)) / ((1.0 + lambda(o) + lambda(i)) * i)};
}

double GlossyLobe::value(const Vec3& n, const Vec3& in, const Vec3& out) const {
    const double i = n.dot(in), o = n.dot(out);
    if (!(i > 0.0) || !(o > 0.0)) {
        return 0.0;
    }
    Vec3 t, b;
    tangents(n, t, b);
    return lobe({t.dot(in), b.dot(in), i}, {t.dot(out), b.dot(out), o}) + rest(i, o);
}

GlossyLobe::Draw GlossyLobe::draw(const Vec3& n, const Vec3& out, const std::array<double, 3>& u) const {
    Vec3 t, b;
    tangents(n, t, b);
    const Vec3 from(t.dot(out), b.dot(out), n.dot(out));
    if (!(from.z() > 0.0)) {
        return {out, 0.0};
    }
    const double share = reflected(from.z());
    Vec3 in;
    if (u[0] < share) {
        in = draw_lobe(from, u[1], u[2]).direction;
    } else {
        const double r = std::sqrt(u[1]), angle = 2.0 * std::numbers::pi * u[2];
        in = {r * std::cos(angle), r * std::sin(angle), std::sqrt(std::max(0.0, 1.0 - u[1]))};
    }
    const Vec3 direction = in.x() * t + in.y() * b + in.z() * n;
    if (!(in.z() > 0.0)) {
        return {direction, 0.0};
    }
    const double density_of_both = share * density(in, from) + (1.0 - share) * in.z() / std::numbers::pi;
    return {direction, (lobe(in, from) + rest(in.z(), from.z())) * in.z() / density_of_both};
}

} // namespace difusa
