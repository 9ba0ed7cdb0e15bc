// The matrix of form factors of a surface: exact between polygons that see each other, by exact visibility at points
// where something is in between, each with an estimate of its error.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/form_factors/pair_exchange.h>
#include <difusa/form_factors/surfaces.h>
#include <difusa/mesh/mesh.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace difusa {

/// F_ij is the share of what leaves surface i diffusely that arrives at the front of surface j first; A_i F_ij is
/// the exchange area. Zeros are not stored.
struct FormFactors {
    struct Row {
        std::vector<Index> column;  ///< ascending
        std::vector<double> factor; ///< F_ij
        std::vector<float> error;   ///< estimated error of F_ij, absolute
    };
    std::vector<Row> rows;    ///< #surfaces
    std::vector<double> area; ///< #surfaces, in the square of the unit of length

    std::size_t size() const { return rows.size(); }
    std::size_t nonzeros() const;

    /// Where F_ij is in row i, if it is stored.
    std::optional<std::size_t> find(std::size_t i, std::size_t j) const;

    /// F_ij; 0 if it is not stored.
    double at(std::size_t i, std::size_t j) const;

    /// sum_j F_ij: 1 in a closed scene (L 27); what is missing escapes, or meets backs of faces.
    double row_sum(std::size_t i) const;

    /// sum_j of the estimated errors of row i.
    double row_error(std::size_t i) const;
};

/// How well the laws of form factors hold.
struct FormFactorLaws {
    double least_row_sum = 0.0, largest_row_sum = 0.0;
    double reciprocity = 0.0;        ///< max |A_i F_ij - A_j F_ji| / min(A_i, A_j)
    double largest_error = 0.0;      ///< the largest estimated error of a factor
    std::size_t above_tolerance = 0; ///< factors whose estimated error is above the tolerance
};
FormFactorLaws check_laws(const FormFactors& F, double tolerance);

struct FormFactorOptions {
    double tolerance = 1e-6; ///< absolute, of each form factor between surfaces, both F_ij and F_ji
};

/// Throws UsageError if the tolerance is not positive and finite.
void check_tolerance(const FormFactorOptions& options);

/// The form factors between all surfaces. Each pair of triangles is computed once, so that reciprocity is exact to
/// rounding (PairExchange::of). The tolerance of a pair of surfaces is distributed over pairs of their triangles in
/// proportion to the products of areas.
///
/// The same bits for any number of threads. Journal and progress: phase "form factors".
/// Throws UsageError if the tolerance is not positive, ResourceError if there is too little memory for the factors
/// above 0, Interrupted if cancelled.
FormFactors form_factors(const Mesh& mesh, const Surfaces& surfaces, const FormFactorOptions& options,
                         const Execution& execution, FormFactorCounts* counts = nullptr);

} // namespace difusa
