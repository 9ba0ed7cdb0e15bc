#include <difusa/radiosity/light_responses.h>

#include <difusa/core/parallel.h>
#include <difusa/radiosity/response.h>

namespace difusa {

LightResponses::LightResponses(const RadiositySystem& system, const Values& reflectance, const Values& g,
                               const SolveOptions& options, const Execution& execution)
    : channels_(reflectance.cols()), h_(solve_for(system, reflectance, g, options, execution)) {}

Values LightResponses::mixed(const Values& factors, const Execution& execution) const {
    const Eigen::Index count = h_.cols() / channels_;
    DIFUSA_REQUIRE(factors.rows() == count && (factors.cols() == 1 || factors.cols() == channels_));
    const Values factor = factors.cols() == channels_ ? factors : Values(factors.replicate(1, channels_));
    Values h(h_.rows(), channels_);
    parallel_for(static_cast<std::size_t>(h_.rows()), 4096, execution.silent(),
                 [&](std::size_t begin, std::size_t end, unsigned) {
                     for (auto j = static_cast<Eigen::Index>(begin); j < static_cast<Eigen::Index>(end); ++j) {
                         for (Eigen::Index c = 0; c < channels_; ++c) {
                             double sum = 0.0;
                             for (Eigen::Index l = 0; l < count; ++l) {
                                 sum += factor(l, c) * h_(j, l * channels_ + c);
                             }
                             h(j, c) = sum;
                         }
                     }
                 });
    return h;
}

} // namespace difusa
