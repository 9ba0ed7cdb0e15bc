#include <difusa/study/references/shelf.h>

#include <difusa/algebra/dense.h>
#include <difusa/algebra/quadrature.h>
#include <difusa/study/references/check_parameter.h>
#include <difusa/study/references/form_factors.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace difusa {

namespace {

constexpr std::size_t floor_of_shelf = 0, back_of_shelf = 1, ceiling_of_shelf = 2;
constexpr int halvings = 16;
constexpr std::size_t nodes_of_panel = 10;

void check_shelf(const ShelfParameters& p) {
    for (const double length : {p.a, p.b}) {
        check_parameter("infinite shelf", length > 0.0 && std::isfinite(length), "the lengths must be positive",
                        length);
    }
    for (const double E : p.E) {
        check_parameter("infinite shelf", E >= 0.0 && std::isfinite(E), "the emission must be finite and not negative",
                        E);
    }
    for (const double rho : p.rho) {
        check_parameter("infinite shelf", rho >= 0.0 && rho < 1.0, "the reflectance must be in [0,1)", rho);
    }
}

/// Borders of panels on [0, length] that halve towards 0, and also towards `length` if both ends are corners, none
/// longer than `most`.
std::vector<double> panel_borders(double length, bool both, double most) {
    std::vector<double> borders{0.0};
    const double half = both ? 0.5 * length : length;
    for (int k = halvings; k >= 0; --k) {
        const double from = borders.back(), to = std::ldexp(half, -k);
        const double parts = std::ceil((to - from) / most);
        for (double i = 1.0; i <= parts; i += 1.0) {
            borders.push_back(from + (to - from) * i / parts);
        }
    }
    for (std::size_t k = borders.size() - 1; both && k-- > 0;) {
        borders.push_back(length - borders[k]);
    }
    return borders;
}

} // namespace

std::array<double, 3> shelf_patches(const ShelfParameters& p) {
    check_shelf(p);
    const ShelfFormFactors F = shelf(p.a, p.b);
    Eigen::Matrix3d matrix;
    matrix << 0.0, F.AB, F.AC, F.BA, 0.0, F.BA, F.AC, F.AB, 0.0;
    const Eigen::Map<const Eigen::Vector3d> E(p.E.data()), rho(p.rho.data());
    const Eigen::Matrix3d K = Eigen::Matrix3d::Identity() - rho.asDiagonal() * matrix;
    const Eigen::Vector3d B = solve_dense(K, E);
    return {B[0], B[1], B[2]};
}

Shelf::Shelf(const ShelfParameters& parameters) : parameters_(parameters) {
    check_shelf(parameters);
    const auto [shorter, longer] = std::minmax({parameters.a, parameters.b});
    check_parameter("infinite shelf", longer <= 16.0 * shorter, "one length is at most 16 times the other",
                    longer / shorter);
    const QuadratureRule rule = gauss_legendre(nodes_of_panel);
    for (const std::size_t surface : {floor_of_shelf, back_of_shelf, ceiling_of_shelf}) {
        const bool back = surface == back_of_shelf;
        const std::vector<double> borders = panel_borders(back ? parameters.b : parameters.a, back, 0.5 * shorter);
        for (std::size_t k = 0; k + 1 < borders.size(); ++k) {
            const double length = borders[k + 1] - borders[k];
            for (std::size_t i = 0; i < rule.size(); ++i) {
                nodes_.push_back({surface, borders[k] + length * rule.node[i], length * rule.weight[i]});
            }
        }
    }
    const auto n = static_cast<Eigen::Index>(nodes_.size());
    Eigen::MatrixXd system(n, n);
    Eigen::VectorXd E(n);
    for (Eigen::Index i = 0; i < n; ++i) {
        const Node& at = nodes_[static_cast<std::size_t>(i)];
        for (Eigen::Index j = 0; j < n; ++j) {
            const Node& from = nodes_[static_cast<std::size_t>(j)];
            system(i, j) =
                (i == j ? 1.0 : 0.0) - parameters.rho[at.surface] * from.weight * kernel(at.surface, at.s, from);
        }
        E[i] = parameters.E[at.surface];
    }
    const Eigen::VectorXd B = solve_dense(system, E);
    B_.assign(B.data(), B.data() + n);
}

double Shelf::kernel(std::size_t surface, double s, const Node& from) const {
    if (surface == from.surface) {
        return 0.0;
    }
    const double b = parameters_.b;
    if (surface != back_of_shelf && from.surface != back_of_shelf) {
        return b * b / (2.0 * std::pow(b * b + (s - from.s) * (s - from.s), 1.5));
    }
    // Along the floor or ceiling, and along the back from there.
    const bool to_back = surface == back_of_shelf;
    const std::size_t plane = to_back ? from.surface : surface;
    const double x = to_back ? from.s : s, height = to_back ? s : from.s;
    const double z = plane == floor_of_shelf ? height : b - height;
    const double squared = x * x + z * z;
    return squared > 0.0 ? x * z / (2.0 * std::pow(squared, 1.5)) : 0.0;
}

ReferenceLight Shelf::at(const Vec3& x, const Vec3& n) const {
    const std::size_t surface = std::abs(n.z()) < std::abs(n.x()) ? back_of_shelf
                                : n.z() > 0.0                     ? floor_of_shelf
                                                                  : ceiling_of_shelf;
    const double s = surface == back_of_shelf ? x.z() : x.x();
    ReferenceLight light{parameters_.E[surface], parameters_.rho[surface], 0.0, 0.0};
    for (std::size_t j = 0; j < nodes_.size(); ++j) {
        const double share = nodes_[j].weight * kernel(surface, s, nodes_[j]);
        light.H += share * B_[j];
        *light.H_direct += share * parameters_.E[nodes_[j].surface];
    }
    return light;
}

std::array<double, 3> Shelf::mean_radiosity() const {
    std::array<double, 3> mean{};
    for (std::size_t j = 0; j < nodes_.size(); ++j) {
        const std::size_t surface = nodes_[j].surface;
        mean[surface] += nodes_[j].weight * B_[j] / (surface == back_of_shelf ? parameters_.b : parameters_.a);
    }
    return mean;
}

double Shelf::missing(double ends) const {
    check_parameter("infinite shelf", ends > 0.0 && std::isfinite(ends), "the distance must be positive", ends);
    const double diagonal = std::hypot(parameters_.a, parameters_.b);
    const double rho = *std::max_element(parameters_.rho.begin(), parameters_.rho.end());
    double sum = 0.0, w = rho;
    for (double k = 1.0; w > 0.0; k += 1.0, w *= rho) {
        const double psi = std::atan2(diagonal * k, ends);
        const double q = k * 2.0 * (psi - std::sin(psi) * std::cos(psi)) / std::numbers::pi;
        if (q >= 1.0) {
            return *std::max_element(B_.begin(), B_.end()) * (sum + w); // from here on the sum of w_k - w_{k+1}
        }
        sum += w * (1.0 - rho) * q;
    }
    return *std::max_element(B_.begin(), B_.end()) * sum;
}

} // namespace difusa
