#include <difusa/transport/analytic_transport.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/transport/analytic_factors.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace difusa {

namespace {

constexpr Eigen::Index most_columns = 8; ///< of which moments are held at once

} // namespace

AnalyticTransport::AnalyticTransport(std::shared_ptr<const HitLists> by_rays, std::shared_ptr<const HitLists> rest,
                                     std::vector<double> scale, SparseRows factors, SurfelGroups groups)
    : by_rays_(std::move(by_rays)), rest_(std::move(rest)), scale_(std::move(scale)), factors_(std::move(factors)),
      groups_(std::move(groups)) {
    DIFUSA_REQUIRE(rest_->rows() == rows() && rest_->columns() == columns() && scale_.size() == rows() &&
                   factors_.rows() == rows() && factors_.columns() == SurfelGroups::moments * groups_.size());
}

template <class Operand>
void AnalyticTransport::apply_any(const Operand& x, Values& y, const Execution& execution) const {
    rest_->apply_to(x, y, execution);
    y.array().colwise() *= Eigen::Map<const Eigen::ArrayXd>(scale_.data(), y.rows());
    Values exact;
    for (Eigen::Index c = 0; c < x.cols(); c += most_columns) { // of many columns, moments would be much memory
        const Eigen::Index count = std::min(most_columns, x.cols() - c);
        const Values some = x.middleCols(c, count).template cast<double>();
        factors_.apply(groups_.moments_of(some), exact, execution);
        y.middleCols(c, count) += exact;
    }
}

void AnalyticTransport::apply(const Values& x, Values& y, const Execution& execution) const {
    apply_any(x, y, execution);
}

void AnalyticTransport::apply_single(const SingleValues& x, Values& y, const Execution& execution) const {
    apply_any(x, y, execution);
}

void AnalyticTransport::apply_transpose(const Values& x, Values& y, const Execution& execution) const {
    const Values scaled = x.array().colwise() * Eigen::Map<const Eigen::ArrayXd>(scale_.data(), x.rows());
    rest_->apply_transpose(scaled, y, execution);
    Values of_groups;
    for (Eigen::Index c = 0; c < x.cols(); c += most_columns) {
        const Eigen::Index count = std::min(most_columns, x.cols() - c);
        factors_.apply_transpose(x.middleCols(c, count), of_groups, execution);
        Values of_surfels = y.middleCols(c, count);
        groups_.add_transposed(of_groups, of_surfels);
        y.middleCols(c, count) = of_surfels;
    }
}

std::size_t AnalyticTransport::entry_count() const {
    return rest_->entry_count() + factors_.entry_count() + groups_.size();
}

Values AnalyticTransport::variance_of_rays(const Values& x, const Execution& execution) const {
    // With k of the N rays of a row left to R, and W = s k / N the weight of their mean, N W² v / k = s² (k / N) v.
    // Those that end in no bin, because they meet a back, are among the k, and bring nothing.
    Values mean, square, all, ones;
    rest_->apply(x, mean, execution);
    rest_->apply(x.cwiseAbs2(), square, execution);
    rest_->apply(Values::Ones(x.rows(), 1), ones, execution);
    by_rays_->apply(Values::Ones(x.rows(), 1), all, execution);
    for (Eigen::Index j = 0; j < mean.rows(); ++j) {
        const double share = 1.0 - (all(j, 0) - ones(j, 0)), scale = scale_[static_cast<std::size_t>(j)];
        for (Eigen::Index c = 0; c < mean.cols(); ++c) {
            mean(j, c) =
                share > 0.0 ? scale * scale * std::max(0.0, square(j, c) - mean(j, c) * mean(j, c) / share) : 0.0;
        }
    }
    return mean;
}

double AnalyticTransport::exact_share(std::size_t j) const {
    const SparseRows::Row& row = factors_.row(j);
    double sum = 0.0;
    for (std::size_t k = 0; k < row.column.size(); ++k) {
        sum += row.column[k] % SurfelGroups::moments == 0 ? row.value[k] : 0.0;
    }
    return sum;
}

