#include <support/dense_operator.h>

#include <Eigen/Eigenvalues> // takes long to compile: here once

namespace difusa::test {

Eigen::MatrixXd random_nonnegative(Eigen::Index n, double density, RandomStream& random) {
    Eigen::MatrixXd K(n, n);
    for (double& entry : K.reshaped()) {
        entry = random.uniform() < density ? random.uniform() : 0.0;
    }
    return K;
}

double exact_spectral_radius(const Eigen::MatrixXd& K) {
    return Eigen::EigenSolver<Eigen::MatrixXd>(K, false).eigenvalues().cwiseAbs().maxCoeff();
}

} // namespace difusa::test
