// Solver `southwell` (Southwell 1946; L 63, 70): relaxes the unknown with the largest residual, whichever that is, and
// then the one that has the largest residual now. Starts with h = g. #points relaxations count as one iteration.
//   relaxation  share of the residual of an unknown that a step removes, 1 (L 65)
//
// A step needs a column of T = D diag(rho) P Π, which is not stored: that would take n² entries for each channel. It is
// the sum of the columns of D that belong to the surfels around the unknown, and is formed anew for each step; for
// this, D is stored by columns, too (12 bytes a ray; refused beforehand if memory does not suffice). A projection that
// solves a system has no such columns, and is refused. Which unknown is next depends on the channel, so each channel
// and set of lights is relaxed by itself; they run in parallel.
#include <difusa/algebra/greedy_relaxation.h>
#include <difusa/plugin/plugin.h>

namespace {

class Southwell final : public difusa::GreedySolver {
  public:
    explicit Southwell(const difusa::Parameters& parameters)
        : GreedySolver({.solver = "southwell", .relaxation = parameters.real("relaxation")}) {}
};

} // namespace

DIFUSA_PLUGIN(
    solver, "southwell", Southwell, "Relaxes the largest residual, one unknown after the other (L 63).",
    {{"relaxation", difusa::ParameterSpec::Type::real, "1", "share of a residual that is removed", 0.05, 1.95, {}}})
