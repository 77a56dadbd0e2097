/// Signals that ask a run to stop. The loops look at them once per step or oftener, so that what was measured
/// until then is kept.
#pragma once

#include <signal.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <string>

#include "base/error.hpp"

namespace veriflex {

/// A run that a signal has stopped: nothing is wrong with its numbers, but they are not whole.
struct Stopped : NumericalFailure {
  using NumericalFailure::NumericalFailure;
};

namespace stop {

/// The signal that has asked for a stop, 0 if none has.
extern std::atomic<int> signal;

/// Whether one has. For loops of several threads, in which nothing may be thrown: they leave the rest undone,
/// and the caller throws after them.
inline bool asked() { return signal.load(std::memory_order_relaxed) != 0; }

/// Whether a Stopped was thrown since forget(): a study may have taken it for an outcome of its own.
bool was_thrown();
void forget();

/// "interrupted by SIGTERM".
std::string reason();

/// Throws Stopped: the reason, and where the run stood.
[[noreturn]] void here(const char* what, std::int64_t number);

/// While it lives SIGINT, SIGTERM and SIGHUP ask for a stop, unless the program was started with them ignored
/// (nohup); a second one kills.
class Handlers {
 public:
  Handlers();
  ~Handlers();
  Handlers(const Handlers&) = delete;
  Handlers& operator=(const Handlers&) = delete;

 private:
  std::array<struct sigaction, 3> earlier_{};
};

/// While it lives a signal does not yet ask for a stop: it does when this ends. A second one kills all the
/// same. For a step whose state must come out whole; one at a time.
class Held {
 public:
  Held();
  ~Held();
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;
};

}  // namespace stop

/// Throws Stopped when a signal has asked for it: "interrupted by SIGTERM at <what> <number>".
inline void stop_if_asked(const char* what, std::int64_t number) {
  if (stop::asked()) [[unlikely]]
    stop::here(what, number);
}

}  // namespace veriflex
