#include <difusa/form_factors/closure.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace difusa {

namespace {

constexpr int most_closure_rounds = 20; ///< of setting negative entries to 0
constexpr double closed_within = 1e-13; ///< row sums, of 1
constexpr double solved_within = 1e-15;

/// G by rows, symmetric.
struct ExchangeMatrix {
    std::vector<FormFactors::Row> rows; ///< `factor` holds the exchange areas

    explicit ExchangeMatrix(const FormFactors& F) : rows(F.size()) {
        // Both directions, so that what one row lacks the other supplies.
        for (std::size_t i = 0; i < F.size(); ++i) {
            const FormFactors::Row& row = F.rows[i];
            for (std::size_t e = 0; e < row.column.size(); ++e) {
                const Index j = row.column[e];
                const double G = 0.5 * (F.area[i] * row.factor[e] + F.area[j] * F.at(j, i));
                add(i, j, G);
                if (j != i && !F.find(j, i)) {
                    add(j, static_cast<Index>(i), G);
                }
            }
        }
        for (FormFactors::Row& row : rows) {
            sort(row);
        }
    }

    Eigen::VectorXd times(const Eigen::VectorXd& x) const {
        Eigen::VectorXd y = Eigen::VectorXd::Zero(x.size());
        for (std::size_t i = 0; i < rows.size(); ++i) {
            for (std::size_t e = 0; e < rows[i].column.size(); ++e) {
                y[static_cast<Eigen::Index>(i)] += rows[i].factor[e] * x[rows[i].column[e]];
            }
        }
        return y;
    }

  private:
    void add(std::size_t i, Index j, double G) {
        rows[i].column.push_back(j);
        rows[i].factor.push_back(G);
    }
    static void sort(FormFactors::Row& row) {
        std::vector<std::pair<Index, double>> entries;
        for (std::size_t e = 0; e < row.column.size(); ++e) {
            entries.emplace_back(row.column[e], row.factor[e]);
        }
        std::sort(entries.begin(), entries.end());
        for (std::size_t e = 0; e < entries.size(); ++e) {
            row.column[e] = entries[e].first;
            row.factor[e] = entries[e].second;
        }
    }
};

/// (diag(r) + G) l = A - r by conjugate gradients with r as preconditioner.
Eigen::VectorXd multipliers(const ExchangeMatrix& G, const Eigen::VectorXd& r, const Eigen::VectorXd& A) {
    const auto apply = [&](const Eigen::VectorXd& x) { return Eigen::VectorXd(r.cwiseProduct(x) + G.times(x)); };
    Eigen::VectorXd l = Eigen::VectorXd::Zero(r.size()), residual = A - r;
    Eigen::VectorXd z = residual.cwiseQuotient(r), p = z;
    double rz = residual.dot(z);
    for (Eigen::Index k = 0; k < 10 * r.size() + 100; ++k) {
        if (!(residual.cwiseQuotient(A).cwiseAbs().maxCoeff() > solved_within) || !(rz > 0.0)) {
            break;
        }
        const Eigen::VectorXd Kp = apply(p);
        const double curvature = p.dot(Kp);
        if (!(curvature > 0.0)) {
            break;
        }
        const double step = rz / curvature;
        l += step * p;
        residual -= step * Kp;
        z = residual.cwiseQuotient(r);
        const double next = residual.dot(z);
        p = z + next / rz * p;
        rz = next;
    }
    return l;
}

void require_nearly_closed(const FormFactors& F, const std::vector<std::string>& names, double largest_gap) {
    for (std::size_t i = 0; i < F.size(); ++i) {
        const double sum = F.row_sum(i);
        if (!(std::abs(sum - 1.0) <= largest_gap)) {
            const std::string name = i < names.size() ? "\"" + names[i] + "\"" : std::to_string(i);
            throw InputError("the form factors of surface " + name + " sum to " + text_of(sum) +
                             ": closure can only be enforced on a closed surface whose fronts face inwards; what "
                             "escapes from an open one is no error");
        }
    }
}

} // namespace

ClosureCorrection enforce_closure(FormFactors& F, const std::vector<std::string>& names, double largest_gap) {
    require_nearly_closed(F, names, largest_gap);
    ExchangeMatrix G(F);
    const Eigen::VectorXd A = Eigen::Map<const Eigen::VectorXd>(F.area.data(), static_cast<Eigen::Index>(F.size()));
    Eigen::VectorXd l;
    for (int round = 0;; ++round) {
        const Eigen::VectorXd r = G.times(Eigen::VectorXd::Ones(A.size()));
        l = multipliers(G, r, A);
        bool negative = false;
        for (std::size_t i = 0; i < G.rows.size(); ++i) {
            for (std::size_t e = 0; e < G.rows[i].column.size(); ++e) {
                double& entry = G.rows[i].factor[e];
                if (entry > 0.0 && 1.0 + l[static_cast<Eigen::Index>(i)] + l[G.rows[i].column[e]] < 0.0) {
                    entry = 0.0;
                    negative = true;
                }
            }
        }
        if (!negative) {
            break;
        }
        if (round == most_closure_rounds) {
            throw NotConverged("closure: no form factors without negative ones were found near the given ones");
        }
    }
    ClosureCorrection correction;
    double squares = 0.0, weights = 0.0;
    std::vector<FormFactors::Row> rows(F.size());
    for (std::size_t i = 0; i < F.size(); ++i) {
        for (std::size_t e = 0; e < G.rows[i].column.size(); ++e) {
            const Index j = G.rows[i].column[e];
            const std::optional<std::size_t> known = F.find(i, j);
            const double before = known ? F.rows[i].factor[*known] : 0.0;
            const double X = G.rows[i].factor[e] * (1.0 + l[static_cast<Eigen::Index>(i)] + l[j]);
            const double after = X / F.area[i], change = std::abs(after - before);
            correction.largest = std::max(correction.largest, change);
            if (before > 0.0) {
                correction.largest_relative = std::max(correction.largest_relative, change / before);
                squares += F.area[i] * change * change / before;
                weights += F.area[i] * before;
            }
            const float error = known ? F.rows[i].error[*known] : 0.0F;
            rows[i].column.push_back(j);
            rows[i].factor.push_back(after);
            rows[i].error.push_back(error + static_cast<float>(change));
        }
    }
    F.rows = std::move(rows);
    correction.rms_relative = weights > 0.0 ? std::sqrt(squares / weights) : 0.0;
    for (std::size_t i = 0; i < F.size(); ++i) {
        correction.row_sum_error = std::max(correction.row_sum_error, std::abs(F.row_sum(i) - 1.0));
    }
    if (!(correction.row_sum_error <= closed_within * std::sqrt(static_cast<double>(F.size()) + 100.0))) {
        throw NotConverged("closure: the row sums differ from 1 by up to " + text_of(correction.row_sum_error) +
                           " still: no symmetric exchange areas have these areas as their sums");
    }
    return correction;
}

} // namespace difusa
