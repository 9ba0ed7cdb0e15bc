#include <difusa/algebra/dense.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace difusa {

namespace {

using InPlaceLU = Eigen::PartialPivLU<Eigen::Ref<Eigen::MatrixXd>>;

} // namespace

Eigen::MatrixXd solve_dense(Eigen::MatrixXd A, const Eigen::MatrixXd& b) {
    return InPlaceLU(A).solve(b);
}

Inverse dense_inverse(Eigen::MatrixXd A) {
    const InPlaceLU lu(A);
    return {lu.inverse(), lu.rcond()};
}

Eigen::MatrixXd least_squares(const Eigen::MatrixXd& A, const Eigen::MatrixXd& b) {
    return Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(A).solve(b);
}

Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& columns) {
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns);
    return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), columns.cols());
}

SingularValues singular_values(const Eigen::MatrixXd& A) {
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeThinU | Eigen::ComputeThinV);
    return {svd.matrixU(), svd.matrixV(), svd.singularValues()};
}

double largest_eigenvalue(const Eigen::MatrixXd& A) {
    return Eigen::EigenSolver<Eigen::MatrixXd>(A, false).eigenvalues().cwiseAbs().maxCoeff();
}

} // namespace difusa
