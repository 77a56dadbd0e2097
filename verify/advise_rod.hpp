/// Settings for a flexible rod in a flow that is given in physical numbers: each with the study that it comes
/// from, or the reason why it follows from the others, or that nothing here knows it.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/units.hpp"

namespace veriflex {

struct RodInFlow {
  /// `length` is the rod's diameter; resolution and relaxation time are what is asked for.
  engine::Physical flow{.viscosity = 0.0, .speed = 0.0, .length = 0.0, .density = 1000.0, .spacings = 0.0};
  double rod_length = 0.0;  // [m]
  double amplitude = 0.0;   // how far it is moved  [m]
  std::optional<double>
      duration{};  // of the run; else in which the flow passes the rod's length ten times  [s]
};

/// One setting of the case.
struct Advised {
  std::string setting;  // `key=value`, or what is not known
  std::string why;      // what it comes from
};

struct RodAdvice {
  std::vector<Advised> settings;
  std::vector<engine::Quantity> quantities;
  double error = 0.0;                         // sum of what the settings contribute
  std::vector<std::string> errors;            // its terms, and what is not in it
  std::optional<double> seconds{}, memory{};  // of a run  [s], [bytes]
  std::optional<double> coupling_growth{};    // of an elastic rod, see scene::coupling_growth()
  std::string scene;  // with these settings, a case of driver `scene` but for its `id`
};

/// The scene is a rod along y, clamped at its first section, in a stream along z that enters and leaves; or,
/// with an amplitude, driven there along z in a fluid at rest, at most with the speed.
/// From the stored results of `cost-cylinder-markers` and, where it is there, `cost-filament` in that folder.
/// Throws InputError without the first and for numbers that are not positive, NumericalFailure for an error
/// that these studies cannot reach.
RodAdvice advise_rod(const RodInFlow& rod, double error, const std::filesystem::path& results, int threads);

}  // namespace veriflex
