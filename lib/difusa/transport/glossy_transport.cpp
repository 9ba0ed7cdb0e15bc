#include <difusa/transport/glossy_transport.h>

#include <difusa/algebra/column_panels.h>
#include <difusa/algebra/transpose_sum.h>
#include <difusa/algebra/wide_vectors.h>
#include <difusa/core/error.h>
#include <difusa/core/frame.h>
#include <difusa/core/parallel.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <tuple>

namespace difusa {

namespace {

constexpr std::size_t most_reflections = 64; ///< in a row
constexpr double negligible = 1e-9;          ///< of what is left after them
constexpr int power_steps = 8;

/// `count` of the columns of sum += factor Y c, where c has rows of `width` numbers. Sums of even and odd rows apart
/// are quicker with few columns.
template <int count>
void add_panel(double factor, const std::vector<double>& Y, const double* c, Eigen::Index width, double* sum) {
    constexpr std::size_t apart = count < 8 ? 2 : 1;
    double sums[apart][count] = {};
    std::size_t k = 0;
    for (; k + apart <= Y.size(); k += apart) {
        for (std::size_t row = 0; row < apart; ++row, c += width) {
            for (int column = 0; column < count; ++column) {
                sums[row][column] += Y[k + row] * c[column];
            }
        }
    }
    for (int column = 0; column < count; ++column) {
        const double last = k < Y.size() ? Y[k] * c[column] : 0.0;
        sum[column] += factor * (sums[0][column] + (apart == 2 ? sums[1][column] : 0.0) + last);
    }
}

/// sum += factor Y c, with rows of c from `first` on.
void add_product(double factor, const std::vector<double>& Y, const Values& c, Eigen::Index first, double* sum) {
    const double* const from = c.data() + first * c.cols();
    with_wide_vectors([&] {
        for_panels<24, 21, 12, 9, 3, 1>(c.cols(), [&](auto count, Eigen::Index column) {
            add_panel<count>(factor, Y, from + column, c.cols(), sum + column);
        });
    });
}

/// Rows of c from `first` on += factor Yᵀ y.
void add_multiples(double factor, const std::vector<double>& Y, const Eigen::Ref<const Eigen::RowVectorXd>& y,
                   Eigen::Index first, Values& c) {
    for (std::size_t k = 0; k < Y.size(); ++k) {
        for (Eigen::Index column = 0; column < c.cols(); ++column) {
            c(first + static_cast<Eigen::Index>(k), column) += factor * Y[k] * y[column];
        }
    }
}

/// Row s of P Π.
SparseRows::Row row_of_points(const BasisAverages& P, const std::optional<SparseRows>& projection, Index s) {
    BasisRow row;
    P.row(s, row);
    if (!projection) {
        return {row.element, row.weight};
    }
    std::map<Index, double> sum;
    for (std::size_t i = 0; i < row.element.size(); ++i) {
        const SparseRows::Row& points = projection->row(row.element[i]);
        for (std::size_t k = 0; k < points.column.size(); ++k) {
            sum[points.column[k]] += row.weight[i] * points.value[k];
        }
    }
    SparseRows::Row result;
    for (const auto& [point, weight] : sum) {
        result.column.push_back(point);
        result.value.push_back(weight);
    }
    return result;
}

} // namespace

GlossyTransport::GlossyTransport(std::shared_ptr<const LinearOperator> plain, std::shared_ptr<const GlossyRays> rays,
                                 const Discretisation& discretisation, const GlossySurfaces& glossy, int order,
                                 const Execution& execution)
    : plain_(std::move(plain)), rays_(std::move(rays)), harmonics_(order), channels_(glossy.is_grey() ? 1 : 3) {
    for (const std::shared_ptr<const GlossyLobe>& lobe : glossy.lobes) {
        lobes_.emplace_back(*lobe, harmonics_);
    }
    make_elements(discretisation, execution);
    find_reflections(execution);
}

void GlossyTransport::make_elements(const Discretisation& discretisation, const Execution& execution) {
    std::vector<std::vector<Index>> element(lobes_.size(), std::vector<Index>(rays_->points(), none));
    std::map<std::tuple<double, double, double>, Index> known;
    for (Index lobe = 0; lobe < lobes_.size(); ++lobe) {
        for (std::size_t j = 0; j < rays_->points(); ++j) {
            if (!rays_->reflects(lobe, j)) {
                continue;
            }
            element[lobe][j] = static_cast<Index>(point_of_.size());
            const Vec3& n = rays_->normal(j);
            const auto [at, is_new] = known.try_emplace({n[0], n[1], n[2]}, static_cast<Index>(frames_.size()));
            if (is_new) {
                frames_.push_back(frame_of(n));
            }
            point_of_.push_back(static_cast<Index>(j));
            lobe_of_.push_back(lobe);
            rotation_of_.push_back(at->second);
        }
    }
    rotations_.resize(frames_.size());
    parallel_for(frames_.size(), 16, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t r = begin; r < end; ++r) {
            rotations_[r] = harmonics_.rotation(frames_[r]);
        }
    });
    const Projection& projection = *discretisation.projection;
    const std::optional<SparseRows> matrix = projection.matrix();
    if (!projection.is_identity() && !matrix) {
        throw UsageError("glossy materials need elements whose coefficients follow from values nearby: use --basis "
                         "moving-least-squares, normalized-radial or shepard, with their own --projection");
    }
    const std::vector<GlossySurfels::Part>& parts = rays_->surfels().parts();
    weights_.resize(parts.size());
    parallel_for(parts.size(), 256, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t p = begin; p < end; ++p) {
            const SparseRows::Row row = row_of_points(*discretisation.averages, matrix, parts[p].surfel);
            for (std::size_t k = 0; k < row.column.size(); ++k) {
                const Index number = element[parts[p].lobe][row.column[k]];
                DIFUSA_REQUIRE(number != none, "a glossy surfel is in the reach of an element of another region");
                weights_[p].emplace_back(number, row.value[k]);
            }
        }
    });
}

