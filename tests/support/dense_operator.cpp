#include <support/dense_operator.h>

#include <difusa/algebra/factors.h>

namespace difusa::test {

std::shared_ptr<const Factors> DenseOperator::factors(const Execution& /*execution*/) const {
    const auto n = static_cast<std::size_t>(K_.rows());
    const auto A = std::make_shared<SparseRows>(n, n);
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < n; ++j) {
            if (const double entry = K_(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)); entry != 0.0) {
                A->row(i).column.push_back(static_cast<Index>(j));
                A->row(i).value.push_back(entry);
            }
        }
    }
    auto factors = std::make_shared<Factors>();
    factors->A = A;
    factors->middle = n;
    for (std::size_t i = 0; i <= n; ++i) {
        factors->Q.first.push_back(i);
    }
    for (std::size_t i = 0; i < n; ++i) {
        factors->Q.row.push_back(static_cast<Index>(i));
    }
    factors->Q.value = rho_;
    factors->power = rho_;
    factors->area = static_cast<double>(n);
    return factors;
}

Eigen::MatrixXd random_nonnegative(Eigen::Index n, double density, RandomStream& random) {
    Eigen::MatrixXd K(n, n);
    for (double& entry : K.reshaped()) {
        entry = random.uniform() < density ? random.uniform() : 0.0;
    }
    return K;
}

} // namespace difusa::test
