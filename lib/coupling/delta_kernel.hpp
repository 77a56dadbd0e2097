/// What a smoothed delta function is: one concept, so that every loop over nodes and markers is compiled for
/// its kernel.
///
/// A kernel is its weights along one axis; the weight of a node is the product over the axes. Adding one: a
/// file in kernels/ and a line in kernels.cmake. One of four nodes may have a faster way to all four weights,
/// `weigh(inside, weights)`, of a marker between the second and the third.
#pragma once

#include <concepts>
#include <string_view>

namespace veriflex::coupling {

/// Weight phi at distance d in spacings, and how many nodes along an axis can have one.
template <class K>
concept DeltaKernel = requires(double d) {
  { K::name } -> std::convertible_to<std::string_view>;  // in a case file
  { K::text } -> std::convertible_to<std::string_view>;  // in words
  { K::width } -> std::convertible_to<int>;              // at most 4
  { K::in_ball } -> std::convertible_to<bool>;           // nodes at a distance of two or more have no weight
  { K::phi(d) } -> std::same_as<double>;
};

}  // namespace veriflex::coupling
