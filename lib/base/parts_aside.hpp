/// What is built on the way to a scene, and is no part of it.
#pragma once

#include "base/parts.hpp"

namespace veriflex::parts {

/// What is built while it lives does not count as built: a state that is put back may need more than the run
/// that it came from.
class Aside {
 public:
  Aside() = default;
  ~Aside();
  Aside(const Aside&) = delete;
  Aside& operator=(const Aside&) = delete;

 private:
  AllMade made_ = made();
};

}  // namespace veriflex::parts
