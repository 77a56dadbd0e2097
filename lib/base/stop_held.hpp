/// A stop that waits until a piece of work is whole.
#pragma once

namespace veriflex::stop {

/// While it lives a signal does not yet ask for a stop: it does when this ends. A second one kills all the
/// same. For a step whose state must come out whole; one at a time.
class Held {
 public:
  Held();
  ~Held();
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;
};

}  // namespace veriflex::stop
