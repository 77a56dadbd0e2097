#include "analytic/lattice_wave.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace veriflex::analytic {

namespace {

using fluid::Q;
using Matrix = Eigen::Matrix<Complex, Q, Q>;
using Space = Eigen::Matrix<Complex, Q, Eigen::Dynamic>;

// Eigenvalues nearer than this are the same: rounding separates equal ones by some 1e-15, and what the
// lattice's anisotropy separates at wave lengths up to a hundred nodes is more than 1e-9.
constexpr double same = 1e-11;

Vec3 velocity(int q) {
  const auto& v = fluid::c[static_cast<std::size_t>(q)];
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

// Derivative of f_eq(rho, j)_q by the density and by the momentum, at density 1 and momentum U.
double by_density(int q, const Vec3& U) {
  const double along = velocity(q).dot(U);
  return fluid::w(q) * (1.0 - 4.5 * along * along + 1.5 * U.squaredNorm());
}

Vec3 by_momentum(int q, const Vec3& U) {
  return fluid::w(q) * ((3.0 + 9.0 * velocity(q).dot(U)) * velocity(q) - 3.0 * U);
}

Space eigenvectors(const Eigen::ComplexEigenSolver<Matrix>& solved, Complex value) {
  Space found(Q, 0);
  for (int i = 0; i < Q; ++i) {
    if (std::abs(solved.eigenvalues()[i] - value) > same) continue;
    found.conservativeResize(Eigen::NoChange, found.cols() + 1);
    found.col(found.cols() - 1) = solved.eigenvectors().col(i);
  }
  return found;
}

}  // namespace

Matrix one_step(const Vec3& k, double relaxation_time, const Vec3& stream) {
  const double omega = 1.0 / relaxation_time;
  Matrix step;
  for (int q = 0; q < Q; ++q) {
    const Complex travelled = std::polar(1.0, -k.dot(velocity(q)));
    for (int p = 0; p < Q; ++p) {
      const double relaxed = by_density(q, stream) + by_momentum(q, stream).dot(velocity(p));
      step(q, p) = travelled * ((p == q ? 1.0 - omega : 0.0) + omega * relaxed);
    }
  }
  return step;
}

LatticeWave lattice_wave(const Vec3& k, double relaxation_time, const ContinuumWave& like,
                         const Vec3& stream) {
  const Matrix step = one_step(k, relaxation_time, stream);
  const Eigen::ComplexEigenSolver<Matrix> right(step);
  const Eigen::ComplexEigenSolver<Matrix> left(step.transpose());
  ComplexPopulations wanted;
  for (int q = 0; q < Q; ++q)
    wanted[q] = by_density(q, stream) * like.density + by_momentum(q, stream).dot(like.momentum);

  LatticeWave wave{0.0, ComplexPopulations::Zero(), ComplexPopulations::Zero()};
  for (int i = 0; i < Q; ++i) {
    const Space shapes = eigenvectors(right, right.eigenvalues()[i]);
    const Space projections = eigenvectors(left, right.eigenvalues()[i]);
    // Where a kinetic eigenvalue lacks eigenvectors, rounding splits it in two different ways.
    if (shapes.cols() != projections.cols()) continue;
    const Eigen::MatrixXcd dual = (projections.transpose() * shapes).inverse() * projections.transpose();
    const Eigen::VectorXcd share = dual * wanted;
    const ComplexPopulations part = shapes * share;
    if (!(part.norm() > wave.shape.norm())) continue;
    wave = {right.eigenvalues()[i], part, dual.transpose() * share.conjugate() / share.squaredNorm()};
  }
  return wave;
}

}  // namespace veriflex::analytic
