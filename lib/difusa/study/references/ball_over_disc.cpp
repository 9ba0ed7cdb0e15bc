#include <difusa/study/references/ball_over_disc.h>

#include <difusa/algebra/dense.h>
#include <difusa/study/references/check_parameter.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>

namespace difusa {

namespace {

using std::numbers::pi;
constexpr std::size_t most_unknowns = 4000;

/// The latitude on a ball of radius r, centred one unit of length above a plane, whose tangent plane touches the circle
/// of radius v around its foot: from beyond (sign 1, nothing of the circle is visible above that latitude) or from this
/// side (-1, all of it is visible below).
double tangent_latitude(double r, double v, double sign) {
    return sign * std::atan(v) - std::asin(r / std::sqrt(1.0 + v * v));
}

/// Sorted, without duplicates.
void tidy(std::vector<double>& places) {
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
}

} // namespace

template <class Longest>
std::vector<BallOverDisc::Panel> BallOverDisc::divide(const std::vector<double>& ends, const Longest& longest) {
    std::vector<Panel> panels;
    for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
        std::vector<Panel> stack{{ends[k], ends[k + 1]}};
        while (!stack.empty()) {
            const Panel panel = stack.back();
            stack.pop_back();
            const double middle = 0.5 * (panel.from + panel.to);
            if (panel.to - panel.from > longest(middle)) {
                stack.push_back({middle, panel.to});
                stack.push_back({panel.from, middle});
            } else {
                panels.push_back(panel);
            }
            if (panels.size() + stack.size() > most_unknowns / 8) {
                throw NotConverged("ball over disc: the gap between ball and disc is too small a part of their "
                                   "size for this method; raise the ball");
            }
        }
    }
    return panels;
}

double BallOverDisc::Row::of(const std::vector<double>& H) const {
    return std::inner_product(H.begin(), H.end(), indirect.begin(), direct);
}

BallOverDisc::BallOverDisc(const BallOverDiscParameters& parameters, double tolerance)
    : parameters_(parameters), R_(parameters.R / parameters.h), r_(parameters.r / parameters.h) {
    const auto& [R, r, h, beta, delta, mu] = parameters;
    check_parameter("ball over disc", std::isfinite(R) && R > 0.0, "the disc's radius must be positive", R);
    check_parameter("ball over disc", std::isfinite(r) && r > 0.0, "the ball's radius must be positive", r);
    check_parameter("ball over disc", std::isfinite(h) && h > r, "the ball's centre must be higher than its radius", h);
    check_parameter("ball over disc", beta >= 0.0 && beta <= 1.0, "the ball's reflectance must be in [0,1]", beta);
    check_parameter("ball over disc", delta >= 0.0 && delta <= 1.0, "the disc's reflectance must be in [0,1]", delta);
    check_parameter("ball over disc", std::isfinite(mu) && mu > 0.0, "the sun's irradiance must be positive", mu);
    check_parameter("ball over disc", tolerance >= 1e-12 && tolerance < 1.0, "the tolerance must be in [1e-12, 1)",
                    tolerance);

    // Where the irradiances are not smooth.
    std::vector<double> on_ball{-pi / 2.0, 0.0, tangent_latitude(r_, R_, 1.0), tangent_latitude(r_, R_, -1.0),
                                pi / 2.0};
    std::vector<double> on_disc{0.0, R_};
    if (r_ < R_) {
        on_ball.push_back(tangent_latitude(r_, r_, -1.0)); // the other one is 0
        on_disc.push_back(r_);
    }
    tidy(on_ball);
    tidy(on_disc);
    // No panel is longer than its distance from the other body.
    ball_.panels = divide(on_ball, [&](double alpha) { return (1.0 + r_ * std::sin(alpha)) / r_; });
    disc_.panels = divide(on_disc, [&](double u) { return std::hypot(u, 1.0) - r_; });
    refine(tolerance);
}

std::vector<double> BallOverDisc::samples() const {
    std::vector<double> values;
    const auto along = [&](const Side& side, const auto& irradiance) {
        for (const Panel& panel : side.panels) {
            for (int k = 0; k < 8; ++k) {
                values.push_back(irradiance(panel.from + (panel.to - panel.from) * (k + 0.5) / 8.0));
            }
        }
    };
    along(ball_, [&](double alpha) { return from_disc(alpha).of(disc_.H); });
    along(disc_, [&](double u) { return from_ball(u).of(ball_.H); });
    return values;
}

