/// Largest eigenvalues of a symmetric operator by Lanczos' method (Spectra), believed only with their
/// residuals.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace veriflex::solid {

/// A x of a symmetric A.
using SymmetricProduct = std::function<Eigen::VectorXd(const Eigen::VectorXd& x)>;

/// Of A, `size` rows and columns, which is not zero. Throws NumericalFailure, which names `what`, when the
/// iteration does not converge or its answer is no eigenvalue, and Stopped between two products.
double largest_eigenvalue(const SymmetricProduct& product, Eigen::Index size, double tolerance,
                          const char* what);

/// As above, the `count` eigenvalues of largest magnitude.
Eigen::VectorXd largest_eigenvalues(const SymmetricProduct& product, Eigen::Index size, int count,
                                    double tolerance, const char* what);

}  // namespace veriflex::solid
