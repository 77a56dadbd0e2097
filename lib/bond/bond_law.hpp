/// What a bond law is: one concept, so that every loop over bonds is compiled for its law.
///
/// A law is a plain struct of parameters with the energy of one bond of length r and its first two
/// derivatives. Adding one: see "A new bond law" in ARCHITECTURE.md (one file here, one line in
/// laws.cmake).
#pragma once

#include <array>
#include <concepts>
#include <limits>
#include <string>
#include <string_view>

#include "base/interval.hpp"

namespace veriflex::bond {

/// Dimension of a bond parameter as energy^energy * length^length. Enough for any law without time or mass of
/// its own, and what a rescaling to another modulus and spacing needs (derive.hpp, calibrate()).
struct Dimension {
  int energy;
  int length;
};

/// In mass, length, time: energy^1 length^-2 is "M T^-2".
std::string to_string(Dimension dimension);

/// One named parameter of a law. `symbol`, the one of the formula, is accepted for the name where it is
/// given; empty where the name is the symbol. `fallback` computes the default from the parameters listed
/// before it; a parameter without one must be given.
template <class Law>
struct Parameter {
  std::string_view name;
  std::string_view symbol;
  double Law::*member;
  Dimension dimension;
  std::string_view meaning;
  double (*fallback)(const Law&) = nullptr;
};

constexpr double infinity = std::numeric_limits<double>::infinity();

template <class Law>
concept BondLaw = requires(const Law law, double r) {
  { Law::name } -> std::convertible_to<std::string_view>;
  { Law::parameters().size() } -> std::convertible_to<std::size_t>;
  { law.energy(r) } -> std::same_as<double>;     // U       [M L^2 T^-2]
  { law.tension(r) } -> std::same_as<double>;    // dU/dr   [M L T^-2]; > 0 pulls the ends together
  { law.stiffness(r) } -> std::same_as<double>;  // d2U/dr2 [M T^-2]
  { law.domain() } -> std::same_as<Interval>;    // lengths the law is defined for, open  [L]
  {
    law.typical_length()
    } -> std::same_as<double>;  // of the order of the rest length, where its search starts [L]
  law.check();                  // throws BadParameter
};

/// The one domain predicate: energy, tension and stiffness are defined at r. No law clamps.
template <BondLaw Law>
bool admits(const Law& law, double r) {
  return law.domain().contains(r);
}

/// A law may name the lengths at which its stiffness jumps (`kinks()`); at a kink it returns the limit from
/// above.
template <class Law>
concept HasKinks = BondLaw<Law> && requires(const Law law) {
  law.kinks().begin();
};

/// Throws BadParameter unless `value` is positive and finite.
void require_positive(std::string_view parameter, double value);

}  // namespace veriflex::bond