double AnalyticTransport::share() const {
    double sum = 0.0;
    for (std::size_t j = 0; j < rows(); ++j) {
        sum += exact_share(j);
    }
    return sum / static_cast<double>(rows());
}

std::size_t AnalyticTransport::bytes() const {
    return rest_->bytes() + scale_.size() * sizeof(double) + factors_.bytes() + groups_.bytes();
}

namespace {

/// Points at which it is tried whether exact form factors pay.
constexpr std::size_t trial_points = 48;

/// They do where most rays leave the scene: of those that meet surface so few remain that their noise is the main
/// error. In closed rooms errors of the elements hide what is gained, at many times the cost of a ray.
constexpr double most_from_surfaces = 0.5;

/// They also have to account for this part of the light from surfaces, and to be found by no more steps than this for
/// each ray.
constexpr double least_share = 0.8, most_steps = 5.0;

/// By how many standard deviations of independent rays, and how many rays besides, the number that ended in a group may
/// differ from what its form factor lets expect. More are a sign of faces that lie on each other, of which rays see
/// one.
constexpr double most_deviations = 6.0, most_beside = 6.0;

bool is_plausible(double hits, double expected) {
    return std::abs(hits - expected) <= most_deviations * std::sqrt(expected) + most_beside;
}

/// The rows of AnalyticTransport, one at a time.
class AnalyticRows {
  public:
    /// Keeps references.
    AnalyticRows(std::size_t surfels, const HitLists& lists, const AnalyticFactors& factors)
        : lists_(lists), factors_(factors), rank_(surfels, none) {
        number_surfels();
    }

    struct Row {
        std::vector<AnalyticFactors::Factor> found;
        std::vector<Index> rest; ///< bins of the rays that count
        double scale = 1.0;      ///< of what they carry
        double exact = 0.0;      ///< sum of the form factors found
        AnalyticFactors::Worker worker;

        std::vector<Index> bins;                          ///< of all rays
        std::vector<std::pair<Index, std::size_t>> range; ///< by `found`, but in the order of ranks: number, hits
    };

    /// What point j sees, at x.
    void look(std::size_t j, const SurfacePoint& x, Row& row) const {
        factors_.find(x, row.found, row.worker);
        weigh(j, row);
    }

    /// What point j sees of the groups found.
    void weigh(std::size_t j, Row& row) const {
        lists_.row(j, row.bins);
        row.exact = 0.0;
        for (const GroupFactor& each : row.found) {
            row.exact += each.factor;
        }
        const std::size_t inside = split(row);
        const auto rays = static_cast<double>(lists_.rays());
        if (row.found.empty() || !is_plausible(static_cast<double>(inside), rays * row.exact) || is_refuted(row)) {
            row.found.clear();
            row.exact = 0.0;
            row.rest = row.bins;
            row.scale = 1.0;
        } else if (inside < lists_.rays() && row.exact < 1.0) {
            row.scale = (1.0 - row.exact) * rays / (rays - static_cast<double>(inside));
        } else { // rounding, or a rest that no ray has met
            for (GroupFactor& each : row.found) {
                each.factor /= row.exact;
                each.slope /= row.exact;
            }
            row.exact = 1.0;
            row.rest.clear();
            row.scale = 0.0;
        }
    }

  private:
    /// Numbers the surfels so that those of a group follow each other.
    void number_surfels() {
        const SurfelGroups& groups = factors_.tree().groups();
        first_.resize(groups.size());
        last_.resize(groups.size());
        std::vector<Index> open;
        if (groups.size() > 0) {
            open.push_back(static_cast<Index>(groups.size() - 1));
        }
        for (Index next = 0; !open.empty();) {
            const Index g = open.back();
            open.pop_back();
            first_[g] = next;
            if (groups[g].second == none) {
                rank_[groups[g].first] = next++;
            } else {
                open.push_back(groups[g].second);
                open.push_back(groups[g].first);
            }
        }
        for (Index g = 0; g < groups.size(); ++g) {
            last_[g] = groups[g].second == none ? first_[g] + 1 : last_[groups[g].second];
        }
    }

