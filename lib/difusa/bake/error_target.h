// Accuracy to order: what to change so that the estimated error of the next attempt is below a target.
//
// With goals the target is that of their means (radiosity/goal_estimate.h), which samples of the residual correct. More
// samples make the interval narrower; more sites make the residual smaller, in proportion to n^-3/8. As long as the
// samples cast fewer rays than the sites, samples alone are added. What they do not show is the product of the errors
// of field and adjoint: it is kept below the target by an rms error of the field of half the root of the target.
//
// Squares of errors add up: those of the basis, in proportion to n^-3/4 for n graded sites (bake/adaptive_sites.h), and
// those of the rays, in proportion to N^-1.5 for N rays of a lattice. What an attempt's estimate says of both, and a
// cost in proportion to n N, give the cheapest n and N for the target. Elements with evenly shared errors in
// proportion to their size would give n^-1; what attempts on the scenes in data/ report is between that and n^-0.8.
//
// The noise of shadow rays, which neither sites nor rays remove, falls as their number to the power -1.5 likewise:
// there are more of them where it is over a tenth of what the square of the error may be.
#pragma once

#include <difusa/bake/result.h>
#include <difusa/core/progress.h>

#include <functional>

namespace difusa {

/// Where to start: coarse enough to cost little beside what follows. `goals`: the number of goals; `shadow_rays`: as
/// many at first (BakeOptions::shadow_rays).
Effort first_effort(const ErrorTarget& target, std::size_t goals, std::size_t shadow_rays);

/// The error of the field of `result`, which has an estimate, and its parts; and of the estimated goals.
Attempt judged(const BakeResult& result, double seconds, const Execution& execution);

/// What has to be below the target: the upper end of the field's error; with goals, the half width of their intervals,
/// and four times the square of the field's error.
double error_of(const Attempt& attempt);

/// Rays cast by an attempt with this effort: from sites, and from samples of the goals.
double rays_of(const Effort& effort, std::size_t goals);

/// The next effort: more sites, more or fewer rays, at most eight times as many sites and four times as many rays, and
/// more shadow rays where their noise matters, at most 16 times as many. More error points alone if they are what is
/// missing: if the interval is wide, or if twice as many are predicted to bring the upper end below the target. With
/// goals, more samples of them, at most 16 times as many, and more sites and rays where the field has to be better.
Effort next_effort(const Attempt& attempt, const ErrorTarget& target, std::size_t goals);

/// Bakes with more and more effort until the error is below BakeOptions::target, starting from the scene in `result`,
/// which becomes the last attempt. `solve`: from the sites to the error estimate, for the sites and rays of the
/// attempt's options. Times and counts of all attempts go to the journal, notes and savings of the last only.
///
/// A target is out of reach if its next attempt would exceed one of its limits or the memory: NotConverged is thrown,
/// or for a first attempt that memory does not suffice for, ResourceError. If the best is wanted, a later attempt is
/// cut down to what there is time for, or to half of its growth (on a logarithmic scale) until memory suffices, unless
/// that is hardly more than the last. Then the result is the attempt with the smallest upper end,
/// BakeResult::target_missed is set, and a note says why.
void reach_target(BakeResult& result, const std::function<void(BakeResult& attempt, const Execution& own)>& solve,
                  const Execution& execution);

} // namespace difusa