/// Terms of the series until `negligible` is left, by how much a reflection leaves of the one before it.
void GlossyTransport::find_reflections(const Execution& execution) {
    const bool meet = [&] {
        for (std::size_t e = 0; e < elements(); ++e) {
            for (const GlossyRays::Ray& ray : rays_->rays(point_of_[e])) {
                if (!rays_->surfels().of(ray.bin).empty()) {
                    return true;
                }
            }
        }
        return false;
    }();
    if (!meet) {
        return;
    }
    Values c = to_surfels(Values::Constant(coefficient_rows(), 1, 1.0), execution);
    double factor = 0.0;
    for (int k = 0; k < power_steps; ++k) {
        const double before = c.norm();
        if (!(before > 0.0)) {
            return;
        }
        c /= before;
        c = to_surfels(reflect(nullptr, &c, false, 1, execution), execution);
        factor = c.norm();
    }
    if (!(factor > 0.0)) {
        reflections_ = power_steps;
        return;
    }
    const double needed = factor < 1.0 ? std::ceil(std::log(negligible) / std::log(factor)) : 1e9;
    reflections_ = static_cast<std::size_t>(std::min<double>(most_reflections, std::max(1.0, needed)));
    cut_off_ = std::min(1.0, std::pow(factor, static_cast<double>(reflections_)));
}

Eigen::Index GlossyTransport::coefficient_rows() const {
    return static_cast<Eigen::Index>(elements()) * width();
}

/// The reflectance of a part for one of so many columns.
double GlossyTransport::factor(Index part, Eigen::Index column, Eigen::Index columns) const {
    const Rgb& reflectance = rays_->surfels().parts()[part].reflectance;
    DIFUSA_REQUIRE(channels_ == 1 || columns == 1 || columns % 3 == 0);
    return channels_ == 1 ? reflectance[0] : columns == 1 ? reflectance.maxCoeff() : reflectance[column % 3];
}

/// Sets Y to the harmonics towards the origin of a ray that meets glossy parts, and calls `act` with the number of the
/// first coefficient of each.
template <class Act>
void GlossyTransport::at_ray(const GlossyRays::Ray& ray, std::vector<double>& Y, const Act& act) const {
    const GlossySurfels::Range range = rays_->surfels().of(ray.bin);
    if (range.empty()) {
        return;
    }
    harmonics_.at(-ray.direction(), Y);
    for (Index part = range.begin; part < range.end; ++part) {
        act(static_cast<Eigen::Index>(part) * width());
    }
}

