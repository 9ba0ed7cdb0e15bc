#include <difusa/discretisation/evaluate.h>

#include <difusa/core/parallel.h>

namespace difusa {

namespace {

/// `weigh(p, row)` writes the weights of the coefficients at point p.
template <class Weigh>
Values weighted_sums(const Weigh& weigh, const Values& coefficients, std::size_t points, const Execution& execution) {
    Values f = Values::Zero(static_cast<Eigen::Index>(points), coefficients.cols());
    parallel_for(points, 1024, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        BasisRow row;
        for (std::size_t p = begin; p < end; ++p) {
            weigh(p, row);
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
    return weighted_sums([&](std::size_t p, BasisRow& row) { basis.evaluate(points[p], row); }, coefficients,
                         points.size(), execution);
}

Values evaluate_display(const Basis& basis, const Values& coefficients, std::span<const SurfacePoint> points,
                        const Execution& execution, const RowVisitor& visit) {
    const bool differs = basis.displays_otherwise();
    const auto weigh = [&](std::size_t p, BasisRow& row) {
        if (visit) {
            basis.evaluate(points[p], row);
            visit(p, row);
        }
        if (differs || !visit) {
            basis.display(points[p], row);
        }
    };
    return weighted_sums(weigh, coefficients, points.size(), execution);
}

} // namespace difusa
