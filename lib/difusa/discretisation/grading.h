// Graded sites: where values at given sites say that more of them would help.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/core/types.h>
#include <difusa/discretisation/basis.h>
#include <difusa/discretisation/site_set.h>
#include <difusa/discretisation/size_field.h>

#include <vector>

namespace difusa {

/// The leave-one-out residuals of values at the sites: f_i minus what the basis makes of the other sites' values at
/// p_i, (f_i - sum_j phi_j(p_i) f_j) / (1 - phi_i(p_i)), which is exact for bases that are local least-squares fits
/// (Stone 1974), such as moving least squares and weighted means. #S by #columns; f_i itself where the others
/// hardly count. `values`: #S or more rows, the first of which are those of the sites.
Values leave_one_out(const Basis& basis, const SiteSet& sites, const Values& values, const Execution& execution);

/// How much smaller the squared error of graded sites is at best than that of as many even ones, from errors (#S, not
/// negative) at evenly spaced sites: the mean of their squares over the square of their mean, which is 1 where all are
/// equal, and pi/2 for normally distributed noise alone. It is 1 if there is no error.
double gain_of_grading(const std::vector<double>& error);

/// The spacing to place about `wanted` sites at, where `error` (#S, not negative) is the size of the error around each
/// of `sites`, which are `own` apart (#S). The squared error over the area is least for the number of sites if each
/// element has the same share of it: with errors in proportion to the spacing, the new one is in proportion to the root
/// of own_i / error_i. It is at most `largest`, and at least a quarter of what it is now.
SizeField graded_spacing(const SiteSet& sites, const std::vector<double>& own, const std::vector<double>& error,
                         double largest, double wanted, Index region_count, const Execution& execution);

} // namespace difusa
