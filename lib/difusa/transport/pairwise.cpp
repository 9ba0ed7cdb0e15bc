#include <difusa/transport/pairwise.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/transport/gathered.h>

#include <cstdint>
#include <utility>

namespace difusa {

namespace {

/// W = [S M, Y].
class PairwiseOperator final : public LinearOperator {
  public:
    /// `Y`: of a gathered transport over the same surfels.
    PairwiseOperator(std::shared_ptr<const SparseRows> S, std::shared_ptr<const BasisAverages> P,
                     Eigen::VectorXd surfel_area, Eigen::VectorXd inverse_area, std::shared_ptr<const LinearOperator> Y)
        : S_(std::move(S)), P_(std::move(P)), surfel_area_(std::move(surfel_area)),
          inverse_area_(std::move(inverse_area)), Y_(std::move(Y)) {}

    std::size_t rows() const override { return S_->rows(); }
    std::size_t columns() const override { return Y_->columns(); }

    void apply(const Values& x, Values& y, const Execution& execution) const override {
        DIFUSA_REQUIRE(static_cast<std::size_t>(x.rows()) == columns());
        Values scaled = x.topRows(surfel_area_.size()), at_sites;
        scaled.array().colwise() *= surfel_area_.array();
        P_->apply_transpose(scaled, at_sites, execution);
        at_sites.array().colwise() *= inverse_area_.array();
        S_->apply(at_sites, y, execution);
        if (const Eigen::Index sky = x.rows() - surfel_area_.size(); !x.bottomRows(sky).isZero(0.0)) {
            Values only_sky = Values::Zero(x.rows(), x.cols()), from_sky;
            only_sky.bottomRows(sky) = x.bottomRows(sky);
            Y_->apply(only_sky, from_sky, execution);
            y += from_sky;
        }
    }

    void apply_transpose(const Values& x, Values& y, const Execution& execution) const override {
        Values at_sites, at_surfels;
        S_->apply_transpose(x, at_sites, execution);
        at_sites.array().colwise() *= inverse_area_.array();
        P_->apply(at_sites, at_surfels, execution);
        at_surfels.array().colwise() *= surfel_area_.array();
        Y_->apply_transpose(x, y, execution);
        y.topRows(surfel_area_.size()) = at_surfels;
    }

    std::size_t entry_count() const override { return S_->nonzeros() + P_->entry_count(); }

    PairwiseParts parts() const { return {S_, Y_}; }

    SparseRows distribution() const {
        SparseRows M(S_->columns(), P_->rows());
        BasisRow row;
        for (Index s = 0; s < P_->rows(); ++s) {
            P_->row(s, row);
            for (std::size_t i = 0; i < row.element.size(); ++i) {
                SparseRows::Row& patch = M.row(row.element[i]);
                patch.column.push_back(s);
                patch.value.push_back(inverse_area_[row.element[i]] * row.weight[i] * surfel_area_[s]);
            }
        }
        return M;
    }

  private:
    std::shared_ptr<const SparseRows> S_;
    std::shared_ptr<const BasisAverages> P_;
    Eigen::VectorXd surfel_area_, inverse_area_;
    std::shared_ptr<const LinearOperator> Y_;
};

/// The pairs j < k that exchange light: one segment per pair, whatever the kernel's asymmetry. Adds to `segments`.
std::vector<std::vector<Index>> pairs_in_sight(const Tracer& tracer, const SiteSet& sites, std::size_t& segments,
                                               const Execution& execution) {
    const std::size_t n = sites.size();
    std::vector<std::vector<Index>> sees(n);
    std::vector<std::size_t> cast(n, 0);
    parallel_for(n, 4, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        std::vector<Segment> ways;
        std::vector<Index> other;
        std::vector<std::uint8_t> blocked;
        for (std::size_t j = begin; j < end; ++j) {
            ways.clear();
            other.clear();
            const SurfacePoint& x = sites.points[j];
            for (std::size_t k = j + 1; k < n; ++k) {
                const SurfacePoint& y = sites.points[k];
                const Vec3 way = y.position - x.position;
                if (x.normal.dot(way) > 0.0 && y.normal.dot(way) < 0.0) {
                    ways.push_back({x.position, y.position, x.face, y.face});
                    other.push_back(static_cast<Index>(k));
                }
            }
            blocked.resize(ways.size());
            cast[j] = tracer.occluded_between(ways, blocked);
            for (std::size_t i = 0; i < ways.size(); ++i) {
                if (blocked[i] == 0) {
                    sees[j].push_back(other[i]);
                }
            }
        }
    });
    for (const std::size_t count : cast) {
        segments += count;
    }
    return sees;
}

/// The sum of two sparse rows.
SparseRows::Row sum(const SparseRows::Row& a, const SparseRows::Row& b) {
    SparseRows::Row row;
    std::size_t i = 0, k = 0;
    while (i < a.column.size() || k < b.column.size()) {
        const bool from_a = k == b.column.size() || (i < a.column.size() && a.column[i] <= b.column[k]);
        const bool from_b = i == a.column.size() || (k < b.column.size() && b.column[k] <= a.column[i]);
        row.column.push_back(from_a ? a.column[i] : b.column[k]);
        row.value.push_back((from_a ? a.value[i] : 0.0) + (from_b ? b.value[k] : 0.0));
        i += from_a ? 1 : 0;
        k += from_b ? 1 : 0;
    }
    return row;
}

} // namespace

