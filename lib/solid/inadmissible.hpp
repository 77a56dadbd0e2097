/// Where the energy of a network does not exist, in words.
#pragma once

#include <string>

#include "solid/elastic.hpp"

namespace veriflex::solid {

/// The first bond, else the first angle, that has no force at displacement u, with its nodes and its length
/// or opening: nodes that coincide, a bond outside its law's domain, an angle that is folded back or flat
/// (see is_defined()). Meant for error messages, after an evaluation has failed there.
std::string what_is_inadmissible(const Material& material, const Network& network, const Positions& u);

}  // namespace veriflex::solid
