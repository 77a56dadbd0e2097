/// A fluid of density and momentum alone: tau = 1.
#pragma once

#include "fluid/fluid.hpp"

namespace veriflex::fluid {

std::unique_ptr<Fluid> make_moment_fluid(const Spec& spec);

/// Its memory: two copies of the moments, and what each thread adds up in  [bytes].
double moment_bytes(const Spec& spec);

}  // namespace veriflex::fluid
