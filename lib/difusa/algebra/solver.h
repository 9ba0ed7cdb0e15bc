// Plugin kind "solver": (I - K diag(rho)) h = H_direct by iteration.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/core/types.h>

#include <string>
#include <vector>

namespace difusa {

/// A linear operator as an action on the values at the sites.
class LinearOperator {
  public:
    virtual ~LinearOperator() = default;
    virtual std::size_t size() const = 0;

    /// y = K x, for each column (channel). x and y are different objects.
    virtual void apply(const Values& x, Values& y, const Execution& execution) const = 0;
};

/// The equation h = H_direct + K (rho ∘ h): K knows geometry only, rho and light are given apart (T 5.6).
struct SolveProblem {
    const LinearOperator* K = nullptr;
    Values rho;      ///< #S by #channels, reflectance at the sites
    Values H_direct; ///< #S by #channels, irradiance that arrives directly from light, W/m²
};

struct SolveOptions {
    double tolerance = 1e-6; ///< on max|H_direct + K(rho∘h) - h| / max|H_direct|, per channel
    int max_iterations = 1000;
};

/// What came out, and why it ended.
struct SolveSummary {
    enum class Reason { converged, max_iterations, diverged, stagnated };
    Reason reason = Reason::converged;
    int iterations = 0;                                ///< applications of K, the most of all channels
    std::vector<std::vector<double>> residual_history; ///< per channel: relative residual after 0, 1, ... iterations
    double residual = 0.0;                             ///< the last one, largest over the channels
    Values h;                                          ///< irradiance at the sites, W/m²

    bool converged() const { return reason == Reason::converged; }
    /// One sentence for a person.
    std::string sentence() const;
};

class Solver {
  public:
    virtual ~Solver() = default;
    virtual SolveSummary solve(const SolveProblem& problem, const SolveOptions& options,
                               const Execution& execution) const = 0;
};

/// max|H_direct + K(rho∘h) - h| / max|H_direct| for each channel (0 for a dark channel), and the residual itself.
std::vector<double> relative_residual(const SolveProblem& problem, const Values& h, Values& residual,
                                      const Execution& execution);

} // namespace difusa
