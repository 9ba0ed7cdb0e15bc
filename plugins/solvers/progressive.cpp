// Solver `progressive`: progressive refinement by shooting (Cohen, Chen, Wallace and Greenberg 1988; L 49-52). The
// point with most unshot power shoots it at all others; what they receive is shown at once, and shot later. #points
// shots count as one iteration.
//   ambient     yes: what is shown on the way (--convergence) includes an estimate of the light still to come, which
//               vanishes as the unshot light does; the result never does. It takes the scene for closed, and is too
//               large in an open one
//   relaxation  share of the unshot light of a point that a shot takes, 1; above 1 it anticipates light to come (L 65)
//
// In the lectures a patch i shoots dB_i A_i; here a point shoots its unshot irradiance times what the surface reflects
// of an irradiance there: the integral of rho times its basis function. For constant patches both are the same. The
// "form factors on the fly" of a shooter are a column of T, formed from stored columns as in `southwell`. What a point
// sends to itself through its own basis function is shot in the same step: it is the geometric series that the division
// by 1 - T_ii sums.
#include <difusa/algebra/greedy_relaxation.h>
#include <difusa/plugin/plugin.h>

namespace {

class Progressive final : public difusa::GreedySolver {
  public:
    explicit Progressive(const difusa::Parameters& parameters)
        : GreedySolver({.solver = "progressive",
                        .relaxation = parameters.real("relaxation"),
                        .shooting = true,
                        .ambient = parameters.word("ambient") == "yes"}) {}
};

} // namespace

DIFUSA_PLUGIN(solver, "progressive", Progressive, "Shoots from the point with most unshot power (L 49-52).",
              {{"ambient",
                difusa::ParameterSpec::Type::word,
                "yes",
                "whether estimates on the way include the light still to come",
                0,
                0,
                {"yes", "no"}},
               {"relaxation",
                difusa::ParameterSpec::Type::real,
                "1",
                "share of the unshot light that a shot takes",
                0.05,
                1.95,
                {}}})
