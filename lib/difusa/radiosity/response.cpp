#include <difusa/radiosity/response.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/radiosity/reflected_transport.h>

#include <algorithm>

namespace difusa {

namespace {

/// Tᵀ.
class Transposed final : public LinearOperator {
  public:
    explicit Transposed(const LinearOperator& T) : T_(T) {}
    std::size_t rows() const override { return T_.columns(); }
    std::size_t columns() const override { return T_.rows(); }
    Eigen::Index column_period() const override { return T_.column_period(); }
    std::size_t entry_count() const override { return T_.entry_count(); }
    void apply(const Values& x, Values& y, const Execution& execution) const override {
        T_.apply_transpose(x, y, execution);
    }
    void apply_transpose(const Values& x, Values& y, const Execution& execution) const override {
        T_.apply(x, y, execution);
    }

  private:
    const LinearOperator& T_;
};

/// `together`: about as many columns at a time.
Values solve_in_blocks(const Solver& solver, const LinearOperator& T, const Values& g, Eigen::Index channels,
                       Eigen::Index together, const SolveOptions& options, const Execution& execution) {
    DIFUSA_REQUIRE(g.rows() == static_cast<Eigen::Index>(T.rows()) && g.cols() % channels == 0);
    Values h(g.rows(), g.cols());
    const Eigen::Index block = std::max<Eigen::Index>(channels, together / channels * channels);
    for (Eigen::Index first = 0; first < g.cols(); first += block) {
        const Eigen::Index count = std::min(block, g.cols() - first);
        execution.check();
        const SolveSummary solved = solver.solve({&T, g.middleCols(first, count)}, options, execution.silent());
        if (!solved.converged()) {
            throw NotConverged("the solver " + solved.sentence() + " (wanted: " + text_of(options.tolerance) +
                               "): " + solved.remedy());
        }
        h.middleCols(first, count) = solved.h;
        if (execution.progress != nullptr) {
            execution.progress->advance(static_cast<double>(first + count) / static_cast<double>(g.cols()));
        }
    }
    return h;
}

} // namespace

Eigen::Index columns_at_once(const LightTransport& transport, bool transposed) {
    constexpr std::size_t most_numbers = std::size_t{1} << 27U; // 1 GiB
    // The vectors of a solver, and what is gathered, or the sums of several threads of a transposed product.
    const std::size_t of_each = 32 * transport.points() + (transposed ? 10 : 2) * transport.W->columns();
    return static_cast<Eigen::Index>(std::clamp<std::size_t>(most_numbers / of_each, 24, 192));
}

Values solve_for(const RadiositySystem& system, const Values& reflectance, const Values& g, const SolveOptions& options,
                 const Execution& execution) {
    const ReflectedTransport T(system.discretisation(), system.transport(), reflectance);
    return solve_in_blocks(*system.parts().solver, T, g, reflectance.cols(), columns_at_once(system.transport()),
                           options, execution);
}

Values solve_transpose_for(const RadiositySystem& system, const Values& reflectance, const Values& g,
                           const SolveOptions& options, const Execution& execution) {
    const Solver& solver = *system.parts().solver;
    if (solver.needs_factors()) {
        throw UsageError("the transposed equation needs a solver that multiplies by the whole operator: use --solver "
                         "krylov");
    }
    const ReflectedTransport T(system.discretisation(), system.transport(), reflectance);
    return solve_in_blocks(solver, Transposed(T), g, reflectance.cols(), columns_at_once(system.transport(), true),
                           options, execution);
}

} // namespace difusa