/// w_d (F_k(ω_d) - mean F_k + F*_k): #harmonics of the lobe by #rays.
Eigen::MatrixXd GlossyTransport::scattering(std::size_t element) const {
    const LobeHarmonics& lobe = lobes_[lobe_of_[element]];
    const std::vector<GlossyRays::Ray>& rays = rays_->rays(point_of_[element]);
    const auto kept = static_cast<Eigen::Index>(lobe.numbers().size());
    const Eigen::Matrix3d& frame = frames_[rotation_of_[element]];
    Eigen::MatrixXd F(kept, static_cast<Eigen::Index>(rays.size()));
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(kept);
    for (std::size_t d = 0; d < rays.size(); ++d) {
        const auto column = static_cast<Eigen::Index>(d);
        lobe.at(frame.transpose() * rays[d].direction(),
                std::span(F.col(column).data(), static_cast<std::size_t>(kept)));
        mean += rays[d].weight * F.col(column);
    }
    mean[0] -= LobeHarmonics::even();
    for (std::size_t d = 0; d < rays.size(); ++d) {
        const auto column = static_cast<Eigen::Index>(d);
        F.col(column) = rays[d].weight * (F.col(column) - mean);
    }
    return F;
}

/// R x + R_g c, of which either may be missing; `backs`: R applied to 1 on backs instead.
Values GlossyTransport::reflect(const Values* x, const Values* c, bool backs, Eigen::Index columns,
                                const Execution& execution) const {
    Values result(coefficient_rows(), columns);
    parallel_for(elements(), 8, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        std::vector<double> Y(harmonics_.count());
        Values own = Values::Zero(width(), columns);
        for (std::size_t e = begin; e < end; ++e) {
            const std::vector<GlossyRays::Ray>& rays = rays_->rays(point_of_[e]);
            Values arriving = Values::Zero(static_cast<Eigen::Index>(rays.size()), columns);
            for (std::size_t d = 0; d < rays.size(); ++d) {
                const auto row = static_cast<Eigen::Index>(d);
                if (backs) {
                    arriving.row(row).setConstant(rays[d].bin == none ? 1.0 : 0.0);
                } else if (x != nullptr && rays[d].bin != none) {
                    arriving.row(row) = x->row(static_cast<Eigen::Index>(rays[d].bin));
                }
                if (c != nullptr) {
                    at_ray(rays[d], Y,
                           [&](Eigen::Index first) { add_product(1.0, Y, *c, first, arriving.row(row).data()); });
                }
            }
            const Values leaving = scattering(e) * arriving;
            const std::vector<std::size_t>& numbers = lobes_[lobe_of_[e]].numbers();
            for (std::size_t k = 0; k < numbers.size(); ++k) { // the others stay 0
                own.row(static_cast<Eigen::Index>(numbers[k])) = leaving.row(static_cast<Eigen::Index>(k));
            }
            SphericalHarmonics::rotate(rotations_[rotation_of_[e]], own,
                                       result.middleRows(static_cast<Eigen::Index>(e) * width(), width()));
        }
    });
    return result;
}

/// Adds Rᵀ points to *x and R_gᵀ points to *c, of which either may be missing.
void GlossyTransport::reflect_transposed(const Values& points, Values* x, Values* c, const Execution& execution) const {
    const std::size_t bins = x == nullptr ? 0 : columns();
    const std::size_t rows = bins + (c == nullptr ? 0 : static_cast<std::size_t>(c->rows()));
    Values sum;
    sum_transposed(elements(), rows, points.cols(), sum, execution, [&](std::size_t e, Values& part) {
        std::vector<double> Y(harmonics_.count());
        Values own(width(), points.cols());
        SphericalHarmonics::rotate_back(rotations_[rotation_of_[e]],
                                        points.middleRows(static_cast<Eigen::Index>(e) * width(), width()), own);
        const std::vector<std::size_t>& numbers = lobes_[lobe_of_[e]].numbers();
        Values leaving(static_cast<Eigen::Index>(numbers.size()), points.cols());
        for (std::size_t k = 0; k < numbers.size(); ++k) {
            leaving.row(static_cast<Eigen::Index>(k)) = own.row(static_cast<Eigen::Index>(numbers[k]));
        }
        const Values arriving = scattering(e).transpose() * leaving;
        const std::vector<GlossyRays::Ray>& rays = rays_->rays(point_of_[e]);
        for (std::size_t d = 0; d < rays.size(); ++d) {
            const auto row = static_cast<Eigen::Index>(d);
            if (x != nullptr && rays[d].bin != none) {
                part.row(static_cast<Eigen::Index>(rays[d].bin)) += arriving.row(row);
            }
            if (c != nullptr) {
                at_ray(rays[d], Y, [&](Eigen::Index first) {
                    add_multiples(1.0, Y, arriving.row(row), static_cast<Eigen::Index>(bins) + first, part);
                });
            }
        }
    });
    if (x != nullptr) {
        *x += sum.topRows(static_cast<Eigen::Index>(bins));
    }
    if (c != nullptr) {
        *c += sum.bottomRows(c->rows());
    }
}

