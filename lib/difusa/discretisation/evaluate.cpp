#include <difusa/discretisation/evaluate.h>

#include <difusa/core/parallel.h>

namespace difusa {

namespace {

/// `weigh(x, row)` writes the weights of the coefficients at x.
template <class Weigh>
Values weighted_sums(const Weigh& weigh, const Values& coefficients, std::span<const SurfacePoint> points,
                     const Execution& execution) {
    Values f = Values::Zero(static_cast<Eigen::Index>(points.size()), coefficients.cols());
    parallel_for(points.size(), 1024, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        BasisRow row;
        for (std::size_t p = begin; p < end; ++p) {
            weigh(points[p], row);
            auto value = f.row(static_cast<Eigen::Index>(p));
            for (std::size_t i = 0; i < row.element.size(); ++i) {
                value += row.weight[i] * coefficients.row(static_cast<Eigen::Index>(row.element[i]));
            }
        }
    });
    return f;
}

} // namespace

Values evaluate(const Basis& basis, const Values& coefficients, std::span<const SurfacePoint> points,
                const Execution& execution) {
    return weighted_sums([&](const SurfacePoint& x, BasisRow& row) { basis.evaluate(x, row); }, coefficients, points,
                         execution);
}

Values evaluate_display(const Basis& basis, const Values& coefficients, std::span<const SurfacePoint> points,
                        const Execution& execution) {
    return weighted_sums([&](const SurfacePoint& x, BasisRow& row) { basis.display(x, row); }, coefficients, points,
                         execution);
}

} // namespace difusa
