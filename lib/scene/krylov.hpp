/// An orthonormal basis of a Krylov space, and the operator in it.
#pragma once

#include <Eigen/Core>

namespace veriflex::scene {

struct Krylov {
  Eigen::MatrixXd basis;      // a column for each dimension that was found
  Eigen::MatrixXd projected;  // basis^T A basis, upper Hessenberg; of a symmetric A tridiagonal
};

/// Of that many dimensions, fewer where the products of A with the start span no more.
template <class Product>
Krylov krylov(const Product& product, const Eigen::VectorXd& start, Eigen::Index dimensions) {
  Eigen::MatrixXd basis(start.size(), dimensions);
  Eigen::MatrixXd projected = Eigen::MatrixXd::Zero(dimensions, dimensions);
  basis.col(0) = start.normalized();
  Eigen::Index size = 0;
  while (size < dimensions) {
    Eigen::VectorXd image = product(basis.col(size));
    const double length = image.norm();
    for (int twice = 0; twice < 2; ++twice) {
      const Eigen::VectorXd along = basis.leftCols(size + 1).transpose() * image;
      projected.col(size).head(size + 1) += along;
      image -= basis.leftCols(size + 1) * along;
    }
    ++size;
    if (size == dimensions || !(image.norm() > 1e-10 * length)) break;  // all of the space, or none left
    projected(size, size - 1) = image.norm();
    basis.col(size) = image.normalized();
  }
  return {basis.leftCols(size), projected.topLeftCorner(size, size)};
}

}  // namespace veriflex::scene
