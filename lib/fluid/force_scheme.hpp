/// How a body force enters a collision: one concept, so that the sweep is compiled for each scheme.
///
/// A scheme says what it adds to the quantities of collide.hpp, as multiples of the body force g per volume.
/// Adding one: a file in forces/ and a line in forces.cmake.
#pragma once

#include <concepts>
#include <string_view>

namespace veriflex::fluid {

template <class F>
concept ForceScheme = requires(double omega) {
  { F::name } -> std::convertible_to<std::string_view>;  // in a case file
  { F::text } -> std::convertible_to<std::string_view>;  // in words
  { F::shifts_velocity } -> std::convertible_to<bool>;   // (sum f c + g/2)/rho enters the equilibrium
  { F::changes_N } -> std::convertible_to<bool>;         // whether of_N is anything but 0
  { F::of_N(omega) } -> std::same_as<double>;            // what N gets beyond omega J; omega = 1/tau
  { F::beyond_N(omega) } -> std::same_as<double>;        // what M of the diagonal pairs gets beyond N
};

}  // namespace veriflex::fluid
