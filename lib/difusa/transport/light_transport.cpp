#include <difusa/transport/light_transport.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>

namespace difusa {

void LightTransport::gather(const Values& b, const Values& sky_radiosity, Values& h, const Execution& execution) const {
    const auto surfel_rows = static_cast<Eigen::Index>(surfels), all = static_cast<Eigen::Index>(W->columns());
    DIFUSA_REQUIRE(b.rows() == surfel_rows && (sky_radiosity.rows() == 0 || sky_radiosity.rows() == all - surfel_rows));
    Values x(all, b.cols());
    parallel_for(surfels, 16384, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        const auto first = static_cast<Eigen::Index>(begin), count = static_cast<Eigen::Index>(end - begin);
        x.middleRows(first, count) = b.middleRows(first, count);
    });
    if (sky_radiosity.rows() > 0) {
        x.bottomRows(all - surfel_rows) = sky_radiosity;
    } else {
        x.bottomRows(all - surfel_rows).setZero();
    }
    W->apply(x, h, execution);
}

double LightTransport::largest_row_sum(const Execution& execution) const {
    Values sums;
    gather(Values::Ones(static_cast<Eigen::Index>(surfels), 1), {}, sums, execution);
    return sums.maxCoeff();
}

} // namespace difusa
