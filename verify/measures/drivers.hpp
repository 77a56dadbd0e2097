/// The kinds of study, each in a file of its own.
#pragma once

#include <vector>

#include "engine/study.hpp"

namespace veriflex::measures {

/// Rest state, Young's modulus and validity range of a bond law.                 [wu-qi-2014, Eqs. 21-25]
engine::Study read_derive(const io::Table& top);

/// Static pull on a bar of the law's bonds: stress-strain curve and modulus at zero strain.
engine::Study read_tensile(const io::Table& top);

/// Largest time step that a noisy body survives, against the linear limit.

/// Elastic constants C11, C12, C44 of the infinite lattice, by homogeneous deformation.
engine::Study read_elasticity(const io::Table& top);

/// Bending of beams: stiffness of the section term by term, cantilevers, bending frequencies.
engine::Study read_beam(const io::Table& top);

/// A clamped beam under a large dead load at its tip, against the elastica.
engine::Study read_elastica(const io::Table& top);

/// Critical load of a pinned column, against Euler's and with shear.
engine::Study read_buckling(const io::Table& top);

/// Torsion of square bars, against Saint-Venant's series.
engine::Study read_torsion(const io::Table& top);

/// Shear stiffness of a finite block between plates, against the lattice's G.
engine::Study read_shear(const io::Table& top);

/// Standing waves by dynamics, against the dispersion of the lattice in leap-frog's steps.
engine::Study read_dispersion(const io::Table& top);

/// What leap-frog keeps: momentum, angular momentum, the way back, and energy to second order.
engine::Study read_integrator(const io::Table& top);

/// Forces and motion of the same body turned, renumbered, moved, scaled and on several threads.
engine::Study read_invariance(const io::Table& top);

/// Period of a swinging pair or chain: error of leap-frog against the work done.
engine::Study read_oscillation(const io::Table& top);

/// Flows between walls and through arrays of obstacles against exact solutions and known drag.
engine::Study read_channel(const io::Table& top);

/// Mass, momentum and staggered momentum of a fluid over many steps.
engine::Study read_conservation(const io::Table& top);

/// The solid against a table that another program computed.
engine::Study read_peer(const io::Table& top);

/// Numbers of another program, held against anything that this program's own could be.
engine::Study read_external(const io::Table& top);

/// Plane waves of the fluid against the continuum and against the lattice's own eigenvalues.
engine::Study read_plane_wave(const io::Table& top);

/// Decaying Taylor-Green vortices and shear waves: convergence, and error against run time per storage.
engine::Study read_vortex(const io::Table& top);

/// Viscosity of a fluid that streams through the lattice.
engine::Study read_galilean(const io::Table& top);
engine::Study read_stream_stability(const io::Table& top);

/// The paper's driven filament with two bond laws, and how far they are apart.
/// [wu-qi-2014, Sec. 3, Figs. 5-8]
engine::Study read_filament(const io::Table& top);

/// What the paper leaves open about its filament, one at a time: how far each choice moves it.
engine::Study read_filament_sensitivity(const io::Table& top);

/// The driven filament at small amplitude against linear theory.
engine::Study read_filament_linear(const io::Table& top);

/// Bodies of markers in prescribed motion against known drag and exact oscillating flows.
engine::Study read_immersed(const io::Table& top);

/// A clamped rod in a stream against a beam under the forces that were exchanged.
engine::Study read_crossflow(const io::Table& top);

/// A layer on an oscillating plate, against the exact motion of solid and fluid.
engine::Study read_elastic_layer(const io::Table& top);

/// A free filament between four rolls: growth of its first buckling mode, against the theory of its markers.
engine::Study read_buckling_filament(const io::Table& top);

/// A filament driven at one end: mean force along it, against the theory of its markers and of slender
/// bodies.
/// [wiggins-goldstein-1998]
engine::Study read_filament_thrust(const io::Table& top);

/// Node mass at which the coupling of a rod to the fluid becomes unstable: linearised map against runs.
engine::Study read_coupling_stability(const io::Table& top);

/// Growth of small perturbations of any scene at rest: spectrum of its steps, linearised map, and runs.
engine::Study read_coupled_spectrum(const io::Table& top);

/// Sums and moments of the delta kernels over many positions of a marker.                [wu-qi-2014, Eq. 8]
engine::Study read_delta_moments(const io::Table& top);

/// Any scene: a fluid, bodies, and what is observed of them.
engine::Study read_scene(const io::Table& top);

inline const std::vector<engine::Driver>& all() {
  static const std::vector<engine::Driver> drivers{
      {"derive", "rest state, Young's modulus and validity range of a bond law", &read_derive},
      {"peer", "the solid against a table that another program computed", &read_peer},
      {"external", "another program's own numbers as the measured side", &read_external},
      {"tensile", "static pull on a bar: stress-strain curve and modulus at zero strain", &read_tensile},
      {"elasticity", "elastic constants of the infinite lattice", &read_elasticity},
      {"beam", "bending stiffness, cantilevers and bending frequencies", &read_beam},
      {"elastica", "large deflection of a clamped beam, against the elastica", &read_elastica},
      {"buckling", "critical load of a pinned column, against Euler's and with shear", &read_buckling},
      {"torsion", "torsion of square bars, against Saint-Venant's series", &read_torsion},
      {"shear", "shear stiffness of a block between plates", &read_shear},
      {"dispersion", "standing waves by dynamics, against the lattice's dispersion", &read_dispersion},
      {"integrator", "what leap-frog keeps: momentum, the way back, energy to second order",
       &read_integrator},
      {"invariance", "the same body turned, renumbered, moved, scaled", &read_invariance},
      {"oscillation", "period of a pair or chain: error against run time", &read_oscillation},
      {"plane-wave", "plane waves of the fluid against the continuum and the lattice's eigenvalues",
       &read_plane_wave},
      {"vortex", "decaying vortices and shear waves: convergence, error against run time", &read_vortex},
      {"galilean", "viscosity of a fluid that streams through the lattice", &read_galilean},
      {"stream-stability", "growth of noise on a uniform stream: by eigenvalues of all waves, and in a run",
       &read_stream_stability},
      {"channel", "flows between walls and through arrays of obstacles", &read_channel},
      {"conservation", "mass and momentum of a fluid over many steps", &read_conservation},
      {"filament", "driven filament in the fluid, one bond law against another", &read_filament},
      {"filament-sensitivity", "the driven filament with each open choice varied",
       &read_filament_sensitivity},
      {"filament-linear", "the driven filament at small amplitude against linear theory",
       &read_filament_linear},
      {"immersed", "bodies of markers in prescribed motion, against known drag", &read_immersed},
      {"crossflow", "clamped rod in a stream, against a beam under the same forces", &read_crossflow},
      {"elastic-layer", "elastic layer on an oscillating plate, against its exact motion",
       &read_elastic_layer},
      {"buckling-filament",
       "free filament in a straining flow: growth of its first buckling mode, against theory",
       &read_buckling_filament},
      {"filament-thrust", "thrust of a filament driven at one end, against theory", &read_filament_thrust},
      {"coupling-stability", "smallest stable node mass of a coupled rod: linearised map against runs",
       &read_coupling_stability},
      {"coupled-spectrum", "growth of small perturbations of a scene: its spectrum, the linearised map, runs",
       &read_coupled_spectrum},
      {"scene", "any scene of a fluid and bodies, and what is observed of it", &read_scene},
      {"delta-moments", "sums and moments of the delta kernels", &read_delta_moments},
  };
  return drivers;
}

}  // namespace veriflex::measures