/// S
Values GlossyTransport::to_surfels(const Values& points, const Execution& execution) const {
    Values c(static_cast<Eigen::Index>(weights_.size()) * width(), points.cols());
    parallel_for(weights_.size(), 64, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t p = begin; p < end; ++p) {
            auto own = c.middleRows(static_cast<Eigen::Index>(p) * width(), width());
            own.setZero();
            const Eigen::Index size = own.size();
            double* const sum = own.data(); // all columns at once
            with_wide_vectors([&] {
                for (const auto& [element, weight] : weights_[p]) {
                    const double* const from = points.data() + static_cast<Eigen::Index>(element) * size;
                    for (Eigen::Index i = 0; i < size; ++i) {
                        sum[i] += weight * from[i];
                    }
                }
            });
            for (Eigen::Index column = 0; column < c.cols(); ++column) {
                own.col(column) *= factor(static_cast<Index>(p), column, c.cols());
            }
        }
    });
    return c;
}

/// Sᵀ
Values GlossyTransport::to_points(const Values& c, const Execution& execution) const {
    Values points;
    sum_transposed(weights_.size(), static_cast<std::size_t>(coefficient_rows()), c.cols(), points, execution,
                   [&](std::size_t p, Values& part) {
                       Values own = c.middleRows(static_cast<Eigen::Index>(p) * width(), width());
                       for (Eigen::Index column = 0; column < c.cols(); ++column) {
                           own.col(column) *= factor(static_cast<Index>(p), column, c.cols());
                       }
                       for (const auto& [element, weight] : weights_[p]) {
                           part.middleRows(static_cast<Eigen::Index>(element) * width(), width()) += weight * own;
                       }
                   });
    return points;
}

/// c + S R_g c + (S R_g)² c + ...
Values GlossyTransport::series(Values c, const Execution& execution) const {
    if (reflections_ == 0) {
        return c;
    }
    Values sum = c;
    for (std::size_t k = 0; k < reflections_; ++k) {
        c = to_surfels(reflect(nullptr, &c, false, c.cols(), execution), execution);
        sum += c;
    }
    return sum;
}

/// V. The coefficients of many columns are more than fits in a cache that is near, and points see surfels in no order.
/// So the parts are divided into tiles that fit, each of which serves all points of a block.
Values GlossyTransport::view(const Values& c, const Execution& execution) const {
    constexpr Eigen::Index tile_size = Eigen::Index{3} << 14U; // numbers: 384 KiB
    constexpr std::size_t most_points = 512;
    const std::vector<GlossySurfels::Part>& parts = rays_->surfels().parts();
    const auto tile = static_cast<std::size_t>(std::max<Eigen::Index>(1, tile_size / (width() * c.cols())));
    const std::size_t for_each = rows() / (8 * static_cast<std::size_t>(std::max(1U, execution.threads)));
    Values y = Values::Zero(static_cast<Eigen::Index>(rows()), c.cols());
    parallel_for(rows(), std::clamp<std::size_t>(for_each, 16, most_points), execution.silent(),
                 [&](std::size_t begin, std::size_t end, unsigned) {
                     std::vector<double> Y(harmonics_.count());
                     std::vector<std::size_t> next(end - begin, 0); // ray of each point
                     for (std::size_t part = 0; part < parts.size();) {
                         part += tile;
                         const Index last = part < parts.size() ? parts[part].surfel : none;
                         for (std::size_t j = begin; j < end; ++j) {
                             const std::vector<GlossyRays::Ray>& rays = rays_->rays(j);
                             for (std::size_t& d = next[j - begin]; d < rays.size() && rays[d].bin < last; ++d) {
                                 at_ray(rays[d], Y, [&](Eigen::Index first) {
                                     add_product(rays[d].weight, Y, c, first,
                                                 y.row(static_cast<Eigen::Index>(j)).data());
                                 });
                             }
                         }
                     }
                 });
    return y;
}

