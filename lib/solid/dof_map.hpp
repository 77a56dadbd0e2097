/// The free coordinates of a network, and factorisation of a Hessian over them that refuses zero and negative
/// modes.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

#include "solid/statics.hpp"

namespace veriflex::solid {

/// Numbers the coordinates that are not fixed, in the order of storage.
struct DofMap {
  Eigen::VectorXi number;  // of each coordinate; -1 where fixed
  int count = 0;

  explicit DofMap(const FixedDofs& held);
  Eigen::VectorXd gather(const Positions& all) const;
  Positions scatter(const Eigen::VectorXd& free, double scale) const;  // zero where fixed
  Eigen::SparseMatrix<double> restrict(const std::vector<Eigen::Triplet<double>>& entries) const;
};

using Cholesky = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>;

/// Factorises h (its pattern analysed before). Throws NumericalFailure "mechanism: N zero modes" or
/// "unstable: N negative", or of an h that is not finite, with the Newton step in which it happened.
void factorize_stable(Cholesky& factor, const Eigen::SparseMatrix<double>& h, int newton_step);

/// How many eigenvalues of h lie below `shift`, by Sylvester's law of inertia. Throws NumericalFailure where
/// one lies on it.
Eigen::Index eigenvalues_below(const Eigen::SparseMatrix<double>& h, double shift);

/// Memory of the matrix and of the factor  [bytes].
double bytes_of(const Eigen::SparseMatrix<double>& h);
double bytes_of(const Cholesky& factor);

/// Largest absolute row sum.
double infinity_norm(const Eigen::SparseMatrix<double>& h);

}  // namespace veriflex::solid
