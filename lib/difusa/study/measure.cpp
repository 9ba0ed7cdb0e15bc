#include <difusa/study/measure.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/mesh/surface_sampling.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>

namespace difusa {

namespace {

/// Wall time of the phases that produce the field.
double making(const BakeResult& result) {
    double sum = 0.0;
    for (const auto& [phase, seconds] : result.journal.seconds()) {
        sum += phase == "estimate error" || phase == "refine output" || phase == "evaluate" ? 0.0 : seconds;
    }
    return sum;
}

} // namespace

Judge::Judge(ReferenceCase the_case, const MeasureOptions& how, const Execution& execution)
    : reference(std::move(the_case)) {
    if (how.places < 1) {
        throw UsageError("--places: must be at least 1");
    }
    // If only part of the surface is assessed, points are drawn until enough are in it.
    for (std::size_t drawn = how.places; places.size() < how.places; drawn *= 2) {
        places.clear();
        for (SurfacePoint x : even_points(reference.scene.mesh, drawn, RandomStream(how.seed, "places"))) {
            if (!reference.judged || reference.judged(x.position)) {
                x.normal = reference.normal ? reference.normal(x) : x.normal;
                places.push_back(x);
            }
        }
    }
    std::vector<ReferenceLight> light(places.size());
    parallel_for(places.size(), 64, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            light[i] = reference.exact->at(places[i].position, places[i].normal);
        }
    });
    for (const ReferenceLight& at : light) {
        rho.push_back(at.rho);
        H.push_back(at.H);
        if (at.H_direct) {
            H_direct.push_back(*at.H_direct);
        }
    }
}

Measurement measure(const Registry& registry, const Judge& judge, const BakeOptions& options, const MeasureOptions& how,
                    const Execution& execution, const std::function<void(const BakeResult&)>& look) {
    const ReferenceCase& reference = judge.reference;
    const std::vector<SurfacePoint>& places = judge.places;
    Measurement m;
    m.case_name = reference.name;
    m.options = options;
    BakeOptions bake_options = options;
    bake_options.final_gather = 0; // at the judge's points instead of the output's vertices
    bake_options.output_spacing = reference.scene.mesh.diameter();
    std::unique_ptr<BakeResult> result;
    m.seconds = std::numeric_limits<double>::infinity();
    try {
        for (int run = 0; run < std::max(1, how.repeats); ++run) {
            result =
                std::make_unique<BakeResult>(bake(registry, reference.scene, reference.name, bake_options, execution));
            m.seconds = std::min(m.seconds, making(*result));
        }
    } catch (const NotConverged& error) {
        m.failed = true;
        m.failure = error.what();
        return m;
    } catch (const ResourceError& error) {
        m.failed = true;
        m.failure = error.what();
        return m;
    }
    m.options = result->options;
    m.options.final_gather = options.final_gather;
    m.sites = result->sites->size();
    m.rays = result->journal.count_of("rays");
    m.segments = result->journal.count_of("segments");
    m.iterations = result->solution.solve.iterations;

    const auto begin = std::chrono::steady_clock::now();
    const PointValues values = result->field().at(places, options.final_gather, options.seed, "judged", execution);
    const double noise = std::sqrt(values.noise.squaredNorm() / static_cast<double>(places.size()));
    m.seconds_output = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::vector<double> B, exact_B, indirect, exact_indirect;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        const double E = reference.scene.emission(places[i])[0];
        B.push_back(E + judge.rho[i] * values.H(row, 0));
        exact_B.push_back(E + judge.rho[i] * judge.H[i]);
        if (judge.H_direct.size() == places.size()) {
            indirect.push_back(judge.rho[i] * values.H_indirect(row, 0));
            exact_indirect.push_back(judge.rho[i] * (judge.H[i] - judge.H_direct[i]));
        }
    }
    m.total = error_norms(B, exact_B, std::vector<double>(B.size(), 1.0));
    m.indirect = error_norms(indirect, exact_indirect, std::vector<double>(indirect.size(), 1.0));
    if (result->error) {
        ErrorEstimate& error = *result->error;
        if (options.final_gather > 0) {
            judge_gathered(error, noise);
        }
        m.bound = error.bound;
        m.estimate = error.total;
    }
    if (look) {
        look(*result);
    }
    return m;
}

} // namespace difusa