void BallOverDisc::refine(double tolerance) {
    std::size_t nodes = 6;
    solve(nodes);
    std::vector<double> coarse = samples();
    while (true) {
        nodes *= 2;
        if (nodes * (ball_.panels.size() + disc_.panels.size()) > most_unknowns) {
            throw NotConverged("ball over disc: would need more than " + std::to_string(most_unknowns) +
                               " unknowns; raise the tolerance, or the ball");
        }
        solve(nodes);
        const std::vector<double> fine = samples();
        double largest = 0.0;
        error_ = 0.0;
        for (std::size_t k = 0; k < fine.size(); ++k) {
            largest = std::max(largest, fine[k]);
            error_ = std::max(error_, std::abs(fine[k] - coarse[k]));
        }
        if (error_ <= tolerance * largest) {
            return;
        }
        coarse = fine;
    }
}

double BallOverDisc::G(double alpha, double u) const {
    const double cosine = std::cos(alpha), s = u * cosine, c = r_ + std::sin(alpha);
    if (s <= c) {
        return 0.0;
    }
    const double height = 1.0 + r_ * std::sin(alpha);
    const double nearest = (u - r_ * cosine) * (u - r_ * cosine) + height * height, // A - C
        farthest = (u + r_ * cosine) * (u + r_ * cosine) + height * height;         // A + C
    const double A = 0.5 * (nearest + farthest), C = 2.0 * u * r_ * cosine, root = std::sqrt(nearest * farthest);
    double I1 = pi / root, I2 = A * I1 / (root * root), I3 = C * I2 / A;
    if (c > -s) {
        const double cos_tau = c / s, sin_tau = std::sqrt((s - c) * (s + c)) / s, X = A - C * cos_tau;
        I1 = 2.0 / root * std::atan2(std::sqrt(farthest * (s - c)), std::sqrt(nearest * (s + c)));
        I2 = (C * sin_tau / X + A * I1) / (root * root);
        I3 = (sin_tau / X + C * I2) / A;
    }
    return std::max(0.0, 2.0 / pi * height * (s * I3 - c * I2));
}

double BallOverDisc::direct_ball(double alpha) const {
    return parameters_.mu * std::max(0.0, std::sin(alpha));
}

double BallOverDisc::direct_disc(double u) const {
    return u > r_ ? parameters_.mu : 0.0;
}

template <class Kernel, class Direct>
BallOverDisc::Row BallOverDisc::row(const Side& sender, double albedo, std::vector<double> kinks, const Kernel& kernel,
                                    const Direct& direct) const {
    Row row;
    row.indirect.assign(sender.node.size(), 0.0);
    std::vector<double> shape(rule_.size());
    std::sort(kinks.begin(), kinks.end());
    for (std::size_t p = 0; p < sender.panels.size(); ++p) {
        const Panel& panel = sender.panels[p];
        const auto add = [&](double x, double weight) {
            const double share = weight * kernel(x);
            if (share == 0.0) {
                return;
            }
            row.form_factor += share;
            row.direct += share * albedo * direct(x);
            // The Lagrange polynomials at x, by the barycentric formula.
            const double t =
                2.0 / pi * std::atan2(std::sqrt(std::max(0.0, x - panel.from)), std::sqrt(std::max(0.0, panel.to - x)));
            double sum = 0.0;
            for (std::size_t j = 0; j < rule_.size(); ++j) {
                if (t == rule_.node[j]) {
                    std::fill(shape.begin(), shape.end(), 0.0);
                    shape[j] = sum = 1.0;
                    break;
                }
                shape[j] = barycentric_[j] / (t - rule_.node[j]);
                sum += shape[j];
            }
            for (std::size_t j = 0; j < rule_.size(); ++j) {
                row.indirect[p * rule_.size() + j] += share * albedo * shape[j] / sum;
            }
        };
        double from = panel.from;
        for (const double kink : kinks) {
            if (kink > from && kink < panel.to) {
                for_each_node(fine_, from, kink, add);
                from = kink;
            }
        }
        for_each_node(fine_, from, panel.to, add);
    }
    return row;
}

BallOverDisc::Row BallOverDisc::from_disc(double alpha) const {
    const double kink = std::abs(r_ + std::sin(alpha)) / std::cos(alpha);
    return row(
        disc_, parameters_.delta, {kink}, [&](double u) { return u * G(alpha, u); },
        [&](double u) { return direct_disc(u); });
}

BallOverDisc::Row BallOverDisc::from_ball(double u) const {
    return row(
        ball_, parameters_.beta, {tangent_latitude(r_, u, -1.0), tangent_latitude(r_, u, 1.0)},
        [&](double alpha) { return r_ * r_ * std::cos(alpha) * G(alpha, u); },
        [&](double alpha) { return direct_ball(alpha); });
}

