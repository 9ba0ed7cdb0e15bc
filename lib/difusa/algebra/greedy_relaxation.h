// Relaxation of the unknown that matters most, one after the other: Southwell's method, and progressive refinement by
// shooting, which is the same method with another start, another measure and another display (Gortler, Cohen and
// Slusallek 1993).
#pragma once

#include <difusa/algebra/factors.h>
#include <difusa/algebra/solver.h>

namespace difusa {

struct GreedyRule {
    const char* solver = ""; ///< its name, for messages
    double relaxation = 1.0; ///< omega: the share of an unknown's residual that a step removes

    /// False (Southwell 1946): starts with h = g, and relaxes the largest residual r = g + T h - h.
    ///
    /// True (Cohen, Chen, Wallace and Greenberg 1988): starts with nothing shot, x = 0, and all light unshot, r = g;
    /// relaxes the unknown with most unshot power, |r_i| times what the surface reflects of an irradiance at i. The
    /// result is what has arrived, h = x + r = g + T x, whether it was shot on or not.
    bool shooting = false;

    /// Of shooting: what is displayed on the way includes the light that will still arrive, estimated as if all of the
    /// surface saw all of the surface:
    ///     h + (1 / (1 - rho)) sum_i p_i r_i / A,   rho = sum_i p_i / A,
    /// where p are Factors::power, so that rho is the mean reflectance over the area A. Vanishes with r.
    bool ambient = false;
};

/// A step that relaxes unknown i: with delta = omega r_i / (1 - T_ii),
///     x_i += delta,   r += T_.i delta,   r_i -= delta.
/// The columns of T are formed as they are needed, from those of its factors. Each column of g is relaxed in an order
/// of its own, as if it were alone; columns are shared between threads, and the bits do not depend on how many there
/// are. #points steps are one iteration. Stops as soon as the largest residual is below the tolerance, which the
/// residual computed afresh must confirm; with StopBy::change, after an iteration that changed h by less.
SolveSummary relax_greedily(const SolveProblem& problem, const SolveOptions& options, const GreedyRule& rule,
                            const Execution& execution);

/// A solver that relaxes by such a rule.
class GreedySolver : public Solver {
  public:
    explicit GreedySolver(const GreedyRule& rule) : rule_(rule) {}

    bool needs_factors() const override { return true; }
    bool needs_columns() const override { return true; }

    SolveSummary solve(const SolveProblem& problem, const SolveOptions& options,
                       const Execution& execution) const override {
        return relax_greedily(problem, options, rule_, execution);
    }

  private:
    GreedyRule rule_;
};

} // namespace difusa
