/// Exact answers of elastic beams and bars, from elliptic integrals and series.
#pragma once

namespace veriflex::analytic {

/// Tip of a clamped, inextensible, unshearable beam under a dead load across its undeformed axis.
struct ElasticaTip {
  double deflection;  // along the load, over the length                          [1]
  double reach;       // along the undeformed axis from the clamp, over the length [1]
  double slope;       // angle against the undeformed axis                        [rad]
};

/// For load = P L^2/B from 0 to 200, to nine digits. [bisshopp-drucker-1945]
///   sqrt(load) = K(k) - F(k, theta),  sin theta = 1/(k sqrt 2),  2 k^2 = 1 + sin slope
ElasticaTip elastica_tip(double load);

/// Torsion constant of a square bar of unit side: 1/3 - 64/pi^5 sum over odd n of tanh(n pi/2)/n^5 =
/// 0.140577...                                                      [timoshenko-goodier-1970]
double torsion_constant_of_square();

}  // namespace veriflex::analytic