void BallOverDisc::place_nodes(Side& side) const {
    side.node.clear();
    side.weight.clear();
    for (const Panel& panel : side.panels) {
        for_each_node(rule_, panel.from, panel.to, [&](double x, double weight) {
            side.node.push_back(x);
            side.weight.push_back(weight);
        });
    }
}

/// H_b = d_b + P H_d, H_d = d_d + Q H_b: solves (I - Q P) H_d = d_d + Q d_b.
void BallOverDisc::solve(std::size_t nodes) {
    rule_ = gauss_legendre(nodes);
    fine_ = gauss_legendre(2 * nodes + 8);
    barycentric_ = barycentric_weights(rule_);
    place_nodes(ball_);
    place_nodes(disc_);
    const auto assemble = [](const std::vector<double>& places, std::size_t columns, const auto& row_at) {
        std::pair<Eigen::MatrixXd, Eigen::VectorXd> system(Eigen::MatrixXd(places.size(), columns),
                                                           Eigen::VectorXd(places.size()));
        for (std::size_t i = 0; i < places.size(); ++i) {
            const Row row = row_at(places[i]);
            const auto k = static_cast<Eigen::Index>(i);
            system.first.row(k) =
                Eigen::Map<const Eigen::RowVectorXd>(row.indirect.data(), static_cast<Eigen::Index>(columns));
            system.second[k] = row.direct;
        }
        return system;
    };
    const auto [P, d_ball] = assemble(ball_.node, disc_.node.size(), [&](double alpha) { return from_disc(alpha); });
    const auto [Q, d_disc] = assemble(disc_.node, ball_.node.size(), [&](double u) { return from_ball(u); });
    const Eigen::MatrixXd system = Eigen::MatrixXd::Identity(Q.rows(), Q.rows()) - Q * P;
    const Eigen::VectorXd H_disc = solve_dense(system, d_disc + Q * d_ball);
    const Eigen::VectorXd H_ball = d_ball + P * H_disc;
    disc_.H.assign(H_disc.begin(), H_disc.end());
    ball_.H.assign(H_ball.begin(), H_ball.end());
}

ReferenceLight BallOverDisc::ball(double alpha) const {
    check_parameter("ball over disc", std::abs(alpha) <= pi / 2.0, "the latitude must be in [-pi/2, pi/2]", alpha);
    const double direct = direct_ball(alpha);
    return {0.0, parameters_.beta, direct + from_disc(alpha).of(disc_.H), direct};
}

ReferenceLight BallOverDisc::disc(double u) const {
    check_parameter("ball over disc", u >= 0.0 && u <= parameters_.R,
                    "the distance from the disc's centre must be in [0, R]", u);
    const double scaled = u / parameters_.h, direct = u > parameters_.r ? parameters_.mu : 0.0;
    return {0.0, parameters_.delta, direct + from_ball(scaled).of(ball_.H), direct};
}

ReferenceLight BallOverDisc::at(const Vec3& x, const Vec3& n) const {
    const Vec3 from_centre = x - Vec3(0.0, 0.0, parameters_.h);
    const double u = std::hypot(x.x(), x.y()), outside = std::max(0.0, u - parameters_.R);
    if (std::abs(from_centre.norm() - parameters_.r) < std::hypot(outside, x.z())) {
        return ball(std::atan2(from_centre.z(), u));
    }
    check_parameter("ball over disc", n.z() > 0.0, "the disc is known from above only; the normal must look up", n.z());
    return disc(std::min(u, parameters_.R));
}

BallOverDisc::Power BallOverDisc::power() const {
    const auto& [R, r, h, beta, delta, mu] = parameters_;
    Power power;
    for (std::size_t i = 0; i < ball_.node.size(); ++i) {
        const double alpha = ball_.node[i], direct = direct_ball(alpha), H = direct + ball_.H[i];
        const double area = 2.0 * pi * r * r * std::cos(alpha) * ball_.weight[i];
        power.incoming += area * direct;
        power.absorbed += area * (1.0 - beta) * H;
        power.escaped += area * beta * H * (1.0 - from_disc(alpha).form_factor);
    }
    for (std::size_t i = 0; i < disc_.node.size(); ++i) {
        const double u = disc_.node[i], direct = direct_disc(u), H = direct + disc_.H[i];
        const double area = 2.0 * pi * h * h * u * disc_.weight[i];
        power.incoming += area * direct;
        power.absorbed += area * (1.0 - delta) * H;
        power.escaped += area * delta * H * (1.0 - from_ball(u).form_factor);
    }
    return power;
}

} // namespace difusa
