// Decompositions of small dense matrices, by Eigen. They are templates that take seconds each to compile: here once.
#pragma once

#include <Eigen/Core>

namespace difusa {

/// A^-1 b by elimination with partial pivoting, for square A; meaningless if A is singular.
Eigen::MatrixXd solve_dense(Eigen::MatrixXd A, const Eigen::MatrixXd& b);

struct Inverse {
    Eigen::MatrixXd matrix;
    double rcond = 0.0; ///< an estimate of the reciprocal condition in the norm of columns; 0: A is singular
};

/// A^-1 of square A, by the same elimination, in the memory of A.
Inverse dense_inverse(Eigen::MatrixXd A);

/// The x that minimises |A x - b| for each column of b, and among these the one of least norm, by a complete orthogonal
/// decomposition; #columns of A by #columns of b.
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& A, const Eigen::MatrixXd& b);

/// An orthonormal basis of the span of the columns, of which there are no more than rows, by Householder reflections.
Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& columns);

/// A = U diag(sigma) V^T with the singular values in descending order.
struct SingularValues {
    Eigen::MatrixXd U, V; ///< orthonormal columns, as many as singular values
    Eigen::VectorXd sigma;
};

/// By Jacobi rotations from both sides, which gets all singular values to working precision of the largest.
SingularValues singular_values(const Eigen::MatrixXd& A);

/// The largest modulus of an eigenvalue of square A, by the QR algorithm.
double largest_eigenvalue(const Eigen::MatrixXd& A);

} // namespace difusa
