/// Lattice units and units for people: conversion both ways, and which numbers of a scene are good ones.
///
/// A spacing is `spacing` metres, a step `time_step` seconds, and the fluid's density of 1 is `density`
/// kg/m^3, so that the unit of mass is density spacing^3.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/quantity.hpp"
#include "io/document.hpp"

namespace veriflex::engine {

struct Units {
  double spacing;    // [m]
  double time_step;  // [s]
  double density;    // [kg/m^3]

  /// What a number in lattice units of M^mass L^length T^time is to be multiplied with for SI.
  double factor(int mass, int length, int time) const;
};

/// What [units] says beside the units: a speed [m/s] and a length [m] that the flow is told by.
struct CaseUnits {
  Units units;
  std::optional<double> speed{}, length{};
};

/// [units] of a case; nothing without the table. Throws InputError.
std::optional<CaseUnits> read_units(const io::Table& top);

/// What a scene is told by, in lattice units. What is not there has no speed, length or fluid.
struct Told {
  std::optional<double> relaxation_time{};
  std::optional<double> speed{}, length{};  // of the flow
  struct Body {
    std::string name;
    double young_modulus;  // along the bonds, at rest
    double density;        // node mass over spacing^3
    bool is_coupled;
  };
  std::vector<Body> bodies{};
};

/// Its numbers in both systems, each judged: tau, viscosity, Mach number, Reynolds numbers of flow and grid,
/// resolution; E, density ratio and Cauchy number of each body.
std::vector<Quantity> quantities(const Told& told, const std::optional<Units>& units);

/// A flow in SI, and how it is to be resolved.
struct Physical {
  double viscosity;                         // kinematic [m^2/s]
  double speed;                             // [m/s]
  double length;                            // [m]
  double density;                           // of the fluid [kg/m^3]
  double spacings;                          // of the lattice on the length
  std::optional<double> young_modulus{};    // [Pa]
  std::optional<double> solid_density{};    // [kg/m^3]
  std::optional<double> relaxation_time{};  // asked for; without it
  double mach = 0.05;                       // is
};

struct Lattice {
  Units units;
  Told told;
};

/// The lattice values of such a flow. Throws BadParameter for what is not positive, and a tau of 1/2 or less.
Lattice lattice_of(const Physical& flow);

}  // namespace veriflex::engine