LightTransport pairwise(const Tracer& tracer, const Discretisation& discretisation, const Kernel& kernel,
                        const MirrorPathOptions& over_mirrors, const Directions& directions, std::size_t rays,
                        std::uint64_t seed, const Execution& execution) {
    if (!tracer.mesh().mirrors.is_grey()) {
        throw UsageError("--transport pairwise: has one form factor between two sites for all channels, but mirrors "
                         "reflect them differently; use --transport gather, or mirrors without colour");
    }
    const SiteSet& sites = *discretisation.sites;
    const Surfels& surfels = *discretisation.surfels;
    const std::size_t n = sites.size();
    LightTransport transport = gathered(tracer, sites.points, surfels, directions, rays, seed, execution);
    std::vector<std::vector<Index>> sees = pairs_in_sight(tracer, sites, transport.segments, execution);

    // Row j: first the k < j, then the k > j. Lists of the former are gathered in order of k.
    std::vector<std::vector<Index>> seen_by(n);
    for (std::size_t j = 0; j < n; ++j) {
        for (const Index k : sees[j]) {
            seen_by[k].push_back(static_cast<Index>(j));
        }
    }
    const auto form_factors = std::make_shared<SparseRows>(n, n);
    SparseRows& S = *form_factors;
    parallel_for(n, 16, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t j = begin; j < end; ++j) {
            SparseRows::Row& row = S.row(j);
            row.column = std::move(seen_by[j]);
            row.column.insert(row.column.end(), sees[j].begin(), sees[j].end());
            row.value.reserve(row.column.size());
            for (const Index k : row.column) {
                row.value.push_back(kernel.form_factor(sites.points[j].position, sites.points[j].normal,
                                                       sites.points[k].position, sites.points[k].normal,
                                                       sites.area[k]));
            }
            sees[j] = {};
        }
    });
    if (tracer.mesh().mirrors.any()) {
        const MirroredFactors mirrored = mirrored_factors(tracer, discretisation, kernel, over_mirrors, execution);
        transport.segments += mirrored.rays;
        for (std::size_t j = 0; j < n; ++j) {
            S.row(j) = sum(S.row(j), mirrored.rows[j]);
        }
    }
    transport.bytes += S.bytes();
    transport.W = pairwise_operator(form_factors, transport.W, discretisation, execution);
    return transport;
}

std::shared_ptr<const LinearOperator> pairwise_operator(std::shared_ptr<const SparseRows> S,
                                                        std::shared_ptr<const LinearOperator> gathered,
                                                        const Discretisation& discretisation,
                                                        const Execution& execution) {
    const Surfels& surfels = *discretisation.surfels;
    const std::size_t n = discretisation.sites->size();
    // A_s / sigma_s, 0 where no basis function is nonzero. Exactly A_s for a partition of unity.
    Values sigma;
    discretisation.averages->apply(Values::Ones(static_cast<Eigen::Index>(n), 1), sigma, execution);
    Eigen::VectorXd surfel_area(static_cast<Eigen::Index>(surfels.size()));
    for (Index s = 0; s < surfels.size(); ++s) {
        surfel_area[s] = sigma(s, 0) > 0.0 ? surfels.area(s) / sigma(s, 0) : 0.0;
    }
    Eigen::VectorXd inverse_area(static_cast<Eigen::Index>(n));
    for (std::size_t k = 0; k < n; ++k) {
        const double A = discretisation.integrals[k];
        inverse_area[static_cast<Eigen::Index>(k)] = A != 0.0 ? 1.0 / A : 0.0;
    }
    return std::make_shared<PairwiseOperator>(std::move(S), discretisation.averages, std::move(surfel_area),
                                              std::move(inverse_area), std::move(gathered));
}

SparseRows pairwise_distribution(const LinearOperator& W) {
    const auto* const pairs = dynamic_cast<const PairwiseOperator*>(&W);
    DIFUSA_REQUIRE(pairs != nullptr);
    return pairs->distribution();
}

PairwiseParts pairwise_parts(const LinearOperator& W) {
    const auto* const pairs = dynamic_cast<const PairwiseOperator*>(&W);
    return pairs != nullptr ? pairs->parts() : PairwiseParts();
}

} // namespace difusa
