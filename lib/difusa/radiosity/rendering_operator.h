// The rendering operator (I - T)^-1 of a surface (T 5.3): all reflections as one product, for those who light a surface
// again and again.
#pragma once

#include <difusa/radiosity/low_rank_light.h>
#include <difusa/radiosity/system.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

/// How (I - T)^-1 g is formed.
struct OperatorChoice {
    enum class Kind {
        neumann, ///< g + T g + ... + T^bounces g
        dense,   ///< a matrix, #points by #points, by LU decomposition
        low_rank ///< g + T g + ... + T^bounces g, and of the later reflections an approximation of low rank
    };
    Kind kind = Kind::neumann;
    int bounces = 8;
    LowRankOptions low_rank; ///< `bounces` and `solve` are not used
    std::string text;        ///< the choice with all parameters
};

/// "neumann:bounces=8", "dense", "low-rank:rank=64,bounces=1,more=16". Throws UsageError.
OperatorChoice parse_operator(std::string_view text);

class RenderingOperator {
  public:
    /// `reflectance`: #surfels by #channels; equal channels are computed once. `radius`: the spectral radius of T
    /// (Solution::spectral_radius). Throws ResourceError if memory does not suffice, UsageError for a rank that cannot
    /// be, and NotConverged.
    RenderingOperator(std::shared_ptr<const RadiositySystem> system, const Values& reflectance,
                      const OperatorChoice& choice, double radius, const SolveOptions& solve,
                      const Execution& execution);

    /// h near (I - T)^-1 g. `g`: #points by any number of columns, of which column c belongs to channel c modulo
    /// #channels, W/m². Bit-identical for any number of threads.
    Values apply(const Values& g, const Execution& execution) const { return applied(g, nullptr, execution); }

    /// The same, and for each column the error of h, rms over the area (AreaNorms), W/m²:
    /// - neumann: radius / (1 - radius) times the rms of the last term, a bound if T is self-adjoint in this norm, and
    ///   an estimate otherwise, which it is by the noise of the rays and the basis;
    /// - dense: the rms of h by the condition of I - T in the 1-norm and the precision of numbers, an estimate;
    /// - low rank: LowRankLight::error times the rms of the radiosity rho P Π g that g makes by one reflection: an
    /// upper
    ///   bound, except with probability `low_rank_risk`.
    Values apply(const Values& g, std::vector<double>& error, const Execution& execution) const {
        return applied(g, &error, execution);
    }

    std::size_t bytes() const; ///< of the matrices

  private:
    /// Of one channel, or of all if they are the same.
    struct Part {
        Values M;    ///< (I - T)^-1, if dense
        Values U, V; ///< #points by rank: the later reflections are U Vᵀ g
        double error = 0.0;
    };
    Values applied(const Values& g, std::vector<double>* error, const Execution& execution) const;
    void make_dense(const Execution& execution);
    void make_low_rank(const OperatorChoice& choice, const SolveOptions& solve, const Execution& execution);
    void add_products(const Values& g, Values& h, const Execution& execution) const;

    std::shared_ptr<const RadiositySystem> system_;
    OperatorChoice choice_;
    double radius_;
    Eigen::Index channels_; ///< of the operands
    Values reflectance_;    ///< #surfels by 1 if all channels are the same
    std::vector<Part> parts_;
};

} // namespace difusa
