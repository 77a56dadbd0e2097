/// Small oscillations of a network about a state: its largest frequency and its lowest modes, by Spectra.
#pragma once

#include <Eigen/SparseCore>

#include "solid/elastic.hpp"
#include "solid/statics.hpp"

namespace veriflex::solid {

/// The Hessian of the energy at u over the free coordinates, numbered in the order of u's storage  [M T^-2].
/// Throws NumericalFailure where the energy does not exist.
Eigen::SparseMatrix<double> free_hessian(const Material& material, const Network& network, const Positions& u,
                                         const FixedDofs& held);

/// omega_max: the largest angular frequency about u with equal node masses  [T^-1]. Leap-frog with a step
/// beyond 2/omega_max is unstable. Relative error below 1e-10. Throws NumericalFailure when the iteration
/// does not converge.
double largest_frequency(const Material& material, const Network& network, const Positions& u,
                         const FixedDofs& held, double node_mass);

/// The `count` smallest angular frequencies about u, rising; a mode without stiffness has frequency 0, one of
/// negative stiffness the negative of its growth rate  [T^-1]. As above.
Eigen::VectorXd lowest_frequencies(const Material& material, const Network& network, const Positions& u,
                                   const FixedDofs& held, double node_mass, int count);

/// The displacement that small dead loads cause from rest: the linear response, without any error of finite
/// displacement. Throws NumericalFailure for a mechanism or an unstable state, as equilibrium() does.
Positions linear_response(const Material& material, const Network& network, const FixedDofs& held,
                          const Positions& load);

}  // namespace veriflex::solid
