/// Static equilibrium by one of several methods, so that what they cost can be compared.
#pragma once

#include <array>

#include "base/named.hpp"
#include "solid/statics.hpp"

namespace veriflex::solid {

enum class Relaxation { Newton, ConjugateGradients, DampedDynamics };

/// In the order of Relaxation.
inline constexpr std::array relaxations{
    Named<Relaxation>{Relaxation::Newton, "newton", "newton", "Newton's method, sparse Cholesky"},
    Named<Relaxation>{Relaxation::ConjugateGradients, "conjugate-gradients", "conjugate_gradients",
                      "Newton's method, conjugate gradients for its equations"},
    Named<Relaxation>{Relaxation::DampedDynamics, "damped-dynamics", "damped_dynamics",
                      "leap-frog that stops whenever the kinetic energy has passed a peak"},
};

struct Statics {
  Relaxation method = Relaxation::Newton;
  double residual = 1e-12;  // see Equilibrium; where the search ends  [1]
};

/// As equilibrium(), by any method. Damped dynamics knows no Hessian: steps of 0.9 times the linear limit at
/// the start, and velocities that are set to zero after each peak of the kinetic energy  [cundall-1976]; its
/// `iterations` are evaluations of the forces, and it tells neither a mechanism nor a saddle from a minimum.
/// Throws NumericalFailure when it does not reach the residual in 400 of them for each free coordinate and
/// 20000 more.
Equilibrium relax(const Statics& how, const Material& material, const Network& network, const Positions& u,
                  const FixedDofs& held, const Positions& load);

}  // namespace veriflex::solid
