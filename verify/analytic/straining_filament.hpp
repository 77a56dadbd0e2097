/// A thin elastic filament along the axis of compression of a straining flow without inertia: how fast it
/// buckles.
///
/// Slender body, drag per length xi across and xi/2 along the axis, w(s) in units of L and 1/rate, free ends:
///
///   w_t = w + s w' + 1/4 (s^2 - 1/4) w'' - w''''/eta,  eta = xi rate L^4/B                [becker-shelley-2001]
///
/// It holds to order 1/ln(L/a). A chain of markers in a periodic box needs no such thing: what a force on one
/// moves the others by is known exactly, and it is the same problem with matrices.
#pragma once

#include <Eigen/Core>

#include "analytic/line_mobility.hpp"

namespace veriflex::analytic {

/// Growth rates of the slender body over the rate of strain: of mode 1, 2, ... (2, 3, ... nodes on the
/// filament) from largest to smallest. The two rigid modes, which grow with 1 and 2, are not among them.
Eigen::VectorXd slender_growth(double eta);

/// 8 pi/c, c = -ln((a/L)^2 e): drag across a slender filament over viscosity and length.
double slender_drag(double radius_over_length);

/// A chain of these markers, a spacing apart, with bonds that keep their length, and angles.
struct StrainedChain {
  Mobility mobility;           // what a marker needs for itself, such as slip, added at distance 0
  double angle_stiffness;      // k_a  [M L^2 T^-2]
  Eigen::VectorXd stream;      // u_x of the undisturbed flow at the markers  [L T^-1]
  Eigen::VectorXd stretching;  // du_z/dz there  [T^-1]
};

/// What becomes of small displacements w along z of the markers: w_t = A w. The tension is that which holds
/// the bonds at their length.
Eigen::MatrixXd rate_of(const StrainedChain& chain);

/// A mode of such a matrix, of an odd number of markers.
struct ChainMode {
  double growth;          // [T^-1]
  Eigen::VectorXd shape;  // largest magnitude 1, its middle positive
  Eigen::VectorXd dual;   // dual.w is the part that a displacement w has of it; dual.shape = 1
};

/// Of the modes that are alike on both sides of the middle the straightest, with which the chain drifts off
/// the axis, and the next, by which it buckles. Throws NumericalFailure when they are not real: where they
/// grow alike.
struct EvenModes {
  ChainMode drift, buckling;
};
EvenModes even_modes(const Eigen::MatrixXd& rate);

}  // namespace veriflex::analytic
