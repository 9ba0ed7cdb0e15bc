// Least squares with unknowns that are not negative.
#pragma once

#include <Eigen/Core>

namespace difusa {

/// The x >= 0 with the least |A x - b|, by the active sets of C. Lawson and R. Hanson ("Solving least squares
/// problems", 1974, chapter 23). Of several, one. Throws NotConverged after 30 exchanges for each unknown, which only
/// rounding can cause.
Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

} // namespace difusa
