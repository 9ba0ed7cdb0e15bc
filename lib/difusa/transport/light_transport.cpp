#include <difusa/transport/light_transport.h>

#include <difusa/algebra/vector_blocks.h>
#include <difusa/core/error.h>

namespace difusa {

Values LightTransport::on_bins(const Values& b, const Values& sky_radiosity, const Execution& execution) const {
    const auto surfel_rows = static_cast<Eigen::Index>(surfels), all = static_cast<Eigen::Index>(W->columns());
    DIFUSA_REQUIRE(b.rows() == surfel_rows && (sky_radiosity.rows() == 0 || sky_radiosity.rows() == all - surfel_rows));
    Values x(all, b.cols());
    for_blocks(surfel_rows, execution, [&](Eigen::Index first, Eigen::Index count, Eigen::Index) {
        x.middleRows(first, count) = b.middleRows(first, count);
    });
    if (sky_radiosity.rows() > 0) {
        x.bottomRows(all - surfel_rows) = sky_radiosity;
    } else {
        x.bottomRows(all - surfel_rows).setZero();
    }
    return x;
}

void LightTransport::gather(const Values& b, const Values& sky_radiosity, Values& h, const Execution& execution) const {
    W->apply(on_bins(b, sky_radiosity, execution), h, execution);
}

double LightTransport::largest_row_sum(const Execution& execution) const {
    Values sums;
    gather(Values::Ones(static_cast<Eigen::Index>(surfels), 1), {}, sums, execution);
    return sums.maxCoeff();
}

} // namespace difusa