/// Vᵀ
Values GlossyTransport::view_transposed(const GlossyRays& rays, const Values& y, const Execution& execution) const {
    Values c;
    sum_transposed(rays.points(), weights_.size() * harmonics_.count(), y.cols(), c, execution,
                   [&](std::size_t j, Values& part) {
                       std::vector<double> Y(harmonics_.count());
                       for (const GlossyRays::Ray& ray : rays.rays(j)) {
                           at_ray(ray, Y, [&](Eigen::Index first) {
                               add_multiples(ray.weight, Y, y.row(static_cast<Eigen::Index>(j)), first, part);
                           });
                       }
                   });
    return c;
}

void GlossyTransport::apply(const Values& x, Values& y, const Execution& execution) const {
    plain_->apply(x, y, execution);
    y += from_surfels(to_surfels(reflect(&x, nullptr, false, x.cols(), execution), execution), execution);
}

void GlossyTransport::apply_transpose(const Values& x, Values& y, const Execution& execution) const {
    plain_->apply_transpose(x, y, execution);
    add_seen(*rays_, x, y, execution);
}

void GlossyTransport::add_seen(const GlossyRays& rays, const Values& y, Values& bins,
                               const Execution& execution) const {
    DIFUSA_REQUIRE(rays.surfels().parts().size() == weights_.size());
    Values c = view_transposed(rays, y, execution), sum = c;
    for (std::size_t k = 0; k < reflections_; ++k) {
        const Values points = to_points(c, execution);
        c.setZero();
        reflect_transposed(points, nullptr, &c, execution);
        sum += c;
    }
    reflect_transposed(to_points(sum, execution), &bins, nullptr, execution);
}

Values GlossyTransport::from_surfels(const Values& c, const Execution& execution) const {
    return view(series(c, execution), execution);
}

Values GlossyTransport::lost_on_backs(const Execution& execution) const {
    return from_surfels(to_surfels(reflect(nullptr, nullptr, true, channels_, execution), execution), execution);
}

std::size_t GlossyTransport::entry_count() const {
    std::size_t rays = 0;
    for (std::size_t j = 0; j < rays_->points(); ++j) {
        rays += rays_->rays(j).size();
    }
    std::size_t weights = 0;
    for (const auto& row : weights_) {
        weights += row.size();
    }
    return plain_->entry_count() + (rays + weights) * harmonics_.count() * (1 + reflections_);
}

std::size_t GlossyTransport::bytes() const {
    std::size_t sum = rays_->bytes();
    for (const auto& row : weights_) {
        sum += row.size() * sizeof(std::pair<Index, double>) + sizeof(std::vector<std::pair<Index, double>>);
    }
    for (const SphericalHarmonics::Rotation& rotation : rotations_) {
        for (const Eigen::MatrixXd& block : rotation) {
            sum += static_cast<std::size_t>(block.size()) * sizeof(double);
        }
    }
    return sum;
}

LightTransport with_gloss(LightTransport transport, const Discretisation& discretisation, const GlossySurfaces& glossy,
                          int order, const Execution& execution) {
    if (!transport.glossy) {
        return transport;
    }
    const auto reflecting =
        std::make_shared<GlossyTransport>(transport.W, transport.glossy, discretisation, glossy, order, execution);
    transport.W = reflecting;
    transport.bytes += reflecting->bytes();
    transport.back_in_mirrors = reflecting->lost_on_backs(execution);
    transport.cut_off.setZero(transport.back_in_mirrors.rows(), transport.back_in_mirrors.cols());
    return transport;
}

const GlossyTransport* glossy_part(const LinearOperator& W) {
    return dynamic_cast<const GlossyTransport*>(&W);
}

} // namespace difusa
