/// What a scene could do without at a price in accuracy, which only a run can tell: offered, never taken.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace veriflex::scene {

struct Offer {
  std::string what;     // would do
  std::string saves;    // in words
  std::string setting;  // as --set takes it
};

/// Float storage; as few sub-steps as are stable, alone and in the fluid; a box shorter by a quarter along
/// each periodic axis that leaves the bodies room. `substeps_of`: the key of a body's sub-steps. Throws
/// NumericalFailure when a body has no energy where it stands.
std::vector<Offer> offers(const Scene& scene,
                          const std::function<std::string(std::size_t body)>& substeps_of);

}  // namespace veriflex::scene
