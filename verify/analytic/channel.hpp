/// Exact solutions of flows between walls and through arrays of obstacles, in the continuum, and the one that
/// the lattice itself has between plates.
#pragma once

#include <complex>

namespace veriflex::analytic {

/// Steady flow along plates at y = 0 and y = height under a force g: y (height - y)/2, per g/nu  [L^2].
double plane_poiseuille(double y, double height);

/// What D3Q15 BGK with half-way bounce-back adds to that parabola everywhere, per g, in the velocity
/// sum f c + g/2: (16 (tau - 1/2)^2 - 3)/(24 nu) with nu = (tau - 1/2)/3  [T]. It vanishes, and the wall then
/// sits half-way, at tau = 1/2 + sqrt(3)/4 only.                                             [he-1997]
double half_way_slip(double relaxation_time);

/// Steady flow along a duct 0 < y, z < width, per g/nu  [L^2]: cosine-hyperbolic series over odd n.
///                                                                              [white-2006]
double square_duct(double y, double z, double width);

/// Flow along plates at y = 0 and y = height under the force Re exp(i omega t): complex amplitude of the
/// velocity, (1 - cosh(k (y - height/2))/cosh(k height/2))/(i omega) with k = sqrt(i omega/nu)  [T].
///                                                                            [womersley-1955, plane form]
std::complex<double> oscillating_poiseuille(double y, double height, double omega, double viscosity);

/// Drag F/(mu U) per length of each cylinder of a square array with this solid fraction, U the mean velocity
/// over the whole cell; within 0.1 % up to 0.1.                                     [sangani-acrivos-1982]
double cylinder_array_drag(double solid_fraction);

/// Drag F/(6 pi mu a U) of each sphere of a simple cubic array with this solid fraction, U the mean velocity
/// over the whole cell; within 0.1 % up to 0.125.                             [sangani-acrivos-1982-spheres]
double sphere_array_drag(double solid_fraction);

}  // namespace veriflex::analytic
