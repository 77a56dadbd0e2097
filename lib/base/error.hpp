/// The ways a run can end badly, as types. What each means for the exit code stands in verify/main.cpp.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace veriflex {

/// Where in an input something stands. `line` 0 means the whole file; an empty file means the command line.
struct Place {
  std::string file;
  unsigned line = 0;
  unsigned column = 0;
};

/// `file:line:col`, as much of it as is known.
std::string to_string(const Place& place);

/// A case, reference or option that cannot be used. Message: `file:line:col: problem (why). Suggestion.`
class InputError : public std::runtime_error {
 public:
  InputError(const Place& place, std::string_view problem, std::string_view why, std::string_view suggestion);
};

/// A parameter of a physical model outside its meaning, by name: the reader that knows where the value was
/// written turns it into an InputError.
struct BadParameter : std::invalid_argument {
  BadParameter(std::string_view parameter, std::string_view problem, std::string_view why,
               std::string_view suggestion);
  std::string parameter, problem, why, suggestion;
};

/// A parameter without default that was not given.
struct MissingParameter : BadParameter {
  using BadParameter::BadParameter;
};

/// What a computation left its range of validity by. A study of many runs tells them apart by this.
enum class FailureMode {
  NotFinite,     // a velocity or force is no number
  Density,       // a fluid without positive density
  Mach,          // a fluid faster than its limit
  Bond,          // a bond or an angle outside of its law
  Marker,        // a marker without a place in the box
  TimeStep,      // a step that leap-frog cannot take
  Equilibrium,   // a mechanism, or a state that is not stable
  NotConverged,  // a search or an iteration without an answer
  Coupling,      // an exchange with the fluid that grows
  Energy,        // a body whose energy comes from nowhere
  Unphysical,    // a state that no solid of its kind has, which its law allows
  Buckled,       // a column that has given way sideways
  Other
};

/// Its name in a result file: `not-finite`, `density`, `mach`, ...
std::string to_string(FailureMode mode);

/// A computation that left its range of validity (NaN, a bond at its limit, a singular system).
class NumericalFailure : public std::runtime_error {
 public:
  explicit NumericalFailure(const std::string& message, FailureMode how = FailureMode::Other)
      : std::runtime_error(message), mode(how) {}
  /// The same failure, told with where it was: `where: message`.
  NumericalFailure at(const std::string& where) const {
    return NumericalFailure(where + ": " + what(), mode);
  }
  FailureMode mode;
};

/// A file that could not be written, or a child process that died.
class OutputError : public std::runtime_error {
 public:
  OutputError(std::string_view path, std::string_view problem, std::string_view remedy);
};

/// The name in `known` nearest to `word`, or empty when none is near enough to be a misspelling of it.
std::string nearest_name(std::string_view word, const std::vector<std::string>& known);

}  // namespace veriflex
