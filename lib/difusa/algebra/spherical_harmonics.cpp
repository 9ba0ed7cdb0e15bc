#include <difusa/algebra/spherical_harmonics.h>

#include <difusa/algebra/quadrature.h>
#include <difusa/core/error.h>

#include <cmath>
#include <numbers>

namespace difusa {

SphericalHarmonics::SphericalHarmonics(int order) : order_(order) {
    DIFUSA_REQUIRE(order >= 0);
    double diagonal = std::sqrt(0.25 / std::numbers::pi);
    for (int m = 0; m <= order; ++m) {
        if (m > 0) {
            diagonal *= std::sqrt((2.0 * m + 1.0) / (2.0 * m));
        }
        diagonal_.push_back(m == 0 ? diagonal : std::numbers::sqrt2 * diagonal);
        step_.emplace_back();
        for (int l = m + 1; l <= order; ++l) {
            const double l2 = static_cast<double>(l) * l, m2 = static_cast<double>(m) * m;
            const double before = (l - 1.0) * (l - 1.0);
            step_.back().push_back({std::sqrt((4.0 * l2 - 1.0) / (l2 - m2)),
                                    l == m + 1 ? 0.0 : std::sqrt((before - m2) / (4.0 * before - 1.0))});
        }
    }
    const QuadratureRule rule = gauss_legendre(static_cast<std::size_t>(order) + 1);
    const int around = 2 * order + 2;
    for (std::size_t k = 0; k < rule.size(); ++k) {
        const double z = 2.0 * rule.node[k] - 1.0, r = std::sqrt(1.0 - z * z);
        for (int i = 0; i < around; ++i) {
            const double angle = 2.0 * std::numbers::pi * (i + 0.5) / around;
            node_.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
            weight_.push_back(4.0 * std::numbers::pi * rule.weight[k] / around);
        }
    }
    at_nodes_.resize(static_cast<Eigen::Index>(node_.size()), static_cast<Eigen::Index>(count()));
    for (std::size_t q = 0; q < node_.size(); ++q) {
        at(node_[q], std::span(at_nodes_.row(static_cast<Eigen::Index>(q)).data(), count()));
    }
}

void SphericalHarmonics::at(const Vec3& direction, std::span<double> Y) const {
    const double z = direction.z();
    double cosine = 1.0, sine = 0.0; // of m phi, times sin^m of the angle to z
    for (int m = 0; m <= order_; ++m) {
        const auto& steps = step_[static_cast<std::size_t>(m)];
        double before = 0.0, now = diagonal_[static_cast<std::size_t>(m)];
        for (int l = m;; ++l) {
            Y[number(l, m)] = now * cosine;
            if (m > 0) {
                Y[number(l, -m)] = now * sine;
            }
            if (l == order_) {
                break;
            }
            const Step& step = steps[static_cast<std::size_t>(l - m)];
            const double next = step.a * (z * now - step.b * before);
            before = now;
            now = next;
        }
        const double turned = cosine * direction.x() - sine * direction.y();
        sine = cosine * direction.y() + sine * direction.x();
        cosine = turned;
    }
}

SphericalHarmonics::Rotation SphericalHarmonics::rotation(const Eigen::Matrix3d& R) const {
    Values turned(at_nodes_.rows(), at_nodes_.cols());
    for (std::size_t q = 0; q < node_.size(); ++q) {
        const auto row = static_cast<Eigen::Index>(q);
        at(R.transpose() * node_[q], std::span(turned.row(row).data(), count()));
        turned.row(row) *= weight_[q];
    }
    Rotation blocks;
    for (int l = 0; l <= order_; ++l) {
        const Eigen::Index first = static_cast<Eigen::Index>(l) * l, size = 2 * l + 1;
        blocks.emplace_back(at_nodes_.middleCols(first, size).transpose() * turned.middleCols(first, size));
    }
    return blocks;
}

void SphericalHarmonics::rotate(const Rotation& rotation, const Eigen::Ref<const Values>& from, Eigen::Ref<Values> to) {
    Eigen::Index first = 0;
    for (const Eigen::MatrixXd& block : rotation) {
        to.middleRows(first, block.rows()).noalias() = block * from.middleRows(first, block.rows());
        first += block.rows();
    }
}

void SphericalHarmonics::rotate_back(const Rotation& rotation, const Eigen::Ref<const Values>& from,
                                     Eigen::Ref<Values> to) {
    Eigen::Index first = 0;
    for (const Eigen::MatrixXd& block : rotation) {
        to.middleRows(first, block.rows()).noalias() = block.transpose() * from.middleRows(first, block.rows());
        first += block.rows();
    }
}

} // namespace difusa
