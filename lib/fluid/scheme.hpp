/// Force schemes, storages and representations of the fluid, by name. Knows no Eigen, see sweep.hpp.
#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>

#include "base/named.hpp"
#include "fluid/forces.hpp"

namespace veriflex::fluid {

/// What a population or a moment is stored and computed in.
enum class Storage { Double, Float };

inline constexpr std::array storages{
    Named<Storage>{Storage::Double, "double", "double", "64 bits"},
    Named<Storage>{Storage::Float, "float", "float", "32 bits"},
};

/// Calls use(Real{}) with the type that `storage` stands for.
template <class Use>
auto visit(Storage storage, Use use) {
  switch (storage) {
    case Storage::Double:
      return use(double{});
    case Storage::Float:
      return use(float{});
  }
  std::abort();  // there is no other value
}

/// Of one population or moment.
inline std::int64_t bytes_of(Storage storage) {
  return visit(storage, [](auto real) { return static_cast<std::int64_t>(sizeof real); });
}

/// What stands for the state of a node: fifteen populations, or density and momentum, which at tau = 1 are
/// all that a collision keeps (moments.hpp).
enum class Representation { Auto, Populations, Moments };

inline constexpr std::array representations{
    Named<Representation>{Representation::Auto, "auto", "auto",
                          "moments where tau is 1, populations elsewhere"},
    Named<Representation>{Representation::Populations, "populations", "populations",
                          "fifteen populations a node"},
    Named<Representation>{Representation::Moments, "moments", "moments", "density and momentum of a node"},
};

/// How the body force enters: the schemes of forces.cmake. Forces at single nodes are always of first order.
enum class Scheme {
#define VERIFLEX_EACH(Force, id) Force,
#include "fluid/each_force.inc"
#undef VERIFLEX_EACH
};

inline constexpr std::array schemes{
#define VERIFLEX_EACH(Force, id) Named<Scheme>{Scheme::Force, Force::name, #id, Force::text},
#include "fluid/each_force.inc"
#undef VERIFLEX_EACH
};

/// Calls use(Force{}) with the type that `scheme` stands for.
template <class Use>
auto visit(Scheme scheme, Use use) {
  switch (scheme) {
#define VERIFLEX_EACH(Force, id) \
  case Scheme::Force:            \
    return use(Force{});
#include "fluid/each_force.inc"
#undef VERIFLEX_EACH
  }
  std::abort();  // there is no other value
}

}  // namespace veriflex::fluid