    /// Counts the rays that end in groups that are seen whole, and keeps the others in `rest`.
    std::size_t split(Row& row) const {
        row.range.clear();
        for (std::size_t i = 0; i < row.found.size(); ++i) {
            row.range.emplace_back(static_cast<Index>(i), 0);
        }
        const auto first_of = [&](Index i) { return first_[row.found[i].group]; };
        std::sort(row.range.begin(), row.range.end(),
                  [&](const auto& a, const auto& b) { return first_of(a.first) < first_of(b.first); });
        row.rest.clear();
        std::size_t inside = 0;
        for (const Index bin : row.bins) {
            const Index rank = bin < rank_.size() ? rank_[bin] : none;
            auto after = std::upper_bound(row.range.begin(), row.range.end(), rank,
                                          [&](Index r, const auto& each) { return r < first_of(each.first); });
            if (rank != none && after != row.range.begin() && rank < last_[row.found[(after - 1)->first].group]) {
                ++(after - 1)->second;
                ++inside;
            } else {
                row.rest.push_back(bin);
            }
        }
        return inside;
    }

    /// Whether the rays show that some form factor is wrong.
    bool is_refuted(const Row& row) const {
        return std::any_of(row.range.begin(), row.range.end(), [&](const auto& each) {
            return !is_plausible(static_cast<double>(each.second),
                                 static_cast<double>(lists_.rays()) * row.found[each.first].factor);
        });
    }

    const HitLists& lists_;
    const AnalyticFactors& factors_;
    std::vector<Index> rank_;         ///< by surfel; none: in no group
    std::vector<Index> first_, last_; ///< by group: of the ranks of its surfels, and after the last
};

/// The share of the rays that end on fronts.
double share_of_surfaces(const LightTransport& transport) {
    double sum = 0.0;
    for (std::size_t j = 0; j < transport.points(); ++j) {
        sum += 1.0 - transport.sky[j] - transport.back[j];
    }
    return sum / static_cast<double>(transport.points());
}

/// Whether exact form factors pay, as far as some of the points tell.
bool pays(const LightTransport& transport, const AnalyticRows& rows, std::span<const SurfacePoint> points,
          std::size_t rays) {
    const std::size_t step = std::max<std::size_t>(1, points.size() / trial_points);
    AnalyticRows::Row row;
    double exact = 0.0, from_surfaces = 0.0;
    const std::size_t tried = (points.size() + step - 1) / step;
    const double most = most_steps * static_cast<double>(tried * rays);
    for (std::size_t j = 0; j < points.size(); j += step) {
        rows.look(j, points[j], row);
        if (static_cast<double>(row.worker.steps) > most) {
            return false;
        }
        exact += row.exact;
        from_surfaces += 1.0 - transport.sky[j] - transport.back[j];
    }
    return exact >= least_share * from_surfaces;
}

/// The parts of an AnalyticTransport while its rows are set, in blocks.
struct Refined {
    Refined(std::size_t points, const HitLists& lists, std::size_t groups)
        : rest(std::make_shared<HitLists>(points, lists.columns(), lists.rays(), lists.rows_per_block())),
          exact(points, SurfelGroups::moments * groups), scale(points, 1.0) {}

