/// A fluid of populations: any tau.
#pragma once

#include "fluid/fluid.hpp"

namespace veriflex::fluid {

std::unique_ptr<Fluid> make_population_fluid(const Spec& spec);

/// Its memory  [bytes].
double population_bytes(const Spec& spec);

}  // namespace veriflex::fluid
