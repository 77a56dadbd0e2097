/// The keys `method` and `residual` of a driver that looks for equilibria.
#pragma once

#include <fmt/format.h>

#include <vector>

#include "base/parts.hpp"
#include "io/document.hpp"
#include "solid/relax.hpp"

namespace veriflex::measures {

inline solid::Statics read_statics(const io::Table& t) {
  solid::Statics statics;
  if (t.has("method"))
    statics.method = row_named(solid::relaxations, t.choice("method", names_of(solid::relaxations))).value;
  statics.residual = t.number("residual", statics.residual);
  if (!(statics.residual >= 1e-14 && statics.residual < 1.0)) {
    t.fail("residual", fmt::format("'residual' is {}", statics.residual),
           "it is an out-of-balance force over the largest, from 1e-14 to below 1", "Use 1e-12");
  }
  return statics;
}

/// What a search builds.
inline std::vector<parts::Kind> parts_of(const solid::Statics& statics) {
  if (statics.method == solid::Relaxation::DampedDynamics)
    return {parts::Kind::LeapFrog, parts::Kind::Constraints};
  return {parts::Kind::Statics};
}

}  // namespace veriflex::measures