    std::shared_ptr<HitLists> rest;
    SparseRows exact;
    std::vector<double> scale;
};

/// The row as two sparse ones, and what escapes.
void put(AnalyticRows::Row& row, std::size_t j, Refined& refined, LightTransport& transport) {
    SparseRows::Row& exact = refined.exact.row(j);
    const std::size_t rays = refined.rest->rays();
    std::size_t entries = row.found.size(); // most slopes are often 0, and what is reserved stays
    for (const GroupFactor& each : row.found) {
        entries += static_cast<std::size_t>((each.slope.array() != 0.0).count());
    }
    exact.column.reserve(entries);
    exact.value.reserve(entries);
    for (const auto& [group, factor, slope] : row.found) {
        const Index mean = SurfelGroups::mean_row(group);
        exact.column.push_back(mean);
        exact.value.push_back(factor);
        for (Index axis = 0; axis < 3; ++axis) {
            if (slope[axis] != 0.0) {
                exact.column.push_back(mean + 1 + axis);
                exact.value.push_back(slope[axis]);
            }
        }
    }
    const double weight = row.scale / static_cast<double>(rays);
    const auto first_sky = static_cast<Index>(transport.surfels);
    const auto escaped = std::count_if(row.rest.begin(), row.rest.end(), [&](Index bin) { return bin >= first_sky; });
    transport.sky[j] = weight * static_cast<double>(escaped);
    transport.back[j] = weight * static_cast<double>(rays - row.bins.size());
    refined.rest->set(j, row.rest);
    refined.scale[j] = row.scale;
}

/// The transport with rows that `set_row(j, row)` looks up.
template <class SetRow>
LightTransport refined(LightTransport transport, std::shared_ptr<const HitLists> lists, SurfelGroups groups,
                       const SetRow& set_row, const Execution& execution) {
    Refined parts(lists->rows(), *lists, groups.size());
    parallel_for(lists->rows(), lists->rows_per_block(), execution, [&](std::size_t begin, std::size_t end, unsigned) {
        AnalyticRows::Row row;
        for (std::size_t j = begin; j < end; ++j) {
            set_row(j, row);
            put(row, j, parts, transport);
        }
        parts.rest->close_block(begin);
    });
    auto W = std::make_shared<AnalyticTransport>(std::move(lists), std::move(parts.rest), std::move(parts.scale),
                                                 std::move(parts.exact), std::move(groups));
    transport.bytes += W->bytes();
    transport.W = std::move(W);
    return transport;
}

} // namespace

LightTransport with_analytic_factors(LightTransport transport, const Mesh& mesh, std::span<const SurfacePoint> points,
                                     const Surfels& surfels, AnalyticUse use, const Execution& execution) {
    const auto lists = std::dynamic_pointer_cast<const HitLists>(transport.W);
    if (use == AnalyticUse::never || !lists || points.empty() || mesh.mirrors.any() || mesh.repetition.any()) {
        return transport;
    }
    if (use == AnalyticUse::automatic && share_of_surfaces(transport) > most_from_surfaces) {
        return transport;
    }
    execution.phase("exact form factors");
    const AnalyticFactors factors(mesh, surfels, lists->rays(), execution);
    const AnalyticRows rows(transport.surfels, *lists, factors);
    if (use == AnalyticUse::automatic && !pays(transport, rows, points, lists->rays())) {
        return transport;
    }
    return refined(
        std::move(transport), lists, factors.tree().groups(),
        [&](std::size_t j, AnalyticRows::Row& row) { rows.look(j, points[j], row); }, execution);
}

FactorsOfPoints::FactorsOfPoints(const Mesh& mesh, std::span<const SurfacePoint> points, const Surfels& surfels,
                                 std::size_t rays, const Execution& execution)
    : factors_(std::make_unique<AnalyticFactors>(mesh, surfels, rays, execution)), found_(points.size()) {
    parallel_for(points.size(), 16, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        AnalyticFactors::Worker worker;
        for (std::size_t j = begin; j < end; ++j) {
            factors_->find(points[j], found_[j], worker);
        }
    });
}

FactorsOfPoints::~FactorsOfPoints() = default;

LightTransport FactorsOfPoints::refine(LightTransport transport, const Execution& execution) const {
    auto lists = std::dynamic_pointer_cast<const HitLists>(transport.W);
    DIFUSA_REQUIRE(lists && lists->rows() == found_.size());
    const AnalyticRows rows(transport.surfels, *lists, *factors_);
    return refined(
        std::move(transport), lists, factors_->tree().groups(),
        [&](std::size_t j, AnalyticRows::Row& row) {
            row.found = found_[j];
            rows.weigh(j, row);
        },
        execution);
}

} // namespace difusa
