#include <difusa/radiosity/reflected_transport.h>

#include <difusa/algebra/vector_blocks.h>

namespace difusa {

void ReflectedTransport::reflect(Values& b, const Execution& execution) const {
    const Eigen::Index channels = reflectance_.cols();
    for_blocks(b.rows(), execution, [&](Eigen::Index first, Eigen::Index count, Eigen::Index) {
        for (Eigen::Index s = first; s < first + count; ++s) {
            for (Eigen::Index c = 0; c < b.cols(); ++c) {
                b(s, c) *= reflectance_(s, c % channels);
            }
        }
    });
}

void ReflectedTransport::apply(const Values& h, Values& y, const Execution& execution) const {
    const Projection& projection = *discretisation_.projection;
    Values b;
    discretisation_.averages->apply(projection.is_identity() ? h : projection.coefficients(h, execution), b, execution);
    reflect(b, execution);
    transport_.gather(b, {}, y, execution);
}

void ReflectedTransport::apply_transpose(const Values& x, Values& y, const Execution& execution) const {
    Values at_bins;
    transport_.W->apply_transpose(x, at_bins, execution);
    Values b = at_bins.topRows(static_cast<Eigen::Index>(transport_.surfels));
    reflect(b, execution);
    Values coefficients;
    discretisation_.averages->apply_transpose(b, coefficients, execution);
    y = discretisation_.projection->transposed(coefficients);
}

} // namespace difusa
